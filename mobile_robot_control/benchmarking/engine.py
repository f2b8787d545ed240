"""A benchmark that is asked for: laws on tracks, each law searched with one budget and judged where no search was."""

import csv
import io
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from statistics import fmean
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.benchmarking.cell import (
    NOT_SEARCHED,
    POPULATION,
    Cell,
    judged_runs,
    read_result,
    was_searched,
)
from mobile_robot_control.benchmarking.ranking import RANKED, quantile, ranked, shared_scenarios
from mobile_robot_control.benchmarking.side_by_side import run_cells, run_side_by_side
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.loop.batch import cores
from mobile_robot_control.loop.metric_table import INDEX_METRICS, RUN_METRICS
from mobile_robot_control.loop.monte_carlo import LARGEST_SEED, Judged, wilson_interval
from mobile_robot_control.loop.workers import Workers, runner
from mobile_robot_control.parameters.declaration import INLINE, Field, ParameterError, nearest
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import measure
from mobile_robot_control.settings.configure import ParameterSources, configure
from mobile_robot_control.settings.nodes import Configuration, course_of
from mobile_robot_control.settings.tracks import Published, Track, read_track, shipped_tracks

_FIRST_SEED, _FIRST_BUDGET = 1, 500
REPORTED = [one.name for one in (*RUN_METRICS, *INDEX_METRICS) if one.better and not one.of_wheels]
"""The metrics that a publication may report: numbers of a run."""
Done = list[tuple[Cell, dict[str, Any]]]
"""Cells with their results, as `run_cell` returns them."""


class BenchmarkRequest(NamedTuple):
    """What a benchmark is asked for."""

    sources: ParameterSources
    laws: Annotated[tuple[str, ...], Field('', 'position laws to compare; all, with those of --law, if left out',
                                           choices=LAWS)] = ()
    tracks: Annotated[tuple[str, ...], Field('', 'tracks of this package by name, or files of your own; all of this '
                                             'package, if left out')] = ()
    seed: Annotated[int, Field('', 'of the scenarios that search and judge, and of the search', minimum=0,
                               maximum=LARGEST_SEED)] = _FIRST_SEED
    seeds: Annotated[tuple[int, ...], Field('', 'several seeds instead: how ranks depend on the draw', minimum=0,
                                            maximum=LARGEST_SEED)] = ()
    budgets: Annotated[tuple[int, ...], Field('', f'candidates of each search, {POPULATION} a generation; of several, '
                                              'the longest search is judged at each', minimum=POPULATION,
                                              maximum=10**7)] = (_FIRST_BUDGET,)
    tune: Annotated[bool, Field('', 'take gains as configured, and search for none')] = True
    scenarios: Annotated[int, Field('', 'scenarios of a search', minimum=1, maximum=1000)] = 8
    runs: Annotated[int, Field('', 'scenarios that judge', minimum=2, maximum=100_000)] = 100
    where: Annotated[Workers, INLINE] = Workers()


