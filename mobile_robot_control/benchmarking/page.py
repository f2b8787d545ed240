"""The page of a benchmark: laws by tracks, ranks, paths and errors as small pictures, failures and gains."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from mobile_robot_control.benchmarking.cell_result import CONFIGURED, FED, DrivenPath
from mobile_robot_control.benchmarking.table import is_first, last_summary
from mobile_robot_control.benchmarking.words import (
    law_text,
    node_lines,
    place_text,
    rank_text,
    seeds_sentence,
    undone_lines,
    unrepeatable,
)
from mobile_robot_control.loop.metric_table import METRIC_TABLE
from mobile_robot_control.pages import page
from mobile_robot_control.pages.page import asset
from mobile_robot_control.runs.words import quantity, three_digits
from mobile_robot_control.system.files import write_atomically

Paths = Mapping[str, Mapping[str, DrivenPath | None]]
"""By track and law."""
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
.errors{max-width:44rem}
details.track{border-top:1px solid var(--faint);padding:.4rem 0}details.track>summary{font-weight:600}
"""
_HEAD = ('law', 'track', 'gains', 'seed', 'budget', 'success', 'at least', 'RMS error, median', '95 %',
         'largest error', 'settling time', 'peak torque', 'energy', 'variation', 'RMS error of the search',
         'Eq. (29) of the search', 'searches that agree', 'gains at an edge', 'one step')
_RANKS = ('law', 'ranks', 'error to the best', 'interval', 'RMS error, median', 'success', 'converged', 'at an edge',
          'as configured', 'with feedforward')


def _cell(text: str, value: float | None) -> str:
    """Return a cell that is sorted by a value."""
    return text if value is None else f'<data value="{value!r}">{escape(text)}</data>'


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table that one can sort."""
    return page.html_table(head, rows).replace('<table>', '<table class="sortable">', 1)


def _row(row: Mapping[str, Any]) -> list[str]:
    """Return the cells of a law on a track with one seed."""
    head = [page.breakable(row['law']), page.breakable(row['track']), row['gains'], str(row['seed']),
            str(row['budget'])]
    if not row['runs']:
        return [*head, *['–'] * (len(_HEAD) - len(head))]
    variation, unit = ((row['torque_variation'], 'N m') if row['torque_variation'] is not None else
                       (row['command_variation'], 'm/s'))
    return [*head, f'{row["successes"]} of {row["runs"]}', f'{100.0 * row["success_interval"][0]:.1f} %',
            *(quantity(row[name], unit) for name, unit in (
                ('rms', 'm'), ('rms_95', 'm'), ('worst', 'm'), ('settling_time', 's'), ('peak_wheel_torque', 'N m'),
                ('energy', 'J'))), quantity(variation, unit), quantity(row['rms_searched'], 'm'),
            quantity(row['eq29'], ''),
            '–' if row['agreeing'] is None else str(row['agreeing']),
            str(len(row['at_edge'])), quantity(row['step_time'], 's')]


def _ratio(row: Mapping[str, Any]) -> tuple[str, str]:
    """Return an error as a multiple of the best law's, and its interval, as cells."""
    low, high = row['ratio_interval'] or (None, None)
    ratio = '–' if row['ratio'] is None else _cell(f'{row["ratio"]:.2f}', row['ratio'])
    return ratio, '–' if low is None else f'{low:.2f} to {high:.2f}'


def _other(row: Mapping[str, Any], kind: str) -> str:
    """Return error and success with other gains as a cell."""
    success = row[f'{kind}_success']
    if success is None:
        return '–'
    return quantity(row[f'{kind}_rms'], 'm') + (f', {100.0 * success:.0f} %' if success < 1.0 else '')


