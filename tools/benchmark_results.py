"""The table of the position laws for docs/results.md and README.md, from a benchmark with the default options."""

import hashlib
import json
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import fmean, median
from typing import Any

from command_output import output_of
from law_searches import NAMES
from page_part import PagePart, table_row

from mobile_robot_control.benchmarking.cell import NOT_SEARCHED, was_searched
from mobile_robot_control.benchmarking.engine import is_first, law_summaries, number_text, rank_text
from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.search.space import search_genes
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.tracks import read_track, shipped_tracks

TABLE, SUMMARY, SEEDS = PagePart('laws'), PagePart('benchmark'), PagePart('seeds')
STORE, SEEDS_STORE = 'benchmark.json', 'benchmark_seeds.json'
"""The files beside docs/results.md that have gains and numbers; the second one is made by hand, in half an hour."""
COMMAND = f'benchmark --laws {" ".join(NAMES)} --seed 1'
_FOLDER = Path('runs/benchmark')
_BASES = ('robot_create3', 'robot_jackal', 'robot_kobuki', 'robot_turtlebot3_burger_base', 'robot_turtlebot3_waffle',
          'robot_turtlebot4')


def fingerprint(laws: Sequence[str], tracks: Sequence[str]) -> str:
    """Return a few digits that change with the arithmetic, with tracks and with what is searched."""
    content = [ARITHMETIC, COMMAND, *(repr(read_track(name).content(ParameterSources())) for name in tracks),
               *(repr(search_genes(law, with_velocity=True)) for law in laws)]
    return hashlib.sha256(repr(content).encode()).hexdigest()[:12]


def stored(store: Path) -> dict[str, Any]:
    """Return the stored benchmark, run again where tracks or searches have changed: some 12 minutes, resumable."""
    found: dict[str, Any] = json.loads(store.read_text(encoding='utf-8')) if store.exists() else {}
    if found.get('fingerprint') != fingerprint(NAMES, list(shipped_tracks())):
        print(COMMAND, file=sys.stderr)
        output_of(COMMAND, '--output', str(_FOLDER), '--resume', progress=True)
        found = keep(store, _FOLDER)
    return found


def keep(store: Path, folder: Path) -> dict[str, Any]:
    """Copy the result of a benchmark to the place where it is kept, with its fingerprint; return it."""
    found: dict[str, Any] = json.loads((folder / 'benchmark.json').read_text(encoding='utf-8'))
    found['fingerprint'] = fingerprint(found['laws'], list(found['tracks']))
    store.write_text(json.dumps(found, separators=(',', ':')) + '\n', encoding='utf-8')
    shutil.copy(folder / 'benchmark.csv', store.with_suffix('.csv'))
    return found


class Rows:
    """The rows of a benchmark by track, the best law first."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        self.values = values
        self.tracks: dict[str, list[dict[str, Any]]] = {}
        for row in values['results']:
            self.tracks.setdefault(row['track'], []).append(row)

    def firsts(self, track: str) -> list[str]:
        """Return the laws of a track to which none is better for certain, and which succeed in half of the runs."""
        return [row['law'] for row in self.tracks[track] if is_first(row)]

    def row(self, track: str, law: str) -> dict[str, Any]:
        """Return the row of a law."""
        return next(row for row in self.tracks[track] if row['law'] == law)


def _listed(names: Sequence[str]) -> str:
    """Return names in words."""
    told = [f'`{name}`' for name in names]
    return told[0] if len(told) == 1 else f'{", ".join(told[:-1])} and {told[-1]}'


def _length(value: float | None) -> str:
    return '–' if value is None else f'{1e3 * value:.3g} mm' if value < 0.01 else f'{1e2 * value:.3g} cm'


def _spread(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the smallest and the largest median error of rows, in words."""
    found = sorted(row['rms'] for row in rows if row['rms'] is not None)
    return f'{_length(found[0])} to {_length(found[-1])}' if found else 'not known'


def _on(rows: Rows, track: str, words: str, ending: str = '') -> str:
    """Return which laws are the first on a track, with their errors and those of the others."""
    firsts = rows.firsts(track)
    others = [row for row in rows.tracks[track] if row['law'] not in firsts]
    best = rows.row(track, firsts[0])
    rest = f'; the others have {_spread(others)}' if any(row['rms'] is not None for row in others) else ''
    return (f'{words}, take {_listed(firsts)}: median RMS error {_length(best["rms"])} in the '
            f'{best["shared"]} of {best["runs"]} scenarios in which all compared laws succeed{rest}{ending} '
            f'(`{track}`).')


