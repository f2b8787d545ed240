"""Requested studies: controllers, and the scenarios and robots that are drawn for them."""

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from operator import mul
from os import PathLike, fspath
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from mobile_robot_control.elementary import normal
from mobile_robot_control.identification.result import read_estimates
from mobile_robot_control.loop.drawn import Draws
from mobile_robot_control.loop.metric_table import BAND
from mobile_robot_control.loop.monte_carlo import (
    LARGEST_SEED,
    METRICS,
    WITHIN,
    ScenarioDistribution,
    Scenarios,
    draw_scenarios,
)
from mobile_robot_control.loop.scenarios import check_laps, configured_scenario, with_robot
from mobile_robot_control.loop.workers import Workers
from mobile_robot_control.model.motors import LONGEST_DELAY
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.parameters.declaration import INLINE, Field, ParameterError
from mobile_robot_control.parameters.requests import Reader, read_bounds
from mobile_robot_control.reference.curves import CURVES, OF_FILES
from mobile_robot_control.settings.configure import File, ParameterSources
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.studying.comparison import COMPARED
from mobile_robot_control.studying.maps import check_map, on_a_map
from mobile_robot_control.system.texts import printable

_TRIES = 100
_LEFT = 1e-12
"""Share of a variance below which its estimate follows from those before it."""
_STREAM = 1
"""Stream of random numbers apart from that of the scenarios, which so stay the same."""


def draw_robots(
    file: str, configuration: Configuration, count: int, seed: int
) -> Iterator[tuple[tuple[str, float], ...]]:
    """
    Yield the parameters of robots drawn from the estimates in a file of `identify`.

    The first ones do not depend on the count. A robot with a parameter out of bounds, such as a negative lag, is drawn
    again.

    Raises
    ------
    ParameterError
        If the file has no estimates, the plant has none of its parameters, or no drawn robot is within the bounds.
    """
    names, estimates, covariance, _ = read_estimates(file)
    values = estimates.tolist()
    factor = _factor(covariance.tolist())

    def named(drawn: Sequence[float]) -> tuple[tuple[str, float], ...]:
        return tuple(zip(names, drawn, strict=True))

    try:
        with_robot(configuration, named(values))
    except (ParameterError, KeyError, StopIteration, IndexError) as error:
        reason = str(error) if isinstance(error, ParameterError) else f'the plant has no parameter {error}'
        raise ParameterError([f'--robot-uncertainty {file}: {reason}']) from None
    random = np.random.default_rng((seed, _STREAM))
    for _ in range(count):
        for _ in range(_TRIES):
            drawn = [normal(1.0 - first, second) for first, second in random.random((len(values), 2)).tolist()]
            robot = named([value + math.fsum(map(mul, row, drawn)) for value, row in zip(values, factor, strict=True)])
            try:
                with_robot(configuration, robot)
            except ParameterError as error:
                reason = '; '.join(error.violations)
            else:
                yield robot
                break
        else:
            raise ParameterError([f'--robot-uncertainty {file}: of {_TRIES} drawn robots none is within '
                                  f'the bounds of the plant: {reason}'])


def _factor(covariance: list[list[float]]) -> list[list[float]]:
    """Return the rows of L, with L Lᵀ the covariance (Cholesky); zeros where nothing is left of a variance."""
    rows: list[list[float]] = []
    for n, variances in enumerate(covariance):
        row: list[float] = []
        for m, other in enumerate(rows):
            left = variances[m] - math.fsum(map(mul, row, other))
            row.append(left / other[m] if other[m] > 0.0 else 0.0)
        left = variances[n] - math.fsum(one * one for one in row)
        rows.append([*row, math.sqrt(left) if left > _LEFT * variances[n] else 0.0])
    return rows


class ComparedController(NamedTuple):
    """
    A controller of a study, in addition to the other parameters.

    Attributes
    ----------
    name : str
        Name in tables.
    path : str
        A parameter file; '' for none.
    values : mapping of str to object
        By ``NODE.PARAMETER``.

    """

    name: str
    path: str = ''
    values: Mapping[str, object] = {}

    def added_to(self, sources: ParameterSources) -> ParameterSources:
        """Return sources with this controller's parameters added."""
        return (sources.with_files(self.path) if self.path else sources).with_values(self.values)


def _read_compared(value: Any) -> ComparedController:
    """Read a parameter file, or a name with a file or with values."""
    if isinstance(value, str | PathLike):
        return ComparedController(printable(Path(value).stem), os.fspath(value))
    name, controller = value
    if isinstance(controller, Mapping):
        return ComparedController(name, '', controller)
    return ComparedController(name, os.fspath(controller))


