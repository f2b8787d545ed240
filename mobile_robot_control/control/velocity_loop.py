"""The velocity law as one part of the loop: its constants, and the step from command to wheel torques."""

from collections.abc import Callable
from typing import Any, NamedTuple

from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.velocity_pi import VelocityGains, VelocityPiState
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, WheelTorque


class VelocityConstants(NamedTuple):
    """
    The constants of the velocity loop.

    Attributes
    ----------
    gains : VelocityGains
        Of the PI law.
    limit : float
        Of its torques [N m]; 0 means none.
    nominal : Robot or tuple
        The robot's constants in the feedforward of the torques; () without it.
    """

    gains: VelocityGains
    limit: float
    nominal: Any = ()


class Asked(NamedTuple):
    """What the velocity loop is asked for: command and its age [s]; the reference's acceleration, () if it is unfed."""

    command: BodyVelocity
    acceleration: Any
    age: float


@jitable
def _unfed(
    state: VelocityPiState, request: Asked, measured: BodyVelocity, constants: VelocityConstants, robot: Robot,
    dt: float,
) -> tuple[VelocityPiState, WheelTorque]:
    """Run a step of the velocity law."""
    return velocity_pi.step(state, request.command, measured, constants.gains, robot, constants.limit, dt)


@jitable
def _fed(
    state: VelocityPiState, request: Asked, measured: BodyVelocity, constants: VelocityConstants, _robot: Robot,
    dt: float,
) -> tuple[VelocityPiState, WheelTorque]:
    """Run a step of the velocity law with feedforward."""
    return velocity_pi.fed_step(state, request.command, request.acceleration, request.age, measured, constants.gains,
                                constants.nominal, constants.limit, dt)


def velocity_step(feeds_torques: bool) -> Callable[..., tuple[VelocityPiState, WheelTorque]]:
    """Return the step ``(state, request, measured, constants, robot, dt) -> (state, torque)``, fed or not."""
    return _fed if feeds_torques else _unfed
