"""The table of the position laws for docs/results.md and README.md, from a benchmark over seeds."""

import ast
import csv
import hashlib
import io
import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from command_output import output_of
from law_searches import NAMES
from page_part import PagePart, table_row

from mobile_robot_control.benchmarking.benchmark import benchmarked, write_benchmark
from mobile_robot_control.benchmarking.cell import Cell
from mobile_robot_control.benchmarking.cell_result import CONFIGURED, FED, BudgetResult, CellResult
from mobile_robot_control.benchmarking.judged_table import NAME, judged_table, write_judged_table
from mobile_robot_control.benchmarking.picture import ratios_figure
from mobile_robot_control.benchmarking.ranking import RANKED, quantile
from mobile_robot_control.benchmarking.request import Benchmark, BenchmarkRequest
from mobile_robot_control.benchmarking.run_cell import Work, driven_again
from mobile_robot_control.benchmarking.table import COLUMNS, is_first, last_summary
from mobile_robot_control.benchmarking.words import law_text, number_text, place_text, rank_text
from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.figures.palette import save
from mobile_robot_control.loop.workers import Workers, runner
from mobile_robot_control.search.space import search_genes
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.tracks import read_track, shipped_tracks
from mobile_robot_control.system.progress import tqdm

TABLE, SUMMARY = PagePart('laws'), PagePart('benchmark')
LAWS = (*NAMES, 'input_output_linearization', 'stanley', 'regulated_pure_pursuit', 'mpc')
STORE = 'benchmark.json'
"""The file beside docs/results.md that has ranks and pairs; that of each cell is the CSV beside it."""
SIX = ('on_curve', 'thrown_off', 'robot_kobuki', 'weak_motors', 'noise', 'rectangle')
"""Tracks with all seeds, and with feedforward with half of them; the others have half of them without it."""
SEEDS = tuple(range(1, 11))
COMMAND = f'benchmark --laws {" ".join(LAWS)} --restarts 2'
_FOLDER = Path('runs/benchmark')
_STEADY = 0.9
"""Share of runs in which the best law of a track succeeds, below which the track is told."""
_SELDOM = 0.98
"""Share of runs in which the law with the smallest error succeeds, below which its failures are told."""


def fingerprint(laws: Sequence[str], tracks: Sequence[str]) -> str:
    """Return a few digits that change with the arithmetic, with tracks and with what is searched."""
    content = [ARITHMETIC, COMMAND, SIX, SEEDS,
               *(repr(read_track(name).content(ParameterSources())) for name in tracks),
               *(repr(search_genes(law, with_velocity=True)) for law in laws)]
    return hashlib.sha256(repr(content).encode()).hexdigest()[:12]


def stored(store: Path) -> dict[str, Any]:
    """Return the stored benchmark, run again where tracks or searches have changed: seven hours, resumable."""
    found: dict[str, Any] = json.loads(store.read_text(encoding='utf-8')) if store.exists() else {}
    if found.get('fingerprint') != fingerprint(LAWS, list(shipped_tracks())):
        others = [name for name in shipped_tracks() if name not in SIX]
        for tracks, seeds, more in ((SIX, SEEDS, ''), (others, SEEDS[:5], ''), (SIX, SEEDS[:5], ' --feedforward')):
            asked = f'{COMMAND} --tracks {" ".join(tracks)} --seeds {" ".join(map(str, seeds))}{more}'
            print(asked, file=sys.stderr)
            output_of(asked, '--output', str(_FOLDER), '--resume', progress=True)
        found = keep(store, _FOLDER)
    elif not store.with_name(NAME).exists():
        drive_again(store)
    return found


def _asked() -> Benchmark:
    """Return all cells of the laws of this package, with and without feedforward."""
    return Benchmark(BenchmarkRequest(ParameterSources(), LAWS, seeds=SEEDS, restarts=2, feedforward=True))


