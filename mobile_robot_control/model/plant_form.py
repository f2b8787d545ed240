"""The functions that simulate a plant, chosen once: effects that are off cost nothing."""

from collections.abc import Callable
from typing import Any, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model import drivetrain
from mobile_robot_control.model.base import (
    Base,
    DiscreteBase,
    base_at_rest,
    base_step,
    base_structure,
    base_taking,
    discretise_base,
)
from mobile_robot_control.model.discretisation import DiscretePlant
from mobile_robot_control.model.driven import driven_step
from mobile_robot_control.model.drivetrain import Drivetrain
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.friction import Friction
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.model.motors import DelayLine, Motor, MotorState, empty_line, motors_at_rest
from mobile_robot_control.model.noise import Noise, measured_pose, measured_twist, measured_wheels
from mobile_robot_control.model.odometry import WheelAngles, WheelOdometry, odometry_of
from mobile_robot_control.model.plant import VELOCITY, Imperfections, PlantModel, actuated_step
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.model.sensors import (
    SensorConstants,
    advance_sensors,
    is_ideal,
    odometry_age,
    samples_on_their_way,
    seen_angles,
    seen_odometry,
    seen_wheels,
    sensor_constants,
    sensor_start,
    sensors_at_start,
)
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque, WheelVelocity


class PlantForm(NamedTuple):
    """
    The choice of functions that simulate a plant.

    Attributes
    ----------
    takes_velocity : bool
        Whether it is a base that takes velocity commands.
    has_motors : bool
        Whether its motors or friction are not ideal.
    has_sensors : bool
        Whether its sensors differ from the true motion with white noise.
    """

    takes_velocity: bool = False
    has_motors: bool = False
    has_sensors: bool = False


IDEAL = PlantForm()
"""Ideal motors and exact sensors."""


def plant_form(model: PlantModel) -> PlantForm:
    """Return the form that simulates a plant."""
    return PlantForm(model.drive == VELOCITY, not drivetrain.has_ideal_motors(model.motor, model.friction),
                     not is_ideal(model.encoders, model.odometry))


class Grid(NamedTuple):
    """Periods of the velocity and of the position grid [ns]."""

    velocity: int
    position: int


class MotorDrive(NamedTuple):
    """The state of non-ideal motors, and the torques asked for and not yet applied."""

    motors: MotorState
    line: DelayLine


def drive_constants(model: PlantModel, plant: DiscretePlant, grid: Grid) -> Any:
    """Return the constants of motors or base; () for ideal motors."""
    form = plant_form(model)
    if form.takes_velocity:
        return discretise_base(model.base, plant.robot, *grid, model.imperfections.noise.seed)
    return drivetrain.discretise_drivetrain(plant, model.motor, model.friction) if form.has_motors else ()


def drive_at_rest(model: PlantModel, grid: Grid) -> Any:
    """Return the state of motors or base at a run's start."""
    form = plant_form(model)
    if form.takes_velocity:
        return base_at_rest(model.base, *grid)
    line = empty_line(model.imperfections.delay)
    return MotorDrive(motors_at_rest(), line) if form.has_motors else line


@jitable
def _motor_step(
    state: PlantState, drive: MotorDrive, torque: WheelTorque, k: int, _plant: DiscretePlant, imperfect: Imperfections,
    motor_limit: float, constants: Drivetrain,
) -> tuple[PlantState, MotorDrive, WheelTorque, WheelTorque]:
    """Move a plant with motors and friction by one period; see `actuated_step`."""
    moved, motors, line, acting, applied = driven_step(
        state, drive.motors, drive.line, torque, k, constants, imperfect, motor_limit)
    return moved, MotorDrive(motors, line), acting, applied


def drive_step(form: PlantForm) -> Callable[..., Any]:
    """Return the function that moves the plant by a velocity period: `base_step`, `actuated_step` or its substitute."""
    if form.takes_velocity:
        return base_step
    return _motor_step if form.has_motors else actuated_step


class Sensing(NamedTuple):
    """
    The measurements of a robot; each takes ``(sensors, state, k, constants)`` at the k-th velocity tick.

    Attributes
    ----------
    wheels : callable
        Returns the wheel velocities of joint_states [rad/s].
    angles : callable
        Returns the angles of joint_states [rad].
    odometry : callable
        Returns pose and velocity of odom.
    advance : callable
        Returns the sensors at the tick, after the motion of the plant.
    age : callable
        Takes ``(sensors, k, constants)``; returns the age of odom's sample in velocity periods.
    """

    wheels: Callable[..., WheelVelocity]
    angles: Callable[..., WheelAngles]
    odometry: Callable[..., tuple[Pose, BodyVelocity]]
    advance: Callable[..., Any]
    age: Callable[..., int]


class ExactSensors(NamedTuple):
    """The constants of sensors that show the true motion, with noise."""

    robot: Robot
    noise: Noise


@jitable
def _exact_wheels(_sensors: tuple[()], state: PlantState, k: int, constants: ExactSensors) -> WheelVelocity:
    """Return the true wheel velocities and their noise."""
    return measured_wheels(wheel_velocity(state.velocity, constants.robot), constants.noise, k)


@jitable
def _exact_angles(_sensors: tuple[()], state: PlantState, _k: int, _constants: ExactSensors) -> WheelAngles:
    return WheelAngles(state.right_angle, state.left_angle)


