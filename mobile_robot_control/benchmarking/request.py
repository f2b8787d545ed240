"""A benchmark that is asked for: laws on tracks, each law searched with one budget and judged where no search was."""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.analysis.modelled import drive_of
from mobile_robot_control.benchmarking.cell import Cell
from mobile_robot_control.benchmarking.cell_result import Done, read_result
from mobile_robot_control.benchmarking.judged_table import NAME, JudgedTable, content_digits, read_judged_table
from mobile_robot_control.benchmarking.node_cell import NodeRequest, next_run, of_budgets, refuse_tracks
from mobile_robot_control.benchmarking.side_by_side import run_cells, run_side_by_side, run_together
from mobile_robot_control.control.laws import BUILT_IN, LAWS
from mobile_robot_control.control.velocity_laws import VELOCITY_LAWS
from mobile_robot_control.loop.metric_table import INDEX_METRICS, RUN_METRICS
from mobile_robot_control.loop.monte_carlo import LARGEST_SEED
from mobile_robot_control.loop.pool import cores
from mobile_robot_control.loop.workers import Workers, runner
from mobile_robot_control.model.plant import TORQUE
from mobile_robot_control.parameters.declaration import INLINE, Field, ParameterError, nearest
from mobile_robot_control.parameters.requests import make_request
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import measure
from mobile_robot_control.search.objective import OBJECTIVES
from mobile_robot_control.search.space import MOST_GENES, POPULATION
from mobile_robot_control.search.stages import AGREE, REPEATS
from mobile_robot_control.settings.configure import ParameterSources, configure
from mobile_robot_control.settings.nodes import Configuration, course_of
from mobile_robot_control.settings.tracks import Published, Track, read_track, shipped_tracks

_FIRST_SEED, _FIRST_BUDGET = 1, 500
_NO_NODES = NodeRequest()
REPORTED = [one.name for one in (*RUN_METRICS, *INDEX_METRICS) if one.better and not one.of_wheels]
"""The metrics that a publication may report: numbers of a run."""


class BenchmarkRequest(NamedTuple):
    """What a benchmark is asked for."""

    sources: ParameterSources
    laws: Annotated[tuple[str, ...], Field('', 'position laws to compare; all, with your own, if left out',
                                           choices=LAWS)] = ()
    tracks: Annotated[tuple[str, ...], Field('', 'tracks of this package by name, or files of your own; all of this '
                                             'package, if left out')] = ()
    velocity_laws: Annotated[tuple[str, ...], Field(
        '', 'velocity laws to compare, each with every position law; otherwise all have that of the parameters',
        choices=VELOCITY_LAWS)] = ()
    seed: Annotated[int, Field('', 'seed of the searches and of all scenarios', minimum=0,
                               maximum=LARGEST_SEED)] = _FIRST_SEED
    seeds: Annotated[tuple[int, ...], Field('', 'several seeds instead: how ranks depend on the draw', minimum=0,
                                            maximum=LARGEST_SEED)] = ()
    budgets: Annotated[tuple[int, ...], Field(
        '', f'candidates of each search; a fifth as many a gain for laws with more than {MOST_GENES}; of several, each '
        'is searched and judged', minimum=POPULATION, maximum=10**7)] = (_FIRST_BUDGET,)
    restarts: Annotated[int, Field('', 'searches of each law, track and seed with other seeds, in the last bounds: '
                                   f'two that end within {100 * AGREE:g} % of the best one have converged', minimum=0,
                                   maximum=1000)] = REPEATS
    objective: Annotated[str | None, Field('', 'what searches minimise: Eq. (29) of the chapter, or the RMS position '
                                           'error; by default what each track says', choices=OBJECTIVES)] = None
    feedforward: Annotated[bool, Field('', 'search and judge with feedforward, too: twice the work')] = False
    tune: Annotated[bool, Field('', 'take gains as configured, and search for none')] = True
    scenarios: Annotated[int, Field('', 'scenarios of a search', minimum=1, maximum=1000)] = 8
    runs: Annotated[int, Field('', 'scenarios that judge', minimum=2, maximum=100_000)] = 100
    against: Annotated[str | None, Field('', f'another benchmark, as its {NAME}: only your own laws and nodes are '
                                         'driven, with its seeds, budgets and scenarios, and ranked among its laws')
                       ] = None
    where: Annotated[Workers, INLINE] = Workers()


