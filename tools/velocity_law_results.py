"""The table of the velocity laws for docs/results.md, from a benchmark with two position laws."""

import hashlib
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from benchmark_results import length
from command_output import output_of
from page_part import PagePart, table_row

from mobile_robot_control.benchmarking.cell_result import Done
from mobile_robot_control.benchmarking.ranking import RANKED, better_pairs, pairs_of, quantile, rank_ranges
from mobile_robot_control.benchmarking.request import Benchmark, BenchmarkRequest
from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.loop.monte_carlo import JudgedRuns
from mobile_robot_control.runs.words import three_digits
from mobile_robot_control.search.space import VELOCITY, search_genes
from mobile_robot_control.settings.configure import ParameterSources

TABLE = PagePart('velocity laws')
STORE = 'velocity_law_results.json'
LAWS, VELOCITY_LAWS = ('kanayama', 'backstepping'), ('pi', 'computed_torque', 'torque_sliding_mode', 'adaptive')
TRACKS = ('on_curve', 'config/tracks/velocity_laws/off_centre.yaml', 'config/tracks/velocity_laws/heavier.yaml',
          'delay', 'weak_motors')
SEEDS = (1, 2, 3, 4, 5)
COMMAND = ' '.join([
    f'benchmark --laws {" ".join(LAWS)} --velocity-laws {" ".join(VELOCITY_LAWS)} --tracks {" ".join(TRACKS)}',
    f'--feedforward --seeds {" ".join(map(str, SEEDS))} --budgets 300 --scenarios 6 --runs 50 --restarts 1'])
_FOLDER = Path('runs/velocity_laws')


def asked() -> Benchmark:
    """Return the benchmark of all pairs."""
    return Benchmark(BenchmarkRequest(ParameterSources(), LAWS, TRACKS, VELOCITY_LAWS, seeds=SEEDS, feedforward=True,
                                      budgets=(300,), scenarios=6, runs=50, restarts=1))


def fingerprint(benchmark: Benchmark) -> str:
    """Return a few digits that change with the arithmetic, with tracks and with what is searched."""
    content = [ARITHMETIC, COMMAND, *(track.content(ParameterSources()) for track in benchmark.tracks.values()),
               *(search_genes(VELOCITY, velocity_law=law) for law in VELOCITY_LAWS)]
    return hashlib.sha256(repr(content).encode()).hexdigest()[:12]


def stored(store: Path) -> dict[str, Any]:
    """Return the stored numbers, measured again where tracks or searches have changed: an hour, resumable."""
    benchmark = asked()
    found: dict[str, Any] = json.loads(store.read_text(encoding='utf-8')) if store.exists() else {}
    if found.get('fingerprint') != fingerprint(benchmark):
        output_of(COMMAND, '--output', str(_FOLDER), '--resume', progress=True)
        found = keep(store, _FOLDER)
    return found


def keep(store: Path, folder: Path) -> dict[str, Any]:
    """Collect the cells of a folder into the place where the result is kept, with its fingerprint; return it."""
    benchmark = asked()
    done = benchmark.held(folder / 'cells')
    if len(done) < len(benchmark.cells):
        raise SystemExit(f'{folder}: {len(done)} of {len(benchmark.cells)} cells are done; call it again to go on')
    found = {'fingerprint': fingerprint(benchmark), 'rows': [*_rows(done)]}
    store.write_text(json.dumps(found, indent=1) + '\n', encoding='utf-8')
    return found


def _rows(done: Done) -> Iterator[dict[str, Any]]:
    """Yield a row for each position law, track and kind of drive: the velocity laws, ranked among each other."""
    groups: dict[tuple[str, str, bool], dict[str, dict[int, JudgedRuns]]] = {}
    for cell, result in done:
        runs = result.results[-1].runs(cell.runs)
        laws = groups.setdefault((cell.law, cell.track.name, cell.feedforward), {})
        if runs is not None:
            laws.setdefault(cell.velocity_law, {})[cell.seed] = runs
    for (law, track, fed), laws in groups.items():
        better = better_pairs(pairs_of(laws))
        ranks = rank_ranges(laws, better)
        numbers = {}
        for name, seeds in laws.items():
            succeeding = [judged.chosen(judged.success) for judged in seeds.values()]
            total = sum(len(judged) for judged in seeds.values())
            numbers[name] = {
                'ranks': ranks[name], 'fails': 1.0 - sum(map(len, succeeding)) / total,
                **{metric: quantile([value for one in succeeding for value in one.metrics[metric].tolist()], 0.5)
                   for metric in (RANKED, 'torque_variation')}}
        yield {'law': law, 'track': track, 'feedforward': fed, 'better': sorted(better), 'laws': numbers}


def _cell(numbers: Mapping[str, Any]) -> str:
    first, last = numbers['ranks']
    rank = f'{first}' if first == last else f'{first}–{last}'
    fails = f', {100.0 * numbers["fails"]:.2g} % fail' if numbers['fails'] else ''
    variation = '–' if numbers['torque_variation'] is None else f'{three_digits(numbers["torque_variation"])} N m'
    return f'{f"**{rank}**" if first == 1 else rank}: {length(numbers[RANKED])}, {variation}{fails}'


def _roughness(rows: Sequence[Mapping[str, Any]], fed: bool) -> str:
    """Return how much rougher the torques of the PI law are, in a sentence."""
    ratios = []
    for row in rows:
        if row['feedforward'] is fed:
            own, *others = (row['laws'][name]['torque_variation'] for name in VELOCITY_LAWS)
            ratios.append(own / min(others))
    return (f'{"With feedforward" if fed else "Without feedforward"} the variation of the torques of `pi` is '
            f'{median(ratios):.2g} times that of the smoothest law of its row (median; {min(ratios):.2g} to '
            f'{max(ratios):.2g}).')


def table_lines(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the counts of each law, and a table for each position law."""
    yield from (table_row(['velocity law', f'unbeaten in, of {len(rows)}', 'better', 'worse']), '|---|---|---|---|')
    for name in VELOCITY_LAWS:
        pairs = [pair for row in rows for pair in row['better']]
        yield table_row([name, str(sum(row['laws'][name]['ranks'][0] == 1 for row in rows)),
                         str(sum(better == name for better, _ in pairs)),
                         str(sum(worse == name for _, worse in pairs))])
    yield from ('', ' '.join(_roughness(rows, fed) for fed in (False, True)))
    for law in LAWS:
        yield from ('', f'With `{law}`:', '', table_row(['track', *VELOCITY_LAWS]), f'|{"---|" * 5}')
        own = [row for row in rows if row['law'] == law]
        for row in sorted(own, key=lambda row: [track.partition('.')[0].rpartition('/')[2] for track in TRACKS].index(
                row['track'])):
            yield table_row([row['track'] + ', feedforward' * row['feedforward'],
                             *(_cell(row['laws'][name]) for name in VELOCITY_LAWS)])
    yield from ('', f'To repeat: `mrc {COMMAND}`.')


def main(results: Path) -> None:
    """Write the generated part of docs/results.md."""
    values = stored(results.with_name(STORE))
    TABLE.write([str(results)], TABLE.marked(values['fingerprint'], table_lines(values['rows'])))


if __name__ == '__main__':
    if sys.argv[1] == '--keep':
        # what a folder of cells holds: FOLDER STORE
        keep(Path(sys.argv[3]), Path(sys.argv[2]))
    else:
        main(Path(sys.argv[1]))