@jitable
def _exact_odometry(
    _sensors: tuple[()], state: PlantState, k: int, constants: ExactSensors
) -> tuple[Pose, BodyVelocity]:
    """Return the true pose and velocity and their noise."""
    robot, noise = constants.robot, constants.noise
    pose = measured_pose(state.pose, noise, k)
    wheels = measured_wheels(wheel_velocity(state.velocity, robot), noise, k)
    return pose, measured_twist(state.velocity, wheels, noise, robot)


@jitable
def _unchanged(sensors: tuple[()], _state: PlantState, _k: int, _constants: ExactSensors) -> tuple[()]:
    """Return the state of sensors without a state."""
    return sensors


@jitable
def _no_age(_sensors: tuple[()], _k: int, _constants: ExactSensors) -> int:
    """Return the age of odometry that is sampled when it is shown: 0."""
    return 0


_EXACT = Sensing(_exact_wheels, _exact_angles, _exact_odometry, _unchanged, _no_age)
_REAL = Sensing(seen_wheels, seen_angles, seen_odometry, advance_sensors, odometry_age)


def sensing(form: PlantForm) -> Sensing:
    """Return the functions for measuring the plant."""
    return _REAL if form.has_sensors else _EXACT


def sensor_values(model: PlantModel, robot: Robot, grid: Grid) -> Any:
    """Return the constants of the sensors."""
    noise = model.imperfections.noise
    if is_ideal(model.encoders, model.odometry):
        return ExactSensors(robot, noise)
    return sensor_constants(robot, noise, model.encoders, model.odometry, *grid)


def sensors_at_rest(state: PlantState, constants: Any) -> Any:
    """Return the sensors at a run's start; () for exact ones."""
    return () if isinstance(constants, ExactSensors) else sensors_at_start(state, constants)


class PlantValues(NamedTuple):
    """
    The numbers from which the constants of a plant are computed.

    Attributes
    ----------
    robot : Robot
        Physical constants.
    imperfections : Imperfections
        Noise, delay and disturbance.
    motor, friction, base, odometry : Motor, Friction, Base and WheelOdometry
        As in the plant's parameters.
    max_wheel_torque : float
        Of each motor [N m]; 0 means none.
    period : int
        Of the velocity grid [ns].
    """

    robot: Robot
    imperfections: Imperfections
    motor: Motor
    friction: Friction
    base: Base
    odometry: WheelOdometry
    max_wheel_torque: float
    period: int


def value_names(values: PlantValues) -> list[str]:
    """Return the names of the numbers of a plant among all parameters, in the order of their row; '' for others."""
    parts = {'/**.robot.': values.robot, 'plant.': values.imperfections, 'plant.motor.': values.motor,
             'plant.friction.': values.friction, 'plant.base.': values.base, 'plant.odometry.': values.odometry}
    names = []
    for prefix, part in parts.items():
        for name, value in flatten(part).items():
            names += [f'{prefix}{name}[{n}]' for n in range(len(value))] if isinstance(value, tuple) else [
                f'{prefix}{name}']
    return [*names, 'plant.max_wheel_torque', '']


def structure(model: PlantModel, grid: Grid) -> tuple[Any, ...]:
    """Return what is the same for all plants with one scene: events, and lengths of queues, windows and delays."""
    base = base_structure(model.base, *grid) if model.drive == VELOCITY else (model.imperfections.delay,)
    if is_ideal(model.encoders, model.odometry):
        return base
    sensors = sensor_constants(Robot(), Noise(), model.encoders, model.odometry, *grid)
    return (*base, sensors.encoders, sensors.odometry.events, samples_on_their_way(sensors.odometry))


def plant_values(robot: Robot, model: PlantModel, period: int) -> PlantValues:
    """Return the numbers of a robot and its plant, for a period of the velocity grid [ns]."""
    return PlantValues(robot, model.imperfections, model.motor, model.friction, model.base, model.odometry,
                       model.max_wheel_torque, period)


@jitable
def _no_drive(_values: PlantValues, _plant: DiscretePlant, given: tuple[()]) -> tuple[()]:
    """Return the constants of ideal motors: none."""
    return given


@jitable
def _motor_drive(values: PlantValues, plant: DiscretePlant, _given: Drivetrain) -> Drivetrain:
    return drivetrain.discretise_drivetrain(plant, values.motor, values.friction)


@jitable
def _base_drive(values: PlantValues, plant: DiscretePlant, given: DiscreteBase) -> DiscreteBase:
    return base_taking(values.base, plant.robot, given.taken, values.period, values.imperfections.noise.seed)


def drive_of_values(form: PlantForm) -> Callable[..., Any]:
    """Return the function ``(values, plant, given)`` that computes `drive_constants` for the events of given ones."""
    return _base_drive if form.takes_velocity else _motor_drive if form.has_motors else _no_drive


@jitable
def _exact_sensors(values: PlantValues, _given: ExactSensors) -> ExactSensors:
    return ExactSensors(values.robot, values.imperfections.noise)


@jitable
def _real_sensors(values: PlantValues, given: SensorConstants) -> SensorConstants:
    odometry = given.odometry
    return SensorConstants(values.robot, values.imperfections.noise, given.encoders, odometry_of(
        values.odometry, values.robot, odometry.events, odometry.slip_periods, values.period))


@jitable
def _exact_start(_state: PlantState, _constants: ExactSensors) -> tuple[()]:
    """Return the state of sensors without a state."""
    return ()


def sensors_of_values(form: PlantForm, constants: Any) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """
    Return the functions that compute `sensor_values` and `sensors_at_rest`.

    The first one is ``(values, given)``, for the encoders and the events of given constants; the second one has the
    windows and delays of those constants.
    """
    return (_real_sensors, sensor_start(constants)) if form.has_sensors else (_exact_sensors, _exact_start)