class StudyRequest(NamedTuple):
    """The request of a study."""

    sources: ParameterSources
    runs: Annotated[int, Field('', 'random runs per controller', minimum=1, maximum=10**6)]
    seed: Annotated[int, Field('', 'seed of all random numbers', minimum=0, maximum=LARGEST_SEED)]
    compare: Annotated[
        tuple[ComparedController, ...], Field(
            '', 'parameter files, one per controller, on top of the other parameters'),
        Reader(_read_compared, 'FILE.yaml')] = ()
    laps: Annotated[float, Field('', 'laps per run; the last quarter decides on success', above=0.0)] = 2.0
    curves: Annotated[
        tuple[str, ...], Field('', 'curves to draw from; a configured path replaces them', choices=CURVES)
    ] = ('trifolium', 'lemniscate')
    scales: Annotated[tuple[float, ...], Field('m', 'sizes to draw from', above=0.0)] = (0.5, 1.0)
    within: Annotated[float, Field('m', "largest distance of the start from the cart's; the heading is random",
                                     above=0.0)] = 1.0
    variation: Annotated[float | None, Field('', 'largest relative change of mass (with the inertia) and of friction; '
                                             'by default 0.2, or 0 with robot_uncertainty', minimum=0.0,
                                             below=1.0)] = None
    robot_uncertainty: Annotated[str | None, Field('', 'parameter file of identify: each run draws a robot from '
                                                   'its covariance, the same for all controllers; it is the '
                                                   'robot, too, where none is named'),
                                 Reader(fspath, 'FILE.yaml', python=File)] = None
    noise_pose: Annotated[tuple[float, ...], Field('', 'replaces noise.pose: x, y [m] and heading [rad]', minimum=0.0,
                                                   length=3)] = ()
    noise_velocity: Annotated[float | None, Field('rad/s', 'replaces noise.velocity', minimum=0.0)] = None
    longest_delay: Annotated[int | None, Field(
        '', 'largest delay, drawn from 0 on, in velocity periods; replaces delay.velocity_steps', minimum=0,
        maximum=LONGEST_DELAY)] = None
    metric: Annotated[tuple[str, ...], Field(
        '', 'metrics to compare controllers by; their intervals hold together, and the first one decides which is best',
        choices=METRICS)] = COMPARED
    success_within: Annotated[float, Field('m', 'largest distance from the reference over the last quarter of a '
                                           'successful run', above=0.0)] = WITHIN
    settled_within: Annotated[float, Field('m', 'error band of settling_time and share_within_band', above=0.0)] = BAND
    map: Annotated[tuple[tuple[str, tuple[float, float]], ...], Field(
        '', 'two quantities with bounds: the runs lie on a square grid over both, and have all else in common, with '
        "the first curve and scale; the start's x, y [m] and heading [rad], the factors mass and friction, or "
        'parameters of the plant, such as plant.base.lag[0]', length=2),
        Reader(read_bounds, 'NAME=LOW:HIGH', example='x=-1:1 y=-1:1', python=Mapping[str, tuple[float, float]])] = ()
    where: Annotated[Workers, INLINE] = Workers()

    @property
    def metrics(self) -> tuple[str, ...]:
        """The compared metrics, each once."""
        return tuple(dict.fromkeys(self.metric))

    @property
    def varied_by(self) -> float:
        """Largest relative change of mass and of friction."""
        return self.variation if self.variation is not None else 0.0 if self.robot_uncertainty else _VARIATION

    @property
    def nominal(self) -> ParameterSources:
        """The sources of the parameters: the file of an identified robot counts as its robot file."""
        robot = self.sources.robot or self.robot_uncertainty
        return self.sources._replace(robot=robot)


_VARIATION = 0.2


def _curves(request: StudyRequest, parameters: Configuration) -> tuple[str, ...]:
    """Return the curves to draw from: a configured path or trajectory takes their place."""
    configured = parameters.reference_cart.curve.curve
    return (configured,) if configured in OF_FILES else request.curves


def drawn_scenarios(request: StudyRequest, parameters: Configuration) -> Scenarios:
    """Draw the scenarios of a controller."""
    nominal = configured_scenario(parameters)
    noise = Noise(
        nominal.noise.pose if not request.noise_pose else request.noise_pose,
        nominal.noise.velocity if request.noise_velocity is None else request.noise_velocity,
    )
    distribution = ScenarioDistribution(_curves(request, parameters), request.scales, request.within,
                                        request.varied_by, noise, request.longest_delay or 0)
    drawn = draw_scenarios(distribution, request.runs, request.seed)
    if request.longest_delay is None:
        drawn.delay[:] = nominal.delay
    if request.robot_uncertainty is not None:
        robots = [*draw_robots(request.robot_uncertainty, parameters, request.runs, request.seed)]
        drawn.robot_names = tuple(name for name, _ in robots[0])
        drawn.robots = np.array([[value for _, value in one] for one in robots])
    if request.map and request.robot_uncertainty is not None:
        raise ParameterError(['--map: leave --robot-uncertainty out; the robot is that of the file'])
    curve = _curves(request, parameters)[0]
    return on_a_map(request.map, parameters, drawn, curve, request.scales[0]) if request.map else drawn


def studied_controllers(request: StudyRequest) -> dict[str, Configuration]:
    """Return the configurations to study by name; raise ParameterError if they cannot be run."""
    named: dict[str, Configuration] = {}
    for compared in request.compare:
        # files of one name in different folders
        name = compared.name if compared.name not in named else printable(compared.path)
        if name in named:
            raise ParameterError([f'--compare {compared.path}: is named twice; name each file once'])
        named[name] = compared.added_to(request.nominal).configuration()
    if not named:
        parameters = request.nominal.configuration()
        named[parameters.position_controller.control.controller_type] = parameters
    if request.map:
        check_map(request.map, request.runs)
    for parameters in named.values():
        check_laps(request.laps, parameters)
        # the corners of a map, and the file of uncertain robots
        drawn_scenarios(request._replace(runs=4), parameters)
    return named


def study_draws(request: StudyRequest, parameters: Configuration, by_odometry: bool = False) -> Draws:
    """Return what the runs of a controller have in common, judged by their true pose or by odometry."""
    return Draws(
        parameters, request.laps, request.laps * 0.75,
        lambda form: form._replace(indices=not by_odometry, band=request.settled_within, by_odometry=by_odometry),
        request.success_within, {})