def _summary(values: Mapping[str, Any]) -> str:
    """Return the table of laws over all tracks."""
    rows = []
    for row in last_summary(values):
        ratio, success = row['largest_ratio'], row['least_success']
        rows.append([page.breakable(law_text(values, row['law'])), _cell(place_text(row), row['place']),
                     _cell(f'{row["unbeaten"]} of {row["tracks"]}', row['unbeaten']),
                     _cell(f'{row["wins"]} of {row["comparisons"]}', row['wins']), str(row['losses']),
                     '–' if ratio is None else _cell(f'{ratio:.2f}, {row["largest_on"]}', ratio),
                     '–' if success is None else _cell(f'{100.0 * success:.1f} %, {row["least_on"]}', success),
                     ', '.join(map(page.breakable, [*row['failed'], *row['not_searched']]))])
    return _table(['law', 'place', 'unbeaten on', 'better', 'worse', 'largest error to the best', 'least success',
                   'fails or not searched on'], rows)


def _track(values: Mapping[str, Any], track: str, budget: int) -> str:
    """Return the table of the laws of a track."""
    rows = []
    for row in values['ranks']:
        if (row['track'], row['budget']) != (track, budget):
            continue
        law = page.breakable(law_text(values, row['law']))
        if row['rank'] is None:
            rows.append([law, rank_text(row), *['–'] * (len(_RANKS) - 2)])
            continue
        ranks = _cell(rank_text(row), row['rank'])
        rows.append([
            law, f'<span class="best">{ranks}</span>' if is_first(row) else ranks, *_ratio(row),
            quantity(row['rms'], 'm'), _cell(f'{100.0 * row["success"]:.1f} %', row['success']),
            '–' if row['converged'] is None else f'{row["converged"]} of {row["seeds"]}',
            '–' if row['at_edge'] is None else str(row['at_edge']),
            _other(row, CONFIGURED), _other(row, FED)])
    return _table(_RANKS, rows)


def _points(xs: Sequence[float], ys: Sequence[float]) -> str:
    return ' '.join(f'{x:.1f},{y:.1f}' for x, y in zip(xs, ys, strict=True) if math.isfinite(x + y))


def _multiple(law: str, path: DrivenPath, largest: float) -> str:
    """Return path and error of a run as a figure."""
    xs, ys = path.reference_x, path.reference_y
    size = 1.25 * max(max(xs) - min(xs), max(ys) - min(ys), 0.1)
    left, top = 0.5 * (max(xs) + min(xs) - size), 0.5 * (max(ys) + min(ys) + size)

    def placed(along: Sequence[float], up: Sequence[float]) -> str:
        return _points([(x - left) / size * _SIDE for x in along], [(top - y) / size * _SIDE for y in up])

    span, begun = max(path.time[-1] - path.time[0], 1e-9), path.time[0]
    error = _points([(t - begun) / span * _WIDTH for t in path.time],
                    [_HEIGHT * (1.0 - min(e / largest, 1.5)) + 12.0 for e in path.error])
    final = path.error[-1]
    return (
        f'<figure><figcaption>{escape(law)}</figcaption>'
        f'<svg width="{_SIDE:g}" height="{_SIDE:g}" viewBox="0 0 {_SIDE:g} {_SIDE:g}" role="img" '
        f'aria-label="path of {escape(law)}"><polyline {_REFERENCE} points="{placed(xs, ys)}"/>'
        f'<polyline {_LINE} points="{placed(path.x, path.y)}"/></svg> '
        f'<svg width="{_WIDTH:g}" height="100" viewBox="0 0 {_WIDTH:g} 100" role="img" '
        f'aria-label="position error of {escape(law)}, at the end {three_digits(1e3 * final)} mm">'
        f'<line class="axis" x1="0" y1="82" x2="{_WIDTH:g}" y2="82"/><polyline {_LINE} points="{error}"/>'
        f'<text x="{_WIDTH:g}" y="9" text-anchor="end">{three_digits(1e3 * largest)} mm</text>'
        f'<text x="0" y="95">0 s</text><text x="{_WIDTH:g}" y="95" text-anchor="end">{span:.3g} s</text></svg>'
        '</figure>')