def rows_of(store: Path) -> list[dict[str, str]]:
    """Return the ranked rows of the CSV beside the stored benchmark: those without feedforward."""
    with store.with_suffix('.csv').open(encoding='utf-8') as file:
        return [row for row in csv.DictReader(file) if row['gains'] != FED]


def cells_of(rows: Iterable[Mapping[str, str]]) -> Iterator[tuple[Cell, BudgetResult]]:
    """Yield the cells of ranked rows of the CSV, each with its gains."""
    cells = {(cell.track.name, cell.law, cell.seed): cell for cell in _asked().cells if not cell.feedforward}
    for row in rows:
        gains = (one.partition(' = ') for one in row['values'].split('; ') if one)
        yield cells[row['track'], row['law'], int(row['seed'])], BudgetResult(
            int(row['budget']), row['reason'], gains={name: ast.literal_eval(value) for name, _, value in gains})


def drive_again(store: Path) -> None:
    """Write the ranked runs of the stored benchmark, whose gains are driven again: ten minutes on one core."""
    rows, done = rows_of(store), []
    with runner(Workers(workers=1)) as run, tqdm(total=len(rows), unit='result') as bar:
        for row, (cell, result) in zip(rows, cells_of(rows), strict=True):
            work = Work(run, store, lambda _: None, lambda: False)
            driven = driven_again(cell, result, work) if result.gains else result
            judged = driven.runs(cell.runs)
            errors = judged.metrics[RANKED][judged.success].tolist() if judged else []
            if (row['successes'], row['rms']) != (str(len(errors)) if judged else '', str(quantile(errors, 0.5) or '')):
                raise SystemExit(f'{store.with_suffix(".csv")}: {row["law"]} on {row["track"]}, seed {row["seed"]}: '
                                 'its gains give other runs now; remove the file, and the benchmark runs again')
            done.append((cell, CellResult([driven])))
            bar.update()
    digits = json.loads(store.read_text(encoding='utf-8'))['hash']
    write_judged_table(store.with_name(NAME), judged_table(done, digits))


def keep(store: Path, folder: Path) -> dict[str, Any]:
    """Collect the cells of a folder into the place where the result is kept, with its fingerprint; return it."""
    asked = _asked()
    made = benchmarked(asked, asked.held(folder / 'cells'),
                       f'{COMMAND} --feedforward --seeds {" ".join(map(str, SEEDS))}')
    write_benchmark(made, folder)
    found = {name: value for name, value in made.values.items() if name != 'results'}
    searched = [row for row in made.results if row['agreeing'] is not None]
    found['converged'] = {law: [sum(row['agreeing'] > 1 for row in searched if row['law'] == law),
                                sum(row['law'] == law for row in searched)] for law in LAWS}
    found['at_edge'] = sum(bool(row['at_edge']) for row in made.results)
    found['fingerprint'] = fingerprint(LAWS, list(shipped_tracks()))
    store.write_text(json.dumps(found, separators=(',', ':')) + '\n', encoding='utf-8')
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow([*COLUMNS, 'values'])
    writer.writerows([*('; '.join(row[name]) if isinstance(row[name], list) else row[name] for name in COLUMNS),
                      '; '.join(f'{name} = {value}' for name, value in row['values'].items())]
                     for row in made.results if row['gains'] != CONFIGURED)
    store.with_suffix('.csv').write_text(text.getvalue(), encoding='utf-8')
    # those with feedforward are no part of a ranking, and would be another third of a megabyte
    ranked = [(cell, result) for cell, result in made.done if not cell.feedforward]
    write_judged_table(store.with_name(NAME), judged_table(ranked, made.hash))
    return found


def _listed(names: Sequence[str]) -> str:
    """Return names in words."""
    told = [f'`{name}`' for name in names]
    return told[0] if len(told) == 1 else f'{", ".join(told[:-1])} and {told[-1]}'


def length(value: float | None) -> str:
    """Return a length in mm or cm, three digits."""
    return '–' if value is None else f'{1e3 * value:.3g} mm' if value < 0.01 else f'{1e2 * value:.3g} cm'


