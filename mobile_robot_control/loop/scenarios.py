"""Scenarios of a search or study: curves, starts, robots, noise and delay; and the bounds of a run's length."""

import itertools
import operator
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

from mobile_robot_control.jit import jitable_apart
from mobile_robot_control.loop.closed_loop import Loop, LoopState
from mobile_robot_control.loop.ticks import plant_grid
from mobile_robot_control.loop.trial import Trial, make_trial
from mobile_robot_control.model.drawn_robot import Draw, make_drawn_robot
from mobile_robot_control.model.motors import Delay
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.model.plant import TORQUE, PlantModel, true_robot
from mobile_robot_control.model.plant_form import PlantForm, PlantValues, plant_values, sensors_of_values
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.declaration import ParameterError, build, flatten
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.course import make_course
from mobile_robot_control.reference.curves import OF_FILES
from mobile_robot_control.settings.nodes import Configuration, course_of, request_of
from mobile_robot_control.trees import replacing

ONE_RUN = 1e9
"""[steps] of a single run: hours, with a progress bar."""
EACH_OF_MANY = 1e8
"""[steps] of each of many runs: compiled they take seconds, until progress shows."""
COULOMB = 'plant.friction.coulomb'
"""Among the values of a scenario's robot."""


def check_run_length(option: str, seconds: float, velocity_rate: float, most: float) -> None:
    """
    Check the length of a run before it begins.

    Parameters
    ----------
    option : str
        The option with its value, for the message.
    seconds : float
        Simulated time [s].
    velocity_rate : float
        Steps of the run in a second [Hz].
    most : float
        Largest number of steps.

    Raises
    ------
    ParameterError
        If the run would have no step, or too many.

    Examples
    --------
    >>> check_run_length('--duration 16', 16.0, 500.0, ONE_RUN)

    """
    steps = seconds * velocity_rate
    at = f'at velocity_rate = {velocity_rate:g} Hz'
    if steps > most:
        raise ParameterError([f'{option}: {steps:.3g} steps {at} would take too long; '
                              f'ask for at most {most:g} steps, {most / velocity_rate:g} s'])
    if round(steps) < 1:
        raise ParameterError([f'{option}: {seconds:g} s is too short for a step {at}; '
                              f'ask for at least {1.0 / velocity_rate:g} s'])


def check_laps(laps: float, parameters: Configuration) -> None:
    """Check the length of each of many runs from its laps, as `check_run_length` does."""
    period = course_of(parameters.reference_cart).period
    check_run_length(f'--laps {laps:g} of reference_cart.period = {period!r} s', laps * period,
                     parameters.plant.shared.velocity_rate, EACH_OF_MANY)


class Scenario(NamedTuple):
    """
    The conditions of one run.

    Attributes
    ----------
    curve : str
        Of CURVES.
    scale : float
        Of the curve [m].
    start : Pose or None
        Offset of the robot's start from the reference cart's start, in the axes of the odometry frame [m], [rad]; None
        is the configured `initial_pose`.
    mass, friction : float
        Factors on the configured robot's mass and inertia, and on its friction; for a base that takes velocity
        commands, on its lag and on its dead zone.
    noise : Noise
        Of the measurements.
    delay : int
        Of the torques, or added to the dead time of such a base [velocity periods].
    robot : tuple of (str, float)
        Parameters of the plant with other values than configured, by names such as ``plant.base.lag[0]`` and
        ``/**.robot.mass``; the factors of mass and friction apply to them, too.
    """

    curve: str
    scale: float
    start: Pose | None = None
    mass: float = 1.0
    friction: float = 1.0
    noise: Noise = Noise()
    delay: int = 0
    robot: tuple[tuple[str, float], ...] = ()