def _overall(rows: Rows) -> str:
    best, *_, last = law_summaries(rows.values)
    return (f'Over the tracks on which a law was searched, `{best.law}` has the best mean rank, {best.mean_rank:.1f}, '
            f'and on {best.first} of its {best.tables} no law is better for certain; `{last.law}` has the worst, '
            f'{last.mean_rank:.1f}.')


def _everywhere(rows: Rows) -> str:
    shares = {one.law: one.success for one in law_summaries(rows.values)}
    sure = [law for law, share in shares.items() if share == max(shares.values())]
    least = min(shares, key=lambda law: shares[law])
    return (f'{_listed(sure)} succeed{"s" * (len(sure) == 1)} most often, in {100.0 * shares[sure[0]]:.1f} % of its '
            f'runs on these tracks, and `{least}` least often, in {100.0 * shares[least]:.1f} %.')


def _rough(rows: Rows) -> str:
    """Return what noise costs."""
    known = [row for row in rows.tracks['noise'] if row['torque_variation'] is not None]
    calm = min(known, key=lambda row: row['torque_variation'])
    wild = max(known, key=lambda row: row['torque_variation'])
    return (f'Where odometry is noisy, {_listed(rows.firsts("noise"))} follow'
            f'{"s" * (len(rows.firsts("noise")) == 1)} best, but the torques of `{calm["law"]}` vary least: '
            f'{calm["torque_variation"]:.0f} N m over a run in place of up to {wild["torque_variation"]:.0f} N m of '
            f'`{wild["law"]}` (`noise`).')


def _delayed(rows: Rows) -> str:
    torques = [row['torque_variation'] for row in rows.tracks['delay'] if row['torque_variation'] is not None]
    return _on(rows, 'delay', 'Where torques act one or two samples late',
               f'; the median law changes its torques by {median(torques):.3g} N m over a run')


def _bases(rows: Rows) -> str:
    known = [track for track in _BASES if track in rows.tracks]
    count = {law: sum(law in rows.firsts(track) for track in known) for law in rows.values['laws']}
    most = max(count.values())
    best = [law for law, found in count.items() if found == most]
    worst = [law for law, found in count.items() if not found]
    told = f'; {_listed(worst)} on none' if worst else ''
    return (f'On the {len(known)} robots that take velocity commands, take {_listed(best)}, to which no law is better '
            f'for certain on {most} of them{told} ({", ".join(f"`{track}`" for track in known)}).')


def _fed(rows: Rows) -> str:
    gains = {track: [row for row in found if row['rms'] and row['fed_rms']] for track, found in rows.tracks.items()}
    smaller = sum(row['fed_rms'] < row['rms'] for found in gains.values() for row in found)
    most = max((row for found in gains.values() for row in found), key=lambda row: row['rms'] / row['fed_rms'])
    return (f'Feedforward makes the error smaller in {smaller} of {sum(map(len, gains.values()))} cells, most for '
            f'`{most["law"]}` on `{most["track"]}`, from '
            f'{_length(most["rms"])} to {_length(most["fed_rms"])}, with gains that were searched without it.')


_CLAIMS: tuple[tuple[str, Any], ...] = (
    ('on_curve', _overall), ('on_curve', _everywhere),
    ('on_curve', lambda rows: _on(rows, 'on_curve', 'For a robot on wheel torques that starts on the curve')),
    ('thrown_off', lambda rows: _on(rows, 'thrown_off', 'Where it may start a metre away, facing anywhere')),
    ('noise', _rough), ('delay', _delayed),
    ('weak_motors', lambda rows: _on(rows, 'weak_motors', 'Where the motors saturate')),
    ('rectangle', lambda rows: _on(rows, 'rectangle', "On a planner's path at the limits of the motors")),
    ('robot_create3', _bases), ('on_curve', _fed),
)


def sentences(values: Mapping[str, Any]) -> list[str]:
    """Return which law is for which robot and why, each sentence with its numbers."""
    rows = Rows(values)
    return [claim(rows) for track, claim in _CLAIMS if track in rows.tracks]


def _cell(row: Mapping[str, Any]) -> str:
    """Return rank, error and, where there are failures, success."""
    if not was_searched(row):
        return rank_text(row)
    if row['reason']:
        return f'{rank_text(row)}, failed'
    missed = row['runs'] - row['successes']
    rank = f'**{rank_text(row)}**' if is_first(row) else rank_text(row)
    return f'{rank}: {_length(row["rms"])}' + (f', {missed} of {row["runs"]} fail' if missed else '')


