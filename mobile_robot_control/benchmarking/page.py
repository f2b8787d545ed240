"""The page of a benchmark: laws by tracks, ranks, paths and errors as small pictures, failures and gains."""

import math
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from statistics import fmean
from typing import Any

from mobile_robot_control.benchmarking.cell import was_searched
from mobile_robot_control.benchmarking.engine import is_first, law_summaries, rank_text
from mobile_robot_control.loop.metric_table import METRIC_TABLE
from mobile_robot_control.pages import page
from mobile_robot_control.pages.page import asset
from mobile_robot_control.runs.words import quantity, three_digits
from mobile_robot_control.system.files import write_atomically

Pictures = Mapping[str, Mapping[str, Mapping[str, Sequence[float]] | None]]
"""By track and law: time, path, reference and error of one run."""
_SIDE, _WIDTH, _HEIGHT = 120.0, 200.0, 70.0
_LINE, _REFERENCE = 'class="line"', 'class="reference"'
_STYLE = """
table.sortable th button{font:inherit;color:inherit;background:none;border:0;padding:0;cursor:pointer;
text-align:inherit;text-decoration:underline dotted;min-height:1.5rem}
th[aria-sort=ascending] button::after{content:' ▲'}th[aria-sort=descending] button::after{content:' ▼'}
.multiples{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,21.5rem),1fr));gap:.75rem}
.multiples figure{border:1px solid var(--faint);border-radius:4px;padding:.4rem}
.multiples figcaption{color:var(--ink);font-size:.85rem}
.multiples svg{max-width:100%;height:auto;vertical-align:bottom}
.multiples text{font-size:9px;fill:var(--soft)}
.line{fill:none;stroke:var(--robot-1);stroke-width:1.5}.reference{fill:none;stroke:var(--path);stroke-width:3}
.axis{stroke:var(--faint)}
details.track{border-top:1px solid var(--faint);padding:.4rem 0}details.track>summary{font-weight:600}
"""
_HEAD = ('law', 'track', 'ranks', 'success', 'of', 'at least', 'RMS error, median', '95 %', 'largest error',
         'settling time', 'peak torque', 'energy', 'variation', 'RMS error, fed forward', 'one step')