class Benchmark:
    """
    A benchmark, checked and ready to run.

    Parameters
    ----------
    request : BenchmarkRequest
        What is asked for; ParameterError is raised where that cannot be compared.

    Attributes
    ----------
    cells : list of Cell
        In the order in which they run: a law with all its tracks is compiled once.
    tracks : dict of str to Track
        By name.
    """

    def __init__(self, request: BenchmarkRequest) -> None:
        if request.sources.robot is not None:
            raise ParameterError(['--robot is not taken: each track names its robot; write a track of your own'])
        self.request = request
        self.laws = tuple(dict.fromkeys(request.laws or LAWS))
        self.seeds = tuple(dict.fromkeys(request.seeds or (request.seed,)))
        self.budgets = tuple(sorted(set(request.budgets))) if request.tune else ()
        tracks = [read_track(given) for given in dict.fromkeys(request.tracks or shipped_tracks())]
        self.tracks = {track.name: track for track in tracks}
        if not tracks or len(self.tracks) < len(tracks):
            raise ParameterError(['--tracks: two files have one name; rename one' if tracks else
                                  '--tracks: the package is installed without its tracks; name files of your own'])
        self.cells = [Cell(law, track, seed, self.budgets, request.scenarios, request.runs, request.sources)
                      for law in self.laws for track in tracks for seed in self.seeds]
        # what is wrong with a track is said at once
        for track in tracks:
            configuration = track.sources(request.sources).configuration()
            self.cells[0]._replace(track=track).drawn('judging', configuration, 1)
            _check_published(track, request.sources)

    @property
    def rollouts(self) -> int:
        """How many rollouts a whole benchmark has."""
        candidates = max(self.budgets, default=0) // POPULATION * POPULATION
        judged = 2 * self.request.runs * max(1, len(self.budgets))
        return len(self.cells) * (candidates * self.request.scenarios + judged)

    def held(self, folder: Path) -> Done:
        """Return the cells that a folder holds, with their results; raise ParameterError if any is damaged."""
        found, violations = [], []
        for cell in self.cells:
            file = cell.file(folder)
            try:
                if file.exists():
                    found.append((cell, read_result(file)))
            except (OSError, ValueError) as error:
                reason = getattr(error, 'strerror', None) or 'is not as a benchmark wrote it'
                violations.append(f'{file}: {reason}; remove it, and --resume runs this cell again')
        if violations:
            raise ParameterError(violations)
        return found

    def run(self, folder: Path, progress: Callable[[int], object], stopped: Callable[[], bool]) -> Done:
        """
        Run the cells that a folder does not hold; each is written as soon as it is done.

        Returns
        -------
        list of (Cell, dict)
            All cells, or those that were done before it was stopped, with their results.
        """
        folder.mkdir(parents=True, exist_ok=True)
        # a damaged cell is told before hours of work
        self.held(folder)
        where, size = self.request.where, self.rollouts // len(self.cells)
        workers = 1 if where.scheduler or where.device != 'cpu' else min(where.workers or cores(), len(self.cells))
        if workers > 1:
            run_side_by_side(self.cells, workers, folder, size, progress, stopped)
        else:
            with runner(where) as run:
                run_cells(self.cells, run, folder, size, progress, stopped)
        return self.held(folder)


def benchmark_values(benchmark: Benchmark, done: Done) -> dict[str, Any]:
    """Return the content of `benchmark.json`, of all cells."""
    content = {name: track.content(benchmark.request.sources) for name, track in benchmark.tracks.items()}
    # a reason may name a file
    runs = [[cell.law, cell.track.name, cell.seed, *(
        {name: value for name, value in result.items() if name not in ('score', 'reason')}
        for result in found['results'])] for cell, found in done]
    hashed = {'arithmetic': ARITHMETIC, 'tracks': content, 'seeds': benchmark.seeds, 'budgets': benchmark.budgets,
              'scenarios': benchmark.request.scenarios, 'runs': runs}
    return {
        'hash': sha256(json.dumps(hashed, sort_keys=True).encode()).hexdigest()[:16],
        'laws': list(benchmark.laws), 'seeds': list(benchmark.seeds), 'budgets': list(benchmark.budgets),
        'scenarios': benchmark.request.scenarios, 'runs': benchmark.request.runs,
        'tracks': {name: {'purpose': track.parameters.purpose, 'source': track.source,
                          'success_within': track.parameters.success_within,
                          'published': [*published_rows(track, benchmark.request.sources)]}
                   for name, track in benchmark.tracks.items()},
        'results': [row for seed in benchmark.seeds for n, _ in enumerate(benchmark.budgets or (0,))
                    for name in benchmark.tracks for row in _track_rows(name, seed, n, done)],
    }