def table_lines(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield the sentences, and the table of all tracks and laws."""
    rows = Rows(values)
    yield from (f'{n}. {text}' for n, text in enumerate(sentences(values), 1))
    laws = [one.law for one in law_summaries(values)]
    yield from ('', f'Each cell has the ranks that the law may have, and its median RMS error; bold where no law is '
                'better for certain, and half of the runs succeed. "Not searched": no candidate of the search could be '
                'driven, so the law has no rank there, and the track counts in none of its means. Hash '
                f'`{values["hash"]}`.', '')
    yield from (table_row(['track', *laws]), f'|{"---|" * (1 + len(laws))}')
    yield from (table_row([track, *(_cell(rows.row(track, law)) for law in laws)]) for track in rows.tracks)
    yield from ('', 'Why each track exists:', '')
    yield from (f'- `{track}`: {found["purpose"]}' for track, found in values['tracks'].items())
    published = [(track, one) for track, found in values['tracks'].items() for one in found['published']]
    if published:
        yield from ('', 'With the gains of the publication, its numbers beside ours:', '',
                    '| track | law | metric | published | ours |', '|---|---|---|---|---|')
        yield from (table_row([track, one['law'], f'`{name}`', f'{value:.5g}', number_text(one['ours'][name])])
                    for track, one in published for name, value in one['published'].items())
    yield from ('', '`benchmark --seed 1 --output runs/benchmark` makes all of it again, in some 12 minutes on two '
                'cores.')


def summary_table(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield the summary of the README."""
    summaries = law_summaries(values)
    yield from (table_row([f'of {len(values["tracks"])} tracks', *(one.law for one in summaries)]),
                f'|{"---|" * (1 + len(summaries))}',
                table_row(['searched on', *(str(one.tables) for one in summaries)]),
                table_row(['mean rank there', *(f'{one.mean_rank:.1f}' for one in summaries)]),
                table_row(['no law is better on', *(str(one.first) for one in summaries)]),
                table_row(['success', *(f'{100.0 * one.success:.1f} %' for one in summaries)]))


def seeds_lines(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield how ranks depend on seeds and budgets; nothing where that was not measured."""
    if not values:
        return
    head = [f'{track}, {budget}' for track in values['tracks'] for budget in values['budgets']]
    yield (f'Mean rank over {len(values["seeds"])} seeds, each of which draws its own scenarios, and in brackets all '
           f'ranks that may be, by track and candidates of the search; hash `{values["hash"]}`, a row for each seed in '
           '[benchmark_seeds.csv](benchmark_seeds.csv):')
    yield from ('', table_row(['law', *head]), f'|{"---|" * (1 + len(head))}')
    for law in values['laws']:
        cells = []
        for track in values['tracks']:
            for budget in values['budgets']:
                rows = [row for row in values['results'] if row['rank'] is not None
                        and (row['law'], row['track'], row['budget']) == (law, track, budget)]
                if not rows:
                    cells.append(NOT_SEARCHED)
                    continue
                mean = fmean(0.5 * (row['rank'] + row['last_rank']) for row in rows)
                span = {'rank': min(row['rank'] for row in rows), 'last_rank': max(row['last_rank'] for row in rows)}
                cells.append(f'{mean:.1f} ({rank_text(span)})')
        yield table_row([law, *cells])


def main(results: Path, readme: Path, page: Path) -> None:
    """Write the generated parts of docs/results.md, README.md and docs/benchmark.md."""
    values = stored(results.with_name(STORE))
    TABLE.write([str(results)], TABLE.marked(values['hash'], table_lines(values)))
    SUMMARY.write([str(readme)], SUMMARY.marked(values['hash'], summary_table(values)))
    file = results.with_name(SEEDS_STORE)
    seeds = json.loads(file.read_text(encoding='utf-8')) if file.exists() else {}
    SEEDS.write([str(page)], SEEDS.marked(seeds.get('hash', 'nothing'), seeds_lines(seeds)))


if __name__ == '__main__':
    if sys.argv[1] == '--keep':
        # the result of a run by hand: FOLDER STORE
        keep(Path(sys.argv[3]), Path(sys.argv[2]))
    else:
        main(*map(Path, sys.argv[1:4]))