class Benchmark:
    """
    A benchmark, checked and ready to run.

    Parameters
    ----------
    request : BenchmarkRequest
        What is asked for; ParameterError is raised where that cannot be compared.
    others : NodeRequest
        Nodes of somebody else beside the laws.

    Attributes
    ----------
    cells : list of Cell
        In the order in which they run: a law with all its tracks is compiled once.
    names : tuple of str
        Of what competes: laws, or pairs of a position and a velocity law, and nodes.
    nodes : dict of str to ForeignNode
        Of somebody else, by the names of their rows.
    tracks : dict of str to Track
        By name.
    table : JudgedTable or None
        That its laws are ranked against.
    """

    def __init__(self, request: BenchmarkRequest, others: NodeRequest = _NO_NODES) -> None:
        if request.sources.robot is not None:
            raise ParameterError(['--robot is not taken: each track names its robot; write a track of your own'])
        self.table = read_judged_table(Path(request.against)) if request.against else None
        bases = not request.velocity_laws or bool(request.tracks)
        self.nodes = others.nodes()
        if self.table:
            request = _of_the_table(request, self.table, self.nodes)
        self.request = request
        self.laws = tuple(dict.fromkeys(request.laws or (() if self.table else LAWS)))
        self.seeds = tuple(dict.fromkeys(request.seeds or (request.seed,)))
        self.budgets = tuple(sorted(set(request.budgets))) if request.tune else ()
        tracks = _tracks(request, bases)
        if self.nodes:
            refuse_tracks(tracks, request.sources)
        self.tracks = {track.name: track for track in tracks}
        if not tracks or len(self.tracks) < len(tracks):
            raise ParameterError(['--tracks: two files have one name; rename one' if tracks else
                                  '--tracks: the package is installed without its tracks; name files of your own'])
        seeds = dict.fromkeys(self.tracks, self.seeds)
        if self.table:
            _check_tracks(tracks, self.table, request.sources)
            seeds = {name: self.table.tracks[name]['seeds'] for name in self.tracks}
            self.seeds = tuple(sorted({seed for own in seeds.values() for seed in own}))
        competing = [(law, None, feedforward) for feedforward in (False, True)[:1 + request.feedforward]
                     for law in self.laws]
        self.cells = [Cell(
            law=law, track=track, seed=seed, budgets=self.budgets, training=request.scenarios,
            runs=others.runs(len(seeds[track.name]), request.runs) if node else request.runs,
            restarts=request.restarts, objective=self.objective(track), feedforward=feedforward, more=request.sources,
            velocity_law=velocity_law, node=node, repeats=bool(node) and seed == min(seeds[track.name]))
                      for law, node, feedforward in (*competing, *((*one, False) for one in self.nodes.items()))
                      for velocity_law in dict.fromkeys(request.velocity_laws) or ('',)
                      for track in tracks for seed in seeds[track.name]]
        self.names = tuple(dict.fromkeys(cell.name for cell in self.cells))
        # what is wrong with a track is said at once
        for track in tracks:
            configuration = track.sources(request.sources).configuration()
            self.cells[0]._replace(track=track).drawn('judging', configuration, 1)
            _check_published(track, request.sources)

    def objective(self, track: Track) -> str:
        """Return what searches on a track minimise."""
        if self.table:
            return str(self.table.tracks[track.name]['objective'])
        return self.request.objective or track.parameters.objective

    @property
    def law_cells(self) -> list[Cell]:
        """The cells of laws."""
        return [cell for cell in self.cells if not cell.node]

    @property
    def rollouts(self) -> int:
        """How many rollouts a whole benchmark has."""
        return sum(cell.rollouts for cell in self.cells)

    def held(self, folder: Path) -> Done:
        """Return the cells that a folder holds, with their results; raise ParameterError if any is damaged."""
        done, violations = [], []
        for cell in self.cells:
            file = cell.file(folder)
            try:
                result = read_result(file) if file.exists() else None
                if result and cell.node:
                    result = None if next_run(cell, result) is not None else of_budgets(cell, result)
                if result:
                    done.append((cell, result))
            except (OSError, ValueError) as error:
                reason = getattr(error, 'strerror', None) or 'is not as a benchmark wrote it'
                violations.append(f'{file}: {reason}; remove it, and --resume runs this cell again')
        if violations:
            raise ParameterError(violations)
        return done

    def run(self, folder: Path, progress: Callable[[int], object], stopped: Callable[[], bool]) -> Done:
        """
        Run the cells of laws that a folder does not hold; each is written as soon as it is done.

        Returns
        -------
        list of (Cell, CellResult)
            All cells, or those that were done before it was stopped, with their results.
        """
        folder.mkdir(parents=True, exist_ok=True)
        # a damaged cell is told before hours of work
        self.held(folder)
        where, cells = self.request.where, self.law_cells
        workers = 1 if where.scheduler or where.device != 'cpu' else min(where.workers or cores(), len(cells))
        if workers > 1:
            run_side_by_side(cells, workers, folder, progress, stopped)
        else:
            with runner(where) as run:
                in_one_process = run_cells if where.device == 'cpu' else run_together
                in_one_process(cells, run, folder, progress, stopped)
        return self.held(folder)