def _cell(text: str, value: float | None) -> str:
    """Return a cell that is sorted by a value."""
    return text if value is None else f'<data value="{value!r}">{escape(text)}</data>'


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table that one can sort."""
    return page.html_table(head, rows).replace('<table>', '<table class="sortable">', 1)


def _row(values: Mapping[str, Any], row: Mapping[str, Any], several: bool) -> list[str]:
    """Return the cells of a law on a track."""
    track = f'{row["track"]}, seed {row["seed"]}, {row["budget"]}' if several else row['track']
    if row['reason']:
        return [page.breakable(row['law']), page.breakable(track), _cell(rank_text(row), row['rank']),
                'failed' if was_searched(row) else '–', *['–'] * (len(_HEAD) - 4)]
    variation, unit = ((row['torque_variation'], 'N m') if row['torque_variation'] is not None else
                       (row['command_variation'], 'm/s'))
    return [page.breakable(row['law']), page.breakable(track), _cell(rank_text(row), row['rank']),
            str(row['successes']), str(values['runs']), f'{100.0 * row["success_interval"][0]:.1f} %',
            *(quantity(row[name], unit) for name, unit in (
                ('rms', 'm'), ('rms_95', 'm'), ('worst', 'm'), ('settling_time', 's'), ('peak_wheel_torque', 'N m'),
                ('energy', 'J'))), quantity(variation, unit), quantity(row['fed_rms'], 'm'),
            quantity(row['step_time'], 's')]


def _ranks(values: Mapping[str, Any], budget: int) -> str:
    """Return the table of ranks with a budget: a row a law, a column a track, a range for each seed."""
    found = {(row['law'], row['track'], row['seed']): row for row in values['results'] if row['budget'] == budget}
    rows = []
    for one in law_summaries({**values, 'results': list(found.values())}):
        cells = []
        for track in values['tracks']:
            ranges = [found[one.law, track, seed] for seed in values['seeds']]
            text = ', '.join(map(rank_text, ranges))
            ranked = [0.5 * (row['rank'] + row['last_rank']) for row in ranges if was_searched(row)]
            mean = fmean(ranked) if ranked else None
            best = all(map(is_first, ranges))
            cells.append(f'<span class="best">{_cell(text, mean)}</span>' if best else _cell(text, mean))
        known = [_cell(f'{one.mean_rank:.1f}', one.mean_rank), _cell(f'{one.first} of {one.tables}', one.first),
                 _cell(f'{100.0 * one.success:.1f} %', one.success)]
        rows.append([page.breakable(one.law), *(known if one.tables else ['–'] * 3), *cells])
    return _table(['law', 'mean rank', 'first', 'success', *values['tracks']], rows)


def _points(xs: Sequence[float], ys: Sequence[float]) -> str:
    return ' '.join(f'{x:.1f},{y:.1f}' for x, y in zip(xs, ys, strict=True) if math.isfinite(x + y))


def _multiple(law: str, drawn: Mapping[str, Sequence[float]], largest: float) -> str:
    """Return path and error of a run as a figure."""
    xs, ys = drawn['reference_x'], drawn['reference_y']
    size = 1.25 * max(max(xs) - min(xs), max(ys) - min(ys), 0.1)
    left, top = 0.5 * (max(xs) + min(xs) - size), 0.5 * (max(ys) + min(ys) + size)

    def placed(along: Sequence[float], up: Sequence[float]) -> str:
        return _points([(x - left) / size * _SIDE for x in along], [(top - y) / size * _SIDE for y in up])

    span, begun = max(drawn['time'][-1] - drawn['time'][0], 1e-9), drawn['time'][0]
    error = _points([(t - begun) / span * _WIDTH for t in drawn['time']],
                    [_HEIGHT * (1.0 - min(e / largest, 1.5)) + 12.0 for e in drawn['error']])
    final = drawn['error'][-1]
    return (
        f'<figure><figcaption>{escape(law)}</figcaption>'
        f'<svg width="{_SIDE:g}" height="{_SIDE:g}" viewBox="0 0 {_SIDE:g} {_SIDE:g}" role="img" '
        f'aria-label="path of {escape(law)}"><polyline {_REFERENCE} points="{placed(xs, ys)}"/>'
        f'<polyline {_LINE} points="{placed(drawn["x"], drawn["y"])}"/></svg> '
        f'<svg width="{_WIDTH:g}" height="100" viewBox="0 0 {_WIDTH:g} 100" role="img" '
        f'aria-label="position error of {escape(law)}, at the end {three_digits(1e3 * final)} mm">'
        f'<line class="axis" x1="0" y1="82" x2="{_WIDTH:g}" y2="82"/><polyline {_LINE} points="{error}"/>'
        f'<text x="{_WIDTH:g}" y="9" text-anchor="end">{three_digits(1e3 * largest)} mm</text>'
        f'<text x="0" y="95">0 s</text><text x="{_WIDTH:g}" y="95" text-anchor="end">{span:.3g} s</text></svg>'
        '</figure>')


def _pictures(values: Mapping[str, Any], pictures: Pictures) -> Iterator[str]:
    """Yield the small pictures of each track, folded."""
    for n, (name, track) in enumerate(values['tracks'].items()):
        drawn = {law: one for law, one in pictures.get(name, {}).items() if one}
        settled = [max(one['error'][len(one['error']) // 2:]) for one in drawn.values()]
        # of the second half, in which the laws differ; what is larger leaves the picture
        largest = max(1e-4, 2.0 * sorted(settled)[len(settled) // 2]) if settled else 1.0
        figures = ''.join(_multiple(law, one, largest) for law, one in drawn.items())
        yield (f'<details class="track"{" open" if n == 0 else ""}><summary>{escape(name)}</summary>'
               f'<p class="soft">{escape(track["purpose"])}</p><div class="multiples">{figures}</div></details>')


def _failures(values: Mapping[str, Any]) -> list[list[str]]:
    """Return where laws fail: law, track, how many runs, and why."""
    return [[page.breakable(row['law']), page.breakable(row['track']), str(row['seed']), str(row['budget']),
             escape(row['reason']) if row['reason'] else
             _cell(f'{row["runs"] - row["successes"]} of {row["runs"]} runs', (row['runs'] - row['successes']))]
            for row in values['results'] if row['reason'] or row['successes'] < row['runs']]


def _published(values: Mapping[str, Any]) -> str:
    """Return the numbers of publications beside ours, as HTML."""
    parts = []
    for name, track in values['tracks'].items():
        rows = [[page.breakable(one['law']), escape(', '.join(f'{gain} = {value}' for gain, value in
                                                             one['gains'].items())), page.breakable(metric),
                 quantity(value, METRIC_TABLE[metric].unit), quantity(one['ours'][metric], METRIC_TABLE[metric].unit)]
                for one in track['published'] for metric, value in one['published'].items()]
        if rows:
            parts.append(f'<p>{escape(name)}: {escape(track["source"])}, with the gains that it gives.</p>'
                         + page.html_table(['law', 'gains', 'metric', 'published', 'ours'], rows))
    return ''.join(parts)


def _gains(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield the gains of each law, folded."""
    for law in values['laws']:
        lines = [f'{row["track"]}, seed {row["seed"]}, budget {row["budget"]}: ' + ', '.join(
            f'{name.partition(".")[2]} = {value}' for name, value in row['gains'].items())
            for row in values['results'] if row['law'] == law and row['gains']]
        yield (f'<details class="track"><summary>{escape(law)}</summary><pre tabindex="0"><code>'
               f'{escape(chr(10).join(lines))}</code></pre></details>')