def with_robot(configuration: Configuration, values: Sequence[tuple[str, float]]) -> Configuration:
    """Return a configuration with other values of its plant; raise ParameterError if one is out of bounds."""
    plant = configuration.plant
    groups = {'/**.robot.': flatten(plant.shared.robot), 'plant.': flatten(plant.model)}
    for name, value in values:
        group, fields = next((group, given) for group, given in groups.items() if name.startswith(group))
        short, _, index = name.removeprefix(group).partition('[')
        fields[short] = value if not index else tuple(
            value if f'{n}]' == index else one for n, one in enumerate(fields[short]))
    robot, model = build(Robot, groups['/**.robot.']), build(PlantModel, groups['plant.'])
    return configuration._replace(plant=plant._replace(model=model, shared=plant.shared._replace(robot=robot)))


def configured_scenario(configuration: Configuration) -> Scenario:
    """Return the scenario of a checked configuration, with its noise and delay."""
    curve, imperfect = configuration.reference_cart.curve, configuration.plant.model.imperfections
    return Scenario(curve.curve, curve.placement.scale, noise=imperfect.noise, delay=imperfect.delay.velocity_steps)


def rubbed(scenario: Scenario, coulomb: float) -> Scenario:
    """Return a scenario with another Coulomb friction at the axle of each wheel [N m]."""
    return scenario._replace(robot=((COULOMB, coulomb),))


def frictions(configuration: Configuration, scenarios: Sequence[Scenario]) -> tuple[list[float], list[float]]:
    """Return the viscous [N m s/rad] and the Coulomb frictions [N m] in scenarios of a search, each ascending."""
    plant = configuration.plant
    return (sorted({plant.shared.robot.viscous_friction * one.friction for one in scenarios}),
            sorted({dict(one.robot).get(COULOMB, plant.model.friction.coulomb) * one.friction for one in scenarios}))


class Scene(NamedTuple):
    """
    What runs have in common that differ by their draws.

    Attributes
    ----------
    trial : Trial
        Of all of them, with the configured start, mass, friction and seed.
    values : PlantValues
        Of its plant.
    cart : Pose
        At the start.
    """

    trial: Trial
    values: PlantValues
    cart: Pose

    @property
    def varied(self) -> Callable[..., tuple[LoopState, Loop]]:
        """The function that computes a run's start and constants; see `make_varied`."""
        form, sensors = self.trial.form.plant, self.trial.loop.robot.sensors
        return make_varied(form, *sensors_of_values(form, sensors))

    def run(self, draw: Draw) -> Trial:
        """Return the trial of a draw."""
        state, loop = self.varied(self.trial.state, self.trial.loop, self.values, draw)
        return self.trial._replace(state=state, loop=loop)


def make_scene(configuration: Configuration, scenario: Scenario, laps: float, late: float) -> Scene:
    """Make the scene of a scenario: its curve, scale, delay and robot; see `scenario_trial`."""
    cart = configuration.reference_cart
    placement = cart.curve.placement._replace(scale=scenario.scale)
    course = make_course(scenario.curve, placement, request_of(cart) if scenario.curve in OF_FILES else ())
    varied = with_robot(configuration, scenario.robot) if scenario.robot else configuration
    shared = varied.plant.shared
    model = delayed_model(varied.plant.model, scenario, 1.0 / shared.velocity_rate)
    driven = varied._replace(plant=varied.plant._replace(model=model))
    prepared = make_trial(driven, laps * course.period, late * course.period)
    loop = prepared.loop
    trial = prepared._replace(
        curve=scenario.curve,
        placement=placement,
        path=prepared.path if scenario.curve in OF_FILES else (),
        loop=loop._replace(velocity=loop.velocity._replace(nominal=configuration.plant.shared.robot)),
    )
    return Scene(trial, plant_values(*true_robot(shared.robot, model), plant_grid(configuration).velocity),
                 course.reference(0.0).pose)