def _tracks(request: BenchmarkRequest, bases: bool) -> list[Track]:
    """Return the tracks that are asked for, those of bases that take velocities if wanted; these have no such law."""
    tracks = [read_track(given) for given in dict.fromkeys(request.tracks or shipped_tracks())]
    if not request.velocity_laws:
        return tracks
    on_torques = [track for track in tracks if drive_of(track.sources(request.sources).configuration()) == TORQUE]
    left_out = [track for track in tracks if track not in on_torques]
    if bases and left_out:
        raise ParameterError([f"--velocity-laws: the robot of the track '{track.name}' takes velocity commands, so "
                              'it has no velocity law; leave the track out' for track in left_out])
    return on_torques


def _of_the_table(request: BenchmarkRequest, table: JudgedTable, nodes: Collection[str]) -> BenchmarkRequest:
    """Return a request as a table was made; raise ParameterError where it asks for something else."""
    sizes = {name: getattr(table, name) for name in ('budgets', 'restarts', 'scenarios', 'runs')}
    for track in table.tracks.values():
        make_request(BenchmarkRequest, {'sources': request.sources, **sizes, 'seeds': track['seeds'],
                                        'objective': track['objective']})
    held = {'seed': _FIRST_SEED, 'seeds': (), 'objective': None, 'tune': bool(table.budgets), **sizes}
    violations = [f'--{name} is that of the table, which --against compares with; leave it out'
                  for name, value in held.items()
                  if getattr(request, name) not in (value, BenchmarkRequest._field_defaults[name])]
    laws = request.laws or tuple(law for law in LAWS if LAWS[law] not in BUILT_IN and law not in table.laws)
    violations += [f"--against: the table has a law '{law}' already; rename yours" for law in (*laws, *nodes)
                   if law in table.laws and not request.velocity_laws]
    if not laws and not nodes:
        violations.append('--against: no law is here but those of the package and of the table; load yours with --law '
                          'FILE, or name a node with --node')
    if violations:
        raise ParameterError(violations)
    tracks = request.tracks or tuple(table.tracks)
    return request._replace(**{**held, 'laws': laws, 'tracks': tracks})


def _check_tracks(tracks: Sequence[Track], table: JudgedTable, more: ParameterSources) -> None:
    """Raise ParameterError where a table lacks a track, or has another one of that name."""
    violations = []
    for track in tracks:
        if track.name not in table.tracks:
            violations.append(f"--against: the table has no track '{track.name}'; {nearest(track.name, table.tracks)}")
    violations += differing_tracks('--against', tracks, table, more)
    if violations:
        raise ParameterError(violations)


def differing_tracks(
    option: str, tracks: Iterable[Track], table: JudgedTable, more: ParameterSources
) -> list[str]:
    """Return which tracks are others than those of their names in the table of an option, with the remedy."""
    return [f"{option}: the track '{track.name}' is another one than that of the table, so their runs cannot be "
            'compared; leave it out, or take the table of this version'
            for track in tracks if track.name in table.tracks
            and table.tracks[track.name]['content'] != content_digits(track, more)]


def published_rows(track: Track, more: ParameterSources) -> Iterator[dict[str, Any]]:
    """Yield what a publication reports of laws that are there, with our numbers for its gains beside it."""
    for report in track.published:
        if report.law in LAWS:
            configuration = _published_loop(track, report, more)
            duration = track.parameters.laps * course_of(configuration.reference_cart).period
            metrics = summary(measure(configuration, duration))
            yield {'law': report.law, 'gains': report.gains, 'published': report.metrics,
                   'ours': {name: metrics[name] for name in report.metrics}}


def _published_loop(track: Track, report: Published, more: ParameterSources) -> Configuration:
    """Return the loop of a law with the gains of a publication, from its start."""
    values: dict[str, Any] = {f'position_controller.{report.law}.{name}': value for name, value in report.gains.items()}
    values['position_controller.controller_type'] = report.law
    if report.initial_pose is not None:
        values['plant.initial_pose'] = report.initial_pose
    return configure(track.sources(more).with_values(values).values())


def _check_published(track: Track, more: ParameterSources) -> None:
    """Raise ParameterError where a publication reports what a run does not have."""
    violations: list[str] = []
    for report in track.published:
        if report.law in LAWS:
            violations += (f"{report.law}: there is no metric '{name}'; {nearest(name, REPORTED)}"
                           for name in report.metrics if name not in REPORTED)
            try:
                _published_loop(track, report, more)
            except ParameterError as error:
                violations += (f'{report.law}: {violation}' for violation in error.violations)
    if violations:
        raise ParameterError(f'{track.file}: published: {violation}' for violation in violations)
