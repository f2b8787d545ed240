"""Which functions simulate a plant: chosen once, so that what is off costs nothing."""

from collections.abc import Callable
from typing import Any, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.actuators import empty_line
from mobile_robot_control.model.base import discretise_base
from mobile_robot_control.model.base_motion import base_at_rest, base_step
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.model.noise import Noise, measured_pose, measured_twist, measured_wheels
from mobile_robot_control.model.plant import VELOCITY, PlantModel, actuated_step
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelVelocity


class PlantForm(NamedTuple):
    """
    Which functions simulate a plant.

    Attributes
    ----------
    takes_velocity : bool
        Whether it is a base that takes velocity commands.
    """

    takes_velocity: bool = False


IDEAL = PlantForm()
"""Ideal motors and exact sensors."""


def plant_form(model: PlantModel) -> PlantForm:
    """Return the form that simulates a plant."""
    return PlantForm(model.drive == VELOCITY)


class Grid(NamedTuple):
    """Periods of the velocity and of the position grid [ns]."""

    velocity: int
    position: int


def drive_constants(model: PlantModel, robot: Robot, grid: Grid) -> Any:
    """Return the constants of what moves the robot; () for ideal motors."""
    return discretise_base(model.base, robot, *grid) if model.drive == VELOCITY else ()


def drive_at_rest(model: PlantModel, grid: Grid) -> Any:
    """Return the state of what moves the robot at a run's start."""
    return base_at_rest(model.base, *grid) if model.drive == VELOCITY else empty_line(model.imperfections.delay)


def drive_step(form: PlantForm) -> Callable[..., Any]:
    """Return what moves the plant by one velocity period: `base_step`, or `actuated_step` and what stands for it."""
    return base_step if form.takes_velocity else actuated_step


class Sensing(NamedTuple):
    """
    What a robot measures of itself.

    Attributes
    ----------
    wheels : callable
        ``(sensors, state, k, robot, noise, constants) -> WheelVelocity``: of joint_states [rad/s].
    odometry : callable
        ``(sensors, state, k, robot, noise, constants) -> (Pose, BodyVelocity)``: of odom.
    advance : callable
        ``(sensors, state, k, robot, noise, constants) -> sensors``: after the plant has moved to the k-th tick.
    """

    wheels: Callable[..., WheelVelocity]
    odometry: Callable[..., tuple[Pose, BodyVelocity]]
    advance: Callable[..., Any]


@jitable
def _exact_wheels(
    _sensors: tuple[()], state: PlantState, k: int, robot: Robot, noise: Noise, _constants: tuple[()]
) -> WheelVelocity:
    """Return the true wheel velocities and their noise."""
    return measured_wheels(wheel_velocity(state.velocity, robot), noise, k)


@jitable
def _exact_odometry(
    _sensors: tuple[()], state: PlantState, k: int, robot: Robot, noise: Noise, _constants: tuple[()]
) -> tuple[Pose, BodyVelocity]:
    """Return the true pose and velocity and their noise."""
    pose = measured_pose(state.pose, noise, k)
    wheels = measured_wheels(wheel_velocity(state.velocity, robot), noise, k)
    return pose, measured_twist(state.velocity, wheels, noise, robot)


@jitable
def _unchanged(
    sensors: tuple[()], _state: PlantState, _k: int, _robot: Robot, _noise: Noise, _constants: tuple[()]
) -> tuple[()]:
    """Return the state of sensors that have none."""
    return sensors


_EXACT = Sensing(_exact_wheels, _exact_odometry, _unchanged)


def sensing(_form: PlantForm) -> Sensing:
    """Return what measures the plant."""
    return _EXACT