def _track_rows(
    track: str, seed: int, number: int, done: Done
) -> list[dict[str, Any]]:
    """Return the rows of a track with one seed and the n-th budget, the best law first."""
    found = {cell.law: (one['results'][number], one['step_time']) for cell, one in done
             if (cell.track.name, cell.seed) == (track, seed)}
    # a law that fails for a reason of its own is not compared
    judged = {law: [] if result['reason'] else judged_runs(result) for law, (result, _) in found.items()
              if was_searched(result)}
    fed = {law: judged_runs(found[law][0], 'fed_') for law, runs in judged.items() if runs}
    ranks = ranked(judged)
    shared = shared_scenarios({law: runs for law, runs in judged.items() if runs})
    fed_shared = shared_scenarios(fed)
    rows = [{'track': track, 'law': law, 'seed': seed, 'budget': result['budget'],
             'rank': ranks.get(law, (None, None))[0], 'last_rank': ranks.get(law, (None, None))[1],
             **_numbers(judged.get(law, []), shared, fed.get(law, []), fed_shared),
             'step_time': step, 'score': result.get('score'), 'reason': result['reason'],
             'gains': result.get('gains', {})} for law, (result, step) in found.items()]
    return sorted(rows, key=lambda row: (row['rank'] is None, bool(row['reason']), row['rank'] or 0,
                                         row['last_rank'] or 0, float('inf') if row['rms'] is None else row['rms']))


def _numbers(
    runs: Sequence[Judged], shared: Sequence[int], fed: Sequence[Judged], fed_shared: Sequence[int]
) -> dict[str, Any]:
    """Return the numbers of a row: success over all scenarios, the rest over those that all compared laws master."""
    successes = sum(run.success for run in runs)
    own = shared if runs and successes >= 0.5 * len(runs) else []

    def at(name: str, fraction: float = 0.5) -> float | None:
        return quantile([runs[n].metrics[name] for n in own], fraction)

    return {
        'runs': len(runs), 'successes': successes,
        'success_interval': list(wilson_interval(successes, len(runs))) if runs else None,
        'shared': len(own), 'rms': at(RANKED), 'rms_95': at(RANKED, 0.95), 'worst': at('max_position_error', 1.0),
        'settling_time': at('settling_time'), 'peak_wheel_torque': at('peak_wheel_torque'), 'energy': at('energy'),
        'torque_variation': at('torque_variation'), 'command_variation': at('command_variation'),
        'fed_successes': sum(run.success for run in fed),
        'fed_rms': quantile([fed[n].metrics[RANKED] for n in fed_shared], 0.5)
        if fed and 2 * sum(run.success for run in fed) >= len(fed) else None,
    }


def published_rows(track: Track, more: ParameterSources) -> Iterator[dict[str, Any]]:
    """Yield what a publication reports of laws that are there, with our numbers for its gains beside it."""
    for one in track.published:
        if one.law in LAWS:
            configuration = _published_loop(track, one, more)
            duration = track.parameters.laps * course_of(configuration.reference_cart).period
            found = summary(measure(configuration, duration))
            yield {'law': one.law, 'gains': one.gains, 'published': one.metrics,
                   'ours': {name: found[name] for name in one.metrics}}


def _published_loop(track: Track, one: Published, more: ParameterSources) -> Configuration:
    """Return the loop of a law with the gains of a publication, from its start."""
    values: dict[str, Any] = {f'position_controller.{one.law}.{name}': value for name, value in one.gains.items()}
    values['position_controller.controller_type'] = one.law
    if one.initial_pose is not None:
        values['plant.initial_pose'] = one.initial_pose
    return configure(track.sources(more).with_values(values).values())


def _check_published(track: Track, more: ParameterSources) -> None:
    """Raise ParameterError where a publication reports what a run does not have."""
    violations: list[str] = []
    for one in track.published:
        if one.law in LAWS:
            violations += (f"{one.law}: there is no metric '{name}'; {nearest(name, REPORTED)}" for name in one.metrics
                           if name not in REPORTED)
            try:
                _published_loop(track, one, more)
            except ParameterError as error:
                violations += (f'{one.law}: {violation}' for violation in error.violations)
    if violations:
        raise ParameterError(f'{track.file}: published: {violation}' for violation in violations)


