"""Requested searches: loop, goal, scenarios and settings."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from hashlib import sha256
from typing import Annotated, Any, NamedTuple

import numpy as np

from mobile_robot_control.analysis.modelled import drive_of
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.control.velocity_law import PI
from mobile_robot_control.control.velocity_laws import VELOCITY_LAWS, selected_velocity_law
from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.loop.monte_carlo import LARGEST_SEED, ScenarioDistribution, draw_scenarios
from mobile_robot_control.loop.scenarios import Scenario, check_laps, configured_scenario, rubbed, scenario_grid
from mobile_robot_control.loop.workers import Workers
from mobile_robot_control.model.motors import LONGEST_DELAY
from mobile_robot_control.model.plant import VELOCITY as DRIVEN_BY_VELOCITY
from mobile_robot_control.parameters.declaration import INLINE, Field, ParameterError, flatten
from mobile_robot_control.parameters.requests import Reader, read_bounds
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.curves import CURVES, OF_FILES
from mobile_robot_control.reference.trajectory_parameters import TrajectoryRequest
from mobile_robot_control.search import space
from mobile_robot_control.search.gains import Gains, configured_gains
from mobile_robot_control.search.journal import Journal
from mobile_robot_control.search.objective import (
    COMBINATIONS,
    EQ29,
    OBJECTIVES,
    RMS,
    Goal,
    Objective,
    RunTrials,
    default_smooth,
)
from mobile_robot_control.search.search import ALGORITHMS, Generation, SearchSettings
from mobile_robot_control.search.space import MOST_GENES, PER_GENE, POPULATION, population_for
from mobile_robot_control.search.stages import REPEATS, WIDENINGS, Staged, StagePlan, search_in_stages
from mobile_robot_control.settings.configure import ParameterSources, configure
from mobile_robot_control.settings.nodes import Configuration, request_of
from mobile_robot_control.version import __version__

STAGED = 'nelder_mead'
"""The algorithm that searches in stages."""
_GENERATIONS = {True: 40, False: 150}
"""Generations of a search, by whether it is in stages."""
_STREAM = 2
"""Stream of the drawn frictions, apart from that of the random scenarios, which so stay the same."""


def _read_start(value: Any) -> Pose:
    """Read an offset of the start [m, m, rad], as DX,DY,DYAW or three numbers."""
    try:
        x, y, heading = map(float, value.split(',') if isinstance(value, str) else value)
    except (ValueError, TypeError):
        raise ValueError('write DX,DY,DYAW, such as --start=-0.2,0,0, or three numbers') from None
    return Pose(x, y, heading)


class ScenarioRequest(NamedTuple):
    """The scenarios of a search, in every combination; omitted fields are as configured."""

    curves: Annotated[tuple[str, ...], Field('', 'curves to drive; by default that of the cart', choices=CURVES)] = ()
    scales: Annotated[tuple[float, ...], Field('m', 'sizes of the curves; by default that of the cart', above=0.0)] = ()
    start: Annotated[tuple[Pose, ...], Field(
        '', "offset of the robot's start from the cart's: x, y [m] in the odometry frame, heading [rad]"),
        Reader(_read_start, 'DX,DY,DYAW', True, '--start=-0.2,0,0', Collection[tuple[float, float, float]])] = ()
    mass: Annotated[tuple[float, ...], Field('', "factors of the robot's mass and inertia, such as 0.8 and 1.2",
                                             above=0.0)] = (1.0,)
    friction: Annotated[tuple[float, ...], Field('', 'factors of its friction', above=0.0)] = (1.0,)
    delays: Annotated[tuple[int, ...], Field('', 'delays of the torques in velocity periods, such as 1 and 2 for '
                                             'the wall clock', minimum=0, maximum=LONGEST_DELAY)] = ()
    coulomb: Annotated[tuple[float, ...], Field(
        'N m', 'least and largest Coulomb friction at the axle of each wheel: listed scenarios are driven with both, '
        'random ones with one between', minimum=0.0, length=2)] = ()
    random: Annotated[int, Field('', 'number of random scenarios, beside those listed', minimum=0, maximum=100_000)] = 0
    variation: Annotated[float, Field('', 'largest relative change of mass and of friction in random scenarios',
                                      minimum=0.0, below=1.0)] = 0.2
    within: Annotated[float, Field('m', "largest distance of a random start from the cart's", above=0.0)] = 1.0
    scenario_seed: Annotated[int, Field('', 'seed of the random scenarios', minimum=0, maximum=LARGEST_SEED)] = 0


class SearchRequest(NamedTuple):
    """The request of a search; `controller` is a position law, or 'velocity'."""

    sources: ParameterSources
    controller: Annotated[str, Field(
        '', "gains to search: those of a position law and of the velocity law ('fuzzy' keeps the latter), or with "
        "'velocity' those of the velocity law alone", choices=space.SEARCHES)]
    seed: Annotated[int, Field('', 'seed of all random numbers', minimum=0, maximum=LARGEST_SEED)]
    algorithm: Annotated[str, Field(
        '', f'search algorithm: {STAGED}, which follows differential evolution, widens bounds that it reaches and is '
        'repeated with other seeds', choices=tuple(ALGORITHMS))] = STAGED
    population: Annotated[int | None, Field(
        '', f"individuals per generation; by default {POPULATION}, or {PER_GENE} a gain of more than {MOST_GENES}; of "
        "other algorithms, the chapter's 51 or 101", minimum=5, maximum=100_000)] = None
    generations: Annotated[int | None, Field(
        '', f'number of generations of each search; by default {_GENERATIONS[True]}, of other algorithms '
        f'{_GENERATIONS[False]}', minimum=1, maximum=10**9)] = None
    time_limit: Annotated[float | None, Field('s', 'wall time after which no generation begins', above=0.0)] = None
    bounds: Annotated[tuple[tuple[str, tuple[float, float]], ...], Field(
        '', 'low and high bounds of a gain, or of each in an array, by its name; other gains keep theirs'),
        Reader(read_bounds, 'NAME=LOW:HIGH', True, 'k1=0:5 or position_controller.fuzzy.b[1]=0:2',
               Mapping[str, tuple[float, float]])] = ()
    keep: Annotated[tuple[str, ...], Field('', 'gains to leave alone: k1, fuzzy.b[1] or the array fuzzy.b')] = ()
    with_velocity: Annotated[bool, Field('', "search the velocity gains, too, for a law that keeps them, such as "
                                         "'fuzzy'")] = False
    objective: Annotated[str, Field('', "what is minimised: Eq. (29) of the chapter, or the RMS position error [m]",
                                    choices=OBJECTIVES)] = EQ29
    combine: Annotated[str, Field('', 'how the objectives of the scenarios are combined',
                                     choices=tuple(COMBINATIONS))] = 'mean'
    literal_torque: Annotated[bool, Field('', 'use max(tau) in Eq. (29) as printed, instead of max|tau|')] = False
    smooth: Annotated[float | None, Field(
        '', 'weight of the total variation per second in the objective: of the torques of both wheels [N m/s]; on a '
        'base that takes velocities, of the commanded rim speeds of the wheels [m/s²]; by default '
        f'0, and {default_smooth(EQ29, DRIVEN_BY_VELOCITY):g} or, of the RMS error, '
        f'{default_smooth(RMS, DRIVEN_BY_VELOCITY):g}', minimum=0.0)] = None
    laps: Annotated[float, Field('', 'laps per rollout', above=0.0)] = 1.0
    scenarios: Annotated[ScenarioRequest, INLINE] = ScenarioRequest()
    where: Annotated[Workers, INLINE] = Workers()


def _scenarios(request: SearchRequest, parameters: Configuration) -> Iterator[Scenario]:
    """Yield the scenarios of a search: the listed ones, then the random ones."""
    wanted, nominal = request.scenarios, configured_scenario(parameters)
    curves: Sequence[str] = wanted.curves or (nominal.curve,)
    scales: Sequence[float] = wanted.scales or (nominal.scale,)
    delays: Sequence[int] = wanted.delays or (nominal.delay,)
    # by default the robot starts with the cart, on every curve
    is_placed = 'initial_pose' in request.sources.values()['plant']
    starts = wanted.start or (None if is_placed else Pose(0.0, 0.0, 0.0),)
    listed = scenario_grid(nominal, curves, scales, starts, wanted.mass, wanted.friction, delays)
    yield from (rubbed(one, value) for one in listed for value in wanted.coulomb) if wanted.coulomb else listed
    spread = ScenarioDistribution(tuple(curves), tuple(scales), wanted.within, wanted.variation, nominal.noise, 0)
    rng = np.random.default_rng((wanted.scenario_seed, _STREAM))
    for n, scenario in enumerate(draw_scenarios(spread, wanted.random, wanted.scenario_seed)):
        late = scenario._replace(delay=delays[n % len(delays)])
        yield rubbed(late, float(rng.uniform(wanted.coulomb[0], wanted.coulomb[1]))) if wanted.coulomb else late


class Search:
    """
    A search, checked and ready to run.

    Parameters
    ----------
    request : SearchRequest
        The request; ParameterError is raised if it cannot be searched.

    Attributes
    ----------
    parameters : Configuration
        The initial loop.
    goal : Goal
        Target of the optimisation.
    settings : SearchSettings
        Algorithm, sizes and seed.
    plan : StagePlan
        The searches after the first one.

    """

    def __init__(self, request: SearchRequest) -> None:
        self.request, self.parameters = request, _searched(request)
        self.goal = _goal(request, self.parameters)
        genes, staged = self.goal.genes, request.algorithm == STAGED
        population = population_for(len(genes)) if staged else space.population_of(request.controller)
        self.settings = SearchSettings(
            request.algorithm, len(genes), request.population or population,
            request.generations or _GENERATIONS[staged], request.seed, request.time_limit or 0.0)
        fixed = frozenset(space.names_of('bounds', genes, dict(request.bounds)))
        self.plan = StagePlan(WIDENINGS, REPEATS, fixed, space.numbers_of(
            genes, configured_gains(self.parameters))) if staged else StagePlan()

    @property
    def most_generations(self) -> int:
        """The largest number of generations of all searches together."""
        return self.settings.generations * self.plan.searches

    def run(
        self, trials: RunTrials, journal: Journal | None = None,
        progress: Callable[[Generation], object] = lambda _: None, stopped: Callable[[], bool] = lambda: False,
    ) -> Staged:
        """Search, with arguments as of `search_in_stages`."""
        return search_in_stages(
            self.settings, self.plan, self.goal.genes, lambda genes: Objective(
                self.parameters, self.goal._replace(genes=genes), trials), journal, progress, stopped)

    def purpose(self) -> dict[str, Any]:
        """Return everything that the scores depend on, by name."""
        parameters, goal = self.parameters, self.goal
        law, path = parameters.position_controller.control.controller_type, request_of(parameters.reference_cart)
        settings = self.settings._asdict()
        # a longer search in stages does not begin with a shorter one
        left = ('seconds',) if self.request.algorithm == STAGED else ('generations', 'seconds')
        kept = {name: settings[name] for name in settings if name not in left}
        loop = {f'{node}.{name}': value for node, group in parameters._asdict().items()
                for name, value in flatten(group).items()}
        # a search of Eq. (29) without `smooth` depends on neither, and resumes journals that lack them
        wanted = {name: value for name, value in goal._asdict().items()
                  if value not in {'smooth': (0.0,), 'objective': (EQ29,)}.get(name, ())}
        curves = {f"source of the curve '{one.curve}'": CURVES.checksum(one.curve)
                  for one in goal.scenarios if one.curve not in OF_FILES}
        points = (() if not path else path.points[:2] if isinstance(path, TrajectoryRequest) else
                  (*path.waypoints[:2], *filter(None, [path.waypoints.waits])))
        waypoints = {'waypoints': sha256(repr(points).encode()).hexdigest()[:16]} if path else {}
        velocity = self.parameters.velocity_controller.control.controller_type
        # journals of the PI law lack its name
        sources = {} if velocity == PI else {
            f"source of the velocity law '{velocity}'": VELOCITY_LAWS.checksum(velocity)}
        return {'version': __version__, 'arithmetic': ARITHMETIC, **kept, **wanted, **loop,
                f"source of the law '{law}'": LAWS.checksum(law), **sources, **curves, **waypoints}

    def tuned(self, gains: Gains) -> Configuration:
        """Return the loop with other gains, checked as a whole."""
        values = {node: flatten(group) for node, group in self.parameters._asdict().items()}
        law, velocity = selected_velocity_law(gains.velocity)
        values['velocity_controller'] |= {f'{law.group}.{name}': x for name, x in velocity._asdict().items()}
        values['position_controller'] |= flatten(gains.control)
        return configure(values)


def _searched(request: SearchRequest) -> Configuration:
    """Return the configuration of the searched gains; raise ParameterError if there is none."""
    parameters = request.sources.configuration()
    check_laps(request.laps, parameters)
    velocity, coulomb = request.controller == space.VELOCITY, request.scenarios.coulomb
    if coulomb and coulomb[0] > coulomb[1]:
        raise ParameterError([f'coulomb = {coulomb[0]:g} {coulomb[1]:g} N m begins with the larger one; write the '
                              'smaller one first'])
    if coulomb and parameters.plant.model.drive == DRIVEN_BY_VELOCITY:
        raise ParameterError([f"coulomb = {coulomb[0]:g} {coulomb[1]:g} N m acts on no robot with plant.drive = "
                              "'velocity': its base overcomes friction itself; leave it out, or set "
                              'plant.base.dead_zone'])
    if parameters.plant.model.drive == DRIVEN_BY_VELOCITY and (velocity or request.with_velocity):
        raise ParameterError(["plant.drive = 'velocity' has no velocity gains to search for: the base closes that loop "
                              "itself; search for those of a position law, without --with-velocity"])
    if velocity:
        return parameters
    control = parameters.position_controller.control._replace(controller_type=request.controller)
    return parameters._replace(position_controller=parameters.position_controller._replace(control=control))


def _goal(request: SearchRequest, parameters: Configuration) -> Goal:
    bounds = dict(request.bounds)
    genes = space.search_genes(request.controller, request.with_velocity, parameters.plant.model.drive,
                               parameters.velocity_controller.control.controller_type)
    genes = space.without(genes, request.keep)
    if parameters.plant.shared.feedforward.enabled:
        genes += space.feedforward_genes(bounds)
    genes = space.bounded(genes, bounds)
    if not genes:
        raise ParameterError([f"'{request.controller}' leaves nothing to search; --keep less, or declare ranges: "
                              'Field(..., search=(low, high))'])
    smooth = default_smooth(request.objective, drive_of(parameters)) if request.smooth is None else request.smooth
    return Goal(request.controller, genes, tuple(_scenarios(request, parameters)), request.laps, request.combine,
                request.literal_torque, smooth, request.objective)