class Ranks:
    """The ranks of a benchmark by track, the best law first."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        self.values, self.tracks = values, dict[str, list[dict[str, Any]]]()
        for row in values['ranks']:
            self.tracks.setdefault(row['track'], []).append(row)

    def firsts(self, track: str) -> list[str]:
        """Return the laws of a track to which none is known to be better."""
        return [row['law'] for row in self.tracks[track] if is_first(row)]


def _overall(ranks: Ranks) -> str:
    rows = last_summary(ranks.values)
    best, last = rows[0], rows[-1]
    return (f'No law is known to beat `{best["law"]}` on {best["unbeaten"]} of {best["tracks"]} tracks: of '
            f'{best["comparisons"]} comparisons with other laws it is better in {best["wins"]}, worse in '
            f'{best["losses"]}, and the rest are undecided. `{last["law"]}` is better in {last["wins"]} and worse in '
            f'{last["losses"]}.')


def _success(ranks: Ranks) -> str:
    known = [row for rows in ranks.tracks.values() for row in rows if row['success'] is not None]
    most = {track: max(row['success'] for row in known if row['track'] == track) for track in ranks.tracks}
    hard = [track for track, success in most.items() if success < _STEADY]
    failed = {row['law']: row['failed'] for row in last_summary(ranks.values) if row['failed']}
    least = min((row for row in known if row['track'] not in hard and row['law'] not in failed),
                key=lambda row: row['success'])
    return '; '.join([
        *(f'`{law}` fails in most runs on {_listed(tracks)}' for law, tracks in failed.items()),
        *(f'every law fails in {100.0 * (1.0 - most[track]):.0f} % of its runs or more on `{track}`' for track in hard),
        f'the least success of {"another" if failed else "a"} law elsewhere is {100.0 * least["success"]:.1f} %, of '
        f'`{least["law"]}` on `{least["track"]}`.'])


def _overfitted(ranks: Ranks) -> str:
    best = [min((row for row in rows if row['rms'] is not None), key=lambda row: row['rms'])
            for rows in ranks.tracks.values() if max(row['success'] or 0.0 for row in rows) >= _STEADY]
    failing = [row for row in best if row['success'] < _SELDOM]
    if not failing:
        return ''
    least = min(failing, key=lambda row: row['success'])
    return (f'Gains searched in {ranks.values["scenarios"]} scenarios may fail in others: on {len(failing)} tracks the '
            f'law with the smallest error fails in more than {100.0 * (1.0 - _SELDOM):.0f} % of its runs, in '
            f'{100.0 * (1.0 - least["success"]):.0f} % on `{least["track"]}` (`{least["law"]}`).')


def _on(ranks: Ranks, track: str, words: str) -> str:
    """Return which laws no other is known to beat on a track, with their errors and those of the others."""
    firsts = ranks.firsts(track)
    rows = {row['law']: row for row in ranks.tracks[track]}
    errors = sorted(rows[law]['rms'] for law in firsts if rows[law]['rms'] is not None)
    others = sorted(row['rms'] for law, row in rows.items() if law not in firsts and row['rms'] is not None)
    rest = f'; the others, {length(others[0])} to {length(others[-1])}' if others else ''
    span = length(errors[0]) if len(errors) == 1 else f'{length(errors[0])} to {length(errors[-1])}'
    return (f'{words} (`{track}`), no law is known to beat {_listed(firsts)}: median RMS error {span}{rest}.')


def _bases(ranks: Ranks) -> str:
    known = [track for track in ranks.tracks if ranks.values['tracks'][track]['group'] == 'velocity base']
    count = {law: sum(law in ranks.firsts(track) for track in known) for law in ranks.values['laws']}
    best = [law for law, found in count.items() if found == max(count.values())]
    never = [law for law, found in count.items() if not found]
    told = f', and {_listed(never)} {"are" if len(never) > 1 else "is"} beaten on all' if never else ''
    return (f'On the {len(known)} tracks with a base that takes velocity commands, {_listed(best)} '
            f'{"are" if len(best) > 1 else "is"} unbeaten on {max(count.values())}{told}.')


def _searched(ranks: Ranks) -> str:
    better = [row for row in ranks.values['ranks']
              if row['rms'] is not None and row['configured_rms'] is not None and row['rms'] < row['configured_rms']]
    known = [row for row in ranks.values['ranks'] if row['rms'] is not None and row['configured_rms'] is not None]
    most = max(better, key=lambda row: row['configured_rms'] / row['rms'])
    return (f'A search makes the error smaller than that of the shipped gains on {len(better)} of {len(known)} pairs '
            f'of law and track, most for `{most["law"]}` on `{most["track"]}`, from {length(most["configured_rms"])} '
            f'to {length(most["rms"])}.')


def _fed(ranks: Ranks) -> str:
    known = [row for row in ranks.values['ranks'] if row['rms'] is not None and row['feedforward_rms'] is not None]
    better = [row for row in known if row['feedforward_rms'] < row['rms']]
    if not better:
        return ''
    most = max(better, key=lambda row: row['rms'] / row['feedforward_rms'])
    median = quantile([row['feedforward_rms'] / row['rms'] for row in known], 0.5) or 0.0
    return (f'With feedforward, and gains searched with it, the error is smaller in {len(better)} of {len(known)} '
            f'pairs of law and track, in the median {median:.2f} times that without; it falls most for `{most["law"]}` '
            f'on `{most["track"]}`, from {length(most["rms"])} to {length(most["feedforward_rms"])}.')


def _converged(ranks: Ranks) -> str:
    of_fuzzy, all_of = ranks.values['converged']['fuzzy'], _searches(ranks.values)
    return (f'In {all_of[0] - of_fuzzy[0]} of {all_of[1] - of_fuzzy[1]} cells the repeated searches end within 2 % of '
            f'each other, for `fuzzy`, which has the most gains, in {of_fuzzy[0]} of {of_fuzzy[1]}; in '
            f'{ranks.values["at_edge"]} of all a gain ends at an edge of its bounds. More candidates would change '
            'those numbers.')


def _searches(values: Mapping[str, Any]) -> list[int]:
    """Return how many cells of all laws have converged, and how many were searched."""
    return [sum(counts) for counts in zip(*values['converged'].values(), strict=True)]


def _certain(ranks: Ranks) -> str:
    def share(tracks: Sequence[str]) -> str:
        pairs = [row for row in ranks.values['pairs'] if row['track'] in tracks]
        told = sum(row['better'] is not None for row in pairs)
        return f'{told} of {len(pairs)}'

    others = [track for track in ranks.tracks if track not in SIX]
    return (f'With {len(SEEDS)} seeds, one law of a pair is known to be better in {share(SIX)} pairs on '
            f'{len(SIX)} tracks; with 5 seeds in {share(others)} on {len(others)}.')


_CLAIMS: tuple[Any, ...] = (
    _overall, _success, _overfitted,
    lambda ranks: _on(ranks, 'on_curve', 'For a robot on wheel torques that starts on the curve'),
    lambda ranks: _on(ranks, 'thrown_off', 'Where it may start a metre away, facing anywhere'),
    lambda ranks: _on(ranks, 'noise', 'Where odometry is noisy'),
    lambda ranks: _on(ranks, 'delay', 'Where torques act one or two samples late'),
    lambda ranks: _on(ranks, 'weak_motors', 'Where the motors saturate'),
    lambda ranks: _on(ranks, 'rectangle', "On a planner's path at the limits of the motors"),
    _bases, _searched, _fed, _converged, _certain,
)


def sentences(values: Mapping[str, Any]) -> list[str]:
    """Return which law is for which robot, each sentence with its numbers."""
    return [*filter(None, (claim(Ranks(values)) for claim in _CLAIMS))]


def _cell(row: Mapping[str, Any]) -> str:
    """Return rank, error and, where there are failures, success."""
    if row['rank'] is None:
        return rank_text(row)
    rank = f'**{rank_text(row)}**' if is_first(row) else rank_text(row)
    fails = 100.0 * (1.0 - row['success'])
    return f'{rank}: {length(row["rms"])}' + (f', {fails:.2g} % fail' if fails else '')


def table_lines(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield the sentences, and the table of all tracks and laws."""
    ranks = Ranks(values)
    yield from (f'{n}. {text}' for n, text in enumerate(sentences(values), 1))
    summary = last_summary(values)
    yield from ('', 'Over all tracks:', '',
                table_row(['law', 'place', 'unbeaten on', 'better', 'worse', 'largest error to the best',
                           'least success']), f'|{"---|" * 7}')
    for one in summary:
        yield table_row([law_text(values, one['law']), place_text(one), f'{one["unbeaten"]} of {one["tracks"]}',
                         f'{one["wins"]} of {one["comparisons"]}', str(one['losses']),
                         f'{one["largest_ratio"]:.2f}, {one["largest_on"]}',
                         f'{100.0 * one["least_success"]:.1f} %, {one["least_on"]}'])
    yield from ('', 'A law is unbeaten on a track if no law is known to be better there; undecided is not equal. The '
                'place is by majority of what is certain, in brackets its range when any track or group is left out.')
    laws = [one['law'] for one in summary]
    yield from ('', 'Each cell has the ranks that the law may have, and its median RMS error over all seeds and the '
                'runs in which it succeeds; bold where no law is known to be better. Hash '
                f'`{values["hash"]}`.', '')
    yield from (table_row(['track', 'seeds', *(law_text(values, law) for law in laws)]), f'|{"---|" * (2 + len(laws))}')
    for track, found in ranks.tracks.items():
        by_law = {row['law']: row for row in found}
        yield table_row([track, str(max(row['seeds'] for row in found)), *(_cell(by_law[law]) for law in laws)])
    yield from ('', 'Why each track exists:', '')
    yield from (f'- `{track}`: {found["purpose"]}' for track, found in values['tracks'].items())
    published = [(track, one) for track, found in values['tracks'].items() for one in found['published']]
    if published:
        yield from ('', 'With the gains of the publication, what its listings give with a robot that is moved along '
                    'the exact arc, beside ours:', '', '| track | law | metric | listing | ours |',
                    '|---|---|---|---|---|')
        yield from (table_row([track, one['law'], f'`{name}`', f'{value:.5g}', number_text(one['ours'][name])])
                    for track, one in published for name, value in one['published'].items())