def _pictures(values: Mapping[str, Any], paths: Paths) -> Iterator[str]:
    """Yield the small pictures of each track, folded."""
    for n, (name, track) in enumerate(values['tracks'].items()):
        driven = {law: path for law, path in paths.get(name, {}).items() if path}
        settled = [max(path.error[len(path.error) // 2:]) for path in driven.values()]
        # of the second half, in which the laws differ; what is larger leaves the picture
        largest = max(1e-4, 2.0 * sorted(settled)[len(settled) // 2]) if settled else 1.0
        figures = ''.join(_multiple(law, path, largest) for law, path in driven.items())
        yield (f'<details class="track"{" open" if n == 0 else ""}><summary>{escape(name)}</summary>'
               f'<p class="soft">{escape(track["purpose"])}</p><div class="multiples">{figures}</div></details>')


def _failures(values: Mapping[str, Any]) -> list[list[str]]:
    """Return where laws fail: law, track, how many runs, and why."""
    return [[page.breakable(row['law']), page.breakable(row['track']), row['gains'], str(row['seed']),
             str(row['budget']), escape(row['reason']) if row['reason'] else
             _cell(f'{row["runs"] - row["successes"]} of {row["runs"]} runs', (row['runs'] - row['successes']))]
            for row in values['results'] if row['reason'] or row['successes'] < row['runs']]


def _published(values: Mapping[str, Any]) -> str:
    """Return the numbers of publications beside ours, as HTML."""
    parts = []
    for name, track in values['tracks'].items():
        rows = [[page.breakable(entry['law']), escape(', '.join(f'{gain} = {value}' for gain, value in
                                                             entry['gains'].items())), page.breakable(metric),
                 quantity(value, METRIC_TABLE[metric].unit), quantity(entry['ours'][metric], METRIC_TABLE[metric].unit)]
                for entry in track['published'] for metric, value in entry['published'].items()]
        if rows:
            parts.append(f'<p>{escape(name)}: {escape(track["source"])}, with the gains that it gives.</p>'
                         + page.html_table(['law', 'gains', 'metric', 'published', 'ours'], rows))
    return ''.join(parts)


def _gains(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield the gains of each law, folded."""
    for law in dict.fromkeys(row['law'] for row in values['results']):
        lines = [f'{row["track"]}, {row["gains"]}, seed {row["seed"]}, budget {row["budget"]}: ' + ', '.join(
            f'{name.partition(".")[2]} = {value}' for name, value in row['values'].items())
            + ''.join(f'; {edge}' for edge in row['at_edge'])
            for row in values['results'] if row['law'] == law and row['values']]
        yield (f'<details class="track"><summary>{escape(law)}</summary><pre tabindex="0"><code>'
               f'{escape(chr(10).join(lines))}</code></pre></details>')


def answer(values: Mapping[str, Any]) -> str:
    """Return the result in a sentence."""
    rows = last_summary(values)
    if values.get('against'):
        return ' '.join(_beaten(one) for one in rows if one['law'] in values['against']['added'])
    best, *others = rows
    if best['place'] is None:
        return f'No law was searched: {values["results"][0]["reason"]}.'
    if not best['comparisons'] or not others:
        return f'{best["law"]} succeeds in {100.0 * best["least_success"]:.1f} % of the runs or more.'
    return _beaten(best)


def _beaten(row: Mapping[str, Any]) -> str:
    """Return where no law is known to beat one, in a sentence."""
    if row['place'] is None:
        return f'{row["law"]} was not searched.'
    return (f'No law is known to beat {row["law"]} on {row["unbeaten"]} of {row["tracks"]} tracks; of '
            f'{row["comparisons"]} comparisons it is better in {row["wins"]} and worse in {row["losses"]}.')


def _picture(svg: str) -> str:
    """Return the picture of the laws, as HTML."""
    return page.picture('Errors', 'A dot for each track.', page.drawing(svg), name='errors')


def _missing(values: Mapping[str, Any]) -> str:
    """Return what is not finished, and how to go on, as HTML."""
    counts = Counter(f'{one["track"]}{" with feedforward" * one["feedforward"]}' for one in values['unfinished'])
    listed = ', '.join(f'{count} on {name}' for name, count in counts.items())
    return (f'<details class="track"><summary>Not finished: {len(values["unfinished"])} cells; the same command with '
            f'--resume goes on</summary><p>{escape(listed)}</p></details>')


def _parts(
    values: Mapping[str, Any], paths: Paths, svg: str, origin: Mapping[str, Any]
) -> Iterator[str]:
    """Yield the page from top to bottom, as HTML."""
    budgets = ', '.join(map(str, values['budgets'])) or 'none: gains as configured'
    of_table = f', against the table <code>{values["against"]["hash"]}</code>' if values.get('against') else ''
    yield f'<section class="first"><h1>Benchmark</h1><p class="answer">{escape(answer(values))}</p></section>'
    yield (f'<p class="soft">{escape(seeds_sentence(values))} Candidates of each search: {budgets}; searches with '
           f'other seeds: {values["restarts"]}. Scenarios of a search: {values["scenarios"]}; scenarios that judge: '
           f'{values["runs"]}. Hash <code>{values["hash"]}</code>{of_table}.</p>')
    if values['unfinished']:
        yield _missing(values)
    if values.get('not_loaded'):
        yield page.warning('Not loaded', [*values['not_loaded'].values()])
    if values.get('against') and values['against']['undone']:
        yield page.warning('Among more comparisons, no more certain than before', [*undone_lines(values)])
    if values.get('not_repeatable'):
        yield page.warning('Not repeatable', [*map(unrepeatable, values['not_repeatable'])])
    if values.get('nodes'):
        yield ''.join(f'<p class="soft">{escape(line)}.</p>' for line in node_lines(values))
    failures, published = _failures(values), _published(values)
    yield page.contents([('laws', 'Laws', ()), ('tracks', 'Tracks', ()), ('pictures', 'Paths and errors', ()),
                         *([('failures', 'Failures', ())] if failures else []),
                         *([('published', 'Published', ())] if published else []), ('numbers', 'Numbers', ()),
                         ('gains', 'Gains', ())])
    yield page.section('laws', 'Laws', '<p class="soft">A law is unbeaten on a track if no law is known to be better '
                       'there; undecided is not equal. Better and worse: comparisons with another law that are '
                       'certain. Place: by majority of these, with its range when any track or group is left out. '
                       'Errors are multiples of that of the best law on a track. A head sorts.</p>',
                       f'<div class="errors">{_picture(svg)}</div>' if svg else '',
                       _summary(values))
    yield page.section('tracks', 'Tracks', '<p class="soft">The ranks that a law may have: two laws differ where '
                       'paired differences over seeds tell them apart, all pairs together with 95 %; bold: no law is '
                       'known to be better. Searches have converged where two with other seeds end within 2 % of the '
                       'best one. A law whose search could drive no candidate is not searched, and has no '
                       'rank.</p>',
                       *(f'<h3>{escape(name)}{f", {budget} candidates" * (len(values["budgets"]) > 1)}</h3>'
                         f'<p class="soft">{escape(track["purpose"])}</p>{_track(values, name, budget)}'
                         for name, track in values['tracks'].items() for budget in values['budgets'] or [0]))
    yield page.section('pictures', 'Paths and errors', '<p class="soft">The first scenario that judges: path (blue) '
                       'on that of the cart (grey), and the position error, on the scale of the second half of the '
                       'run.</p>', *_pictures(values, paths))
    if failures:
        yield page.section('failures', 'Where each law fails', '<details class="track"><summary>All cells with a '
                           'failure</summary>', _table(['law', 'track', 'gains', 'seed', 'budget', 'failed'], failures),
                           '</details>')
    if published:
        yield page.section('published', 'Published numbers', published)
    yield page.section('numbers', 'Numbers', '<details class="track"><summary>All cells, over the runs in which a law '
                       'succeeds</summary>', _table(_HEAD, [_row(row) for row in values['results']]), '</details>')
    yield page.section('gains', 'Gains', *_gains(values))
    yield page.made_with(origin)


def write_benchmark_page(
    file: Path, values: Mapping[str, Any], paths: Paths, svg: str, origin: Mapping[str, Any]
) -> None:
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
    svg : str
        The picture of the laws over all tracks; '' where there is none.
    origin : mapping of str to object
        What `provenance` returns.
    """
    write_atomically(file, page.page('Benchmark', _parts(values, paths, svg, origin), [_STYLE],
                                     [asset('basics.js'), asset('benchmark.js')]))