COLUMNS = ('track', 'law', 'seed', 'budget', 'rank', 'last_rank', 'runs', 'successes', 'shared', 'rms', 'rms_95',
           'worst', 'settling_time', 'peak_wheel_torque', 'energy', 'torque_variation', 'command_variation',
           'fed_successes', 'fed_rms', 'step_time', 'score', 'reason')
"""Of `benchmark.csv`."""


def benchmark_table(values: Mapping[str, Any]) -> str:
    """Return `benchmark.csv`: a row for each law, track, seed and budget; empty where a number is not known."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(COLUMNS)
    writer.writerows([row[name] for name in COLUMNS] for row in values['results'])
    return text.getvalue()


class LawSummary(NamedTuple):
    """
    A law over the tracks, seeds and budgets of a benchmark for which it was searched.

    Attributes
    ----------
    law : str
        Its name.
    mean_rank : float
        Of the middles of its ranges of ranks; nan where it was searched for no table.
    first, tables : int
        Tables in which it is among the first, and all for which it was searched.
    success : float
        Share of all judged runs; nan likewise.
    failed, not_searched : tuple of str
        Tracks on which it could not be compared, and those on which its search could drive no candidate.
    """

    law: str
    mean_rank: float
    first: int
    tables: int
    success: float
    failed: tuple[str, ...]
    not_searched: tuple[str, ...]


def is_first(row: Mapping[str, Any]) -> bool:
    """Return whether no law is better for certain than that of a row, which succeeds in half of the runs at least."""
    return bool(row['rank'] == 1 and 0 < row['runs'] <= 2 * row['successes'])


def law_summaries(values: Mapping[str, Any]) -> list[LawSummary]:
    """Return the laws over all tables, that with the best mean rank first."""
    found = []
    for law in values['laws']:
        every = [row for row in values['results'] if row['law'] == law]
        rows = [row for row in every if was_searched(row)]
        found.append(LawSummary(
            law, fmean(0.5 * (row['rank'] + row['last_rank']) for row in rows) if rows else math.nan,
            sum(map(is_first, rows)), len(rows),
            sum(row['successes'] for row in rows) / (len(rows) * values['runs']) if rows else math.nan,
            tuple(dict.fromkeys(row['track'] for row in rows if row['reason'])),
            tuple(dict.fromkeys(row['track'] for row in every if not was_searched(row)))))
    return sorted(found, key=lambda one: (not one.tables, one.mean_rank if one.tables else 0.0, one.law))


def rank_text(row: Mapping[str, Any]) -> str:
    """
    Return the ranks that a law may have, as text; that of a law that was not searched says so.

    Examples
    --------
    >>> rank_text({'rank': 1, 'last_rank': 3}), rank_text({'rank': 2, 'last_rank': 2})
    ('1–3', '2')

    """
    first, last = row['rank'], row['last_rank']
    return NOT_SEARCHED if first is None else f'{first}' if first == last else f'{first}–{last}'


def number_text(value: float | None) -> str:
    """Return a number beside that of a publication; a dash where a run has none."""
    return '–' if value is None else f'{value:.5g}'


def summary_lines(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield what the command prints: the laws over all tracks, the published numbers, and the hash."""
    for one in law_summaries(values):
        failed = ''.join(f'; {what} on {", ".join(tracks)}' for what, tracks in (
            ('not compared', one.failed), (NOT_SEARCHED, one.not_searched)) if tracks)
        yield (f'{one.law}{failed}'.replace(';', ':', 1) if not one.tables else
               f'{one.law}: mean rank {one.mean_rank:.1f}, first or not told apart from it in {one.first} of '
               f'{one.tables} tables, success in {100.0 * one.success:.1f} % of the runs{failed}')
    for name, track in values['tracks'].items():
        for row in track['published']:
            both = ', '.join(f'{metric} {number_text(row["ours"][metric])} ({value:.5g} published)'
                             for metric, value in row['published'].items())
            yield f'{name}, {row["law"]} with the published gains: {both}'
    yield f'hash {values["hash"]}'