def answer(values: Mapping[str, Any]) -> str:
    """Return the result in a sentence."""
    best, *others = law_summaries(values)
    if not best.tables:
        return f'No law was searched: {values["results"][0]["reason"]}.'
    told = f'{best.law} has the best mean rank, {best.mean_rank:.1f}, of {len(values["laws"])} laws'
    return (f'{told}; on {best.first} of {best.tables} tracks no law is better for certain.' if others else
            f'{best.law} succeeds in {100.0 * best.success:.1f} % of the runs.')


def _parts(values: Mapping[str, Any], pictures: Pictures, made: Mapping[str, Any]) -> Iterator[str]:
    """Yield the page from top to bottom, as HTML."""
    several = len(values['seeds']) * len(values['budgets'] or [0]) > 1
    budgets = ', '.join(map(str, values['budgets'])) or 'none: gains as configured'
    yield f'<section class="first"><h1>Benchmark</h1><p class="answer">{escape(answer(values))}</p></section>'
    yield (f'<p class="soft">Candidates of each search: {budgets}. Seeds: {", ".join(map(str, values["seeds"]))}. '
           f'Scenarios of a search: {values["scenarios"]}; scenarios that judge: {values["runs"]}. Hash '
           f'<code>{values["hash"]}</code>.</p>')
    failures, published = _failures(values), _published(values)
    yield page.contents([('ranks', 'Ranks', ()), ('numbers', 'Numbers', ()), ('pictures', 'Paths and errors', ()),
                         *([('failures', 'Failures', ())] if failures else []),
                         *([('published', 'Published', ())] if published else []), ('gains', 'Gains', ())])
    yield page.section('ranks', 'Ranks', '<p class="soft">The ranks that a law may have on each track, the best mean '
                       'rank first. Laws that paired differences cannot tell apart have a rank in common; bold: no law '
                       'is better for certain, and half of the runs succeed. One search stands behind each range: it '
                       'minimises Eq. (29), and the RMS error ranks. A law whose search could drive no candidate is '
                       'not searched, and counts in no mean. A head sorts.</p>',
                       *(f'{f"<h3>{budget} candidates</h3>" if several else ""}{_ranks(values, budget)}'
                         for budget in values['budgets'] or [0]))
    yield page.section('numbers', 'Numbers', '<p class="soft">Errors, settling time, torque, energy and variation are '
                       'those of the scenarios in which all compared laws succeed, their medians where nothing else is '
                       'said; without feedforward, but in its column.</p>',
                       _table(_HEAD, [_row(values, row, several) for row in values['results']]))
    yield page.section('pictures', 'Paths and errors', '<p class="soft">The first scenario that judges: path (blue) '
                       'on that of the cart (grey), and the position error, on the scale of the second half of the '
                       'run.</p>', *_pictures(values, pictures))
    if failures:
        yield page.section('failures', 'Where each law fails', _table(['law', 'track', 'seed', 'budget', 'failed'],
                                                                      failures))
    if published:
        yield page.section('published', 'Published numbers', published)
    yield page.section('gains', 'Gains', *_gains(values))
    yield page.made_with(made)


def write_benchmark_page(file: Path, values: Mapping[str, Any], pictures: Pictures, made: Mapping[str, Any]) -> None:
    """
    Write the page of a benchmark.

    Parameters
    ----------
    file : Path
        HTML.
    values : mapping of str to object
        As `benchmark.json`.
    pictures : mapping
        One run of each law on each track.
    made : mapping of str to object
        What `provenance` returns.
    """
    write_atomically(file, page.page('Benchmark', _parts(values, pictures, made), [_STYLE],
                                     [asset('basics.js'), asset('benchmark.js')]))
