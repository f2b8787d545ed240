"""Scenarios of a search or study: curves, starts, robots, noise and delay; and the bounds of a run's length."""

import itertools
from collections.abc import Sequence
from typing import NamedTuple

from mobile_robot_control.loop.ticks import plant_grid
from mobile_robot_control.loop.trial import Trial, make_trial
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.motors import Delay
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.model.plant import TORQUE, PlantModel
from mobile_robot_control.model.plant_form import drive_at_rest, drive_constants, sensor_values, sensors_at_rest
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.declaration import ParameterError, build, flatten
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.course import Course, make_course
from mobile_robot_control.reference.curves import PATH
from mobile_robot_control.settings.nodes import Configuration, course_of, path_of

ONE_RUN = 1e9
"""[steps] of a single run: hours, with a progress bar."""
EACH_OF_MANY = 1e8
"""[steps] of each of many runs: compiled they take seconds, until progress shows."""


def check_run_length(asked: str, seconds: float, velocity_rate: float, most: float) -> None:
    """
    Check the length of a run before it begins.

    Parameters
    ----------
    asked : str
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
        raise ParameterError([f'{asked}: {steps:.3g} steps {at} would take too long; '
                              f'ask for at most {most:g} steps, {most / velocity_rate:g} s'])
    if round(steps) < 1:
        raise ParameterError([f'{asked}: {seconds:g} s is too short for a step {at}; '
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
        group, given = next((group, given) for group, given in groups.items() if name.startswith(group))
        short, _, index = name.removeprefix(group).partition('[')
        given[short] = value if not index else tuple(
            value if f'{n}]' == index else one for n, one in enumerate(given[short]))
    robot, model = build(Robot, groups['/**.robot.']), build(PlantModel, groups['plant.'])
    return configuration._replace(plant=plant._replace(model=model, shared=plant.shared._replace(robot=robot)))


def configured_scenario(configuration: Configuration) -> Scenario:
    """Return the scenario of a checked configuration, with its noise and delay."""
    curve, imperfect = configuration.reference_cart.curve, configuration.plant.model.imperfections
    return Scenario(curve.curve, curve.placement.scale, noise=imperfect.noise, delay=imperfect.delay.velocity_steps)


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
    cart = configuration.reference_cart
    placement = cart.curve.placement._replace(scale=scenario.scale)
    course = make_course(scenario.curve, placement, path_of(cart) if scenario.curve == PATH else ())
    varied = with_robot(configuration, scenario.robot) if scenario.robot else configuration
    prepared = make_trial(varied, laps * course.period, late * course.period)
    state = prepared.state
    if scenario.start is not None:
        state = state._replace(plant=dynamics.at_rest(_start(scenario.start, course)))
    loop = prepared.loop
    robot = _varied_robot(loop.plant.robot, scenario)
    model, grid = _varied_model(varied.plant.model, scenario, loop.plant.dt), plant_grid(configuration)
    plant, sensors = (discretise(robot, loop.plant.dt, loop.plant.centripetal_coupling),
                      sensor_values(model, robot, grid))
    return prepared._replace(
        curve=scenario.curve,
        path=prepared.path if scenario.curve == PATH else (),
        loop=loop._replace(
            plant=plant,
            imperfections=model.imperfections,
            placement=placement,
            drive=drive_constants(model, plant, grid),
            sensors=sensors,
            nominal=configuration.plant.shared.robot if loop.nominal else (),
        ),
        state=state._replace(drive=drive_at_rest(model, grid), sensors=sensors_at_rest(state.plant, sensors)),
    )


def _start(offset: Pose, course: Course) -> Pose:
    """Return where the robot starts, by its offset from the cart's start."""
    cart = course.reference(0.0).pose
    return Pose(cart.x + offset.x, cart.y + offset.y, cart.heading + offset.heading)


def _varied_robot(robot: Robot, scenario: Scenario) -> Robot:
    """Return a robot with a scenario's mass and friction."""
    return robot._replace(
        mass=robot.mass * scenario.mass,
        inertia=robot.inertia * scenario.mass,
        viscous_friction=robot.viscous_friction * scenario.friction,
    )


def _varied_model(model: PlantModel, scenario: Scenario, dt: float) -> PlantModel:
    """Return a plant with a scenario's noise and delay; for a base, mass and friction scale its lag and dead zone."""
    noisy = model.imperfections._replace(noise=scenario.noise)
    if model.drive == TORQUE:
        dry = model.friction._replace(coulomb=model.friction.coulomb * scenario.friction)
        return model._replace(imperfections=noisy._replace(delay=Delay(scenario.delay)), friction=dry)
    base = model.base
    return model._replace(imperfections=noisy, base=base._replace(
        lag=tuple(lag * scenario.mass for lag in base.lag),
        dead_zone=tuple(zone * scenario.friction for zone in base.dead_zone),
        dead_time=tuple(time + scenario.delay * dt for time in base.dead_time),
    ))


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

    All nodes then know the scenario's robot, and feedforward would foresee it: without feedforward the run is that of
    `scenario_trial`, unless a path is timed by the robot's mass.
    """
    varied = with_robot(configuration, scenario.robot) if scenario.robot else configuration
    cart, shared, model = varied.reference_cart, varied.plant.shared, varied.plant.model
    placement = cart.curve.placement._replace(scale=scenario.scale)
    curve = cart.curve if scenario.curve == PATH else cart.curve._replace(curve=scenario.curve, placement=placement)
    robot = shared._replace(robot=_varied_robot(shared.robot, scenario))
    changed = {node: part._replace(shared=robot) for node, part in varied._asdict().items()}
    found = Configuration(**changed)
    found = found._replace(
        reference_cart=found.reference_cart._replace(curve=curve),
        plant=found.plant._replace(model=_varied_model(model, scenario, 1.0 / shared.velocity_rate)))
    if scenario.start is None:
        return found
    at = _start(scenario.start, make_course(scenario.curve, placement, path_of(cart) if scenario.curve == PATH else ()))
    return found._replace(plant=found.plant._replace(initial_pose=tuple(at)))