def scenario_trial(configuration: Configuration, scenario: Scenario, laps: float, late: float) -> Trial:
    """
    Make the trial of a configuration in a scenario, with the robot at rest at the start.

    Parameters
    ----------
    configuration : Configuration
        Checked; the controllers keep its nominal robot.
    scenario : Scenario
        Conditions of the run.
    laps : float
        Length of the run.
    late : float
        Laps after which the late totals begin.
    """
    scene = make_scene(configuration, scenario, laps, late)
    start = (scene.trial.state.robot.motion.pose if scenario.start is None else
             Pose(*map(operator.add, scene.cart, scenario.start)))
    return scene.run(Draw(start, scenario.mass, scenario.friction, scenario.noise.seed))


_with_state, _with_constants = replacing(LoopState, 'robot'), replacing(Loop, 'robot')


@lru_cache(maxsize=64)
def make_varied(
    form: PlantForm, sensors_of: Callable[..., object], sensors_start: Callable[..., object]
) -> Callable[..., tuple[LoopState, Loop]]:
    """
    Make the function ``(state, loop, values, draw)`` that returns state and constants of a run, plain or compiled.

    State and loop are those of the scene, with the events, windows and delays of its plant.
    """
    drawn_robot = make_drawn_robot(form, sensors_of, sensors_start)

    @jitable_apart
    def varied(state: LoopState, loop: Loop, values: PlantValues, draw: Draw) -> tuple[LoopState, Loop]:
        robot, constants = drawn_robot(state.robot, loop.robot, values, draw)
        return _with_state(state, robot), _with_constants(loop, constants)

    return varied


def delayed_model(model: PlantModel, scenario: Scenario, dt: float) -> PlantModel:
    """Return a plant with a scenario's noise and delay, which a base adds to its dead time."""
    noisy = model.imperfections._replace(noise=scenario.noise)
    if model.drive == TORQUE:
        return model._replace(imperfections=noisy._replace(delay=Delay(scenario.delay)))
    return model._replace(imperfections=noisy, base=model.base._replace(
        dead_time=tuple(time + scenario.delay * dt for time in model.base.dead_time)))


def scenario_grid(
    nominal: Scenario,
    curves: Sequence[str],
    scales: Sequence[float],
    starts: Sequence[Pose | None],
    masses: Sequence[float],
    frictions: Sequence[float],
    delays: Sequence[int],
) -> list[Scenario]:
    """Return every combination of values of a scenario's fields, the last one changing fastest; all with one noise."""
    return [Scenario(curve, scale, start, mass, friction, nominal.noise, delay)
            for curve, scale, start, mass, friction, delay
            in itertools.product(curves, scales, starts, masses, frictions, delays)]


def scenario_configuration(configuration: Configuration, scenario: Scenario) -> Configuration:
    """
    Return a configuration that runs as a scenario, for the nodes.

    Controllers keep their nominal robot; of values of the scenario's robot by name, all nodes know those of `robot.*`.
    """
    varied = with_robot(configuration, scenario.robot) if scenario.robot else configuration
    cart, shared, model = varied.reference_cart, varied.plant.shared, varied.plant.model
    placement = cart.curve.placement._replace(scale=scenario.scale)
    curve = cart.curve if scenario.curve in OF_FILES else cart.curve._replace(curve=scenario.curve, placement=placement)
    model = delayed_model(model, scenario, 1.0 / shared.velocity_rate)
    model = model._replace(mass_factor=model.mass_factor * scenario.mass,
                           friction_factor=model.friction_factor * scenario.friction)
    scene = Configuration(**{node: part._replace(shared=shared) for node, part in varied._asdict().items()})
    scene = scene._replace(reference_cart=scene.reference_cart._replace(curve=curve),
                           plant=scene.plant._replace(model=model))
    if scenario.start is None:
        return scene
    course = make_course(scenario.curve, placement, request_of(cart) if scenario.curve in OF_FILES else ())
    start = map(operator.add, course.reference(0.0).pose, scenario.start)
    return scene._replace(plant=scene.plant._replace(initial_pose=tuple(start)))