def summary_table(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield the summary of the README."""
    count = max(one['tracks'] for one in last_summary(values))
    yield from (f'| law | unbeaten, of {count} tracks | comparisons better : worse |', '|---|---|---|')
    for one in last_summary(values):
        yield table_row([f'[{law_text(values, one["law"])}](docs/laws.md#{one["law"]})', str(one['unbeaten']),
                         f'{one["wins"]} : {one["losses"]}'])
    yield from ('', f'In {values["at_edge"]} of {_searches(values)[1]} searches a gain ends at an edge of its '
                'bounds: wider ones may change these counts.')


def main(results: Path, readme: Path, picture: Path) -> None:
    """Write the generated parts of docs/results.md and README.md, and the picture of the laws."""
    values = stored(results.with_name(STORE))
    figure = ratios_figure(values)
    assert figure is not None  # noqa: S101 (for mypy: laws have errors)
    save(figure, picture)
    # the page shows the PNG
    picture.with_suffix('.svg').unlink()
    TABLE.write([str(results)], TABLE.marked(values['hash'], table_lines(values)))
    SUMMARY.write([str(readme)], SUMMARY.marked(values['hash'], summary_table(values)))


if __name__ == '__main__':
    if sys.argv[1] == '--keep':
        # what a folder of cells holds: FOLDER STORE
        keep(Path(sys.argv[3]), Path(sys.argv[2]))
    else:
        main(*map(Path, sys.argv[1:4]))
