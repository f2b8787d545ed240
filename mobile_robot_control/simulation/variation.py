"""Total variation of what a loop asks of its motors over a run: how rough it drives."""

from collections.abc import Callable
from typing import NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, WheelTorque


class Variation(NamedTuple):
    """
    The variation of a run so far.

    Attributes
    ----------
    total : float
        Sum of all changes, of both wheels [N m], or [m/s] at their rims.
    command, torque : BodyVelocity, WheelTorque
        The newest ones.

    """

    total: float = 0.0
    command: BodyVelocity = BodyVelocity(0.0, 0.0)
    torque: WheelTorque = WheelTorque(0.0, 0.0)


@jitable
def unvaried(variation: Variation, _command: BodyVelocity, _torque: WheelTorque, _robot: Robot) -> Variation:
    """Return a variation as it is: the form of runs whose variation is not asked for."""
    return variation


@jitable
def varied_torque(variation: Variation, command: BodyVelocity, torque: WheelTorque, _robot: Robot) -> Variation:
    """Add the change of the torques of both wheels [N m] since the last velocity period; the first is from rest."""
    changed = abs(torque.right - variation.torque.right) + abs(torque.left - variation.torque.left)
    return Variation(variation.total + changed, command, torque)


@jitable
def varied_command(variation: Variation, command: BodyVelocity, torque: WheelTorque, robot: Robot) -> Variation:
    """Add the change of the speeds of both wheels' rims that a command asks for [m/s]; the first is from rest."""
    before, now = wheel_velocity(variation.command, robot), wheel_velocity(command, robot)
    changed = robot.wheel_radius * (abs(now.right - before.right) + abs(now.left - before.left))
    return Variation(variation.total + changed, command, torque)


def variation_step(
    varies: bool, takes_velocity: bool
) -> Callable[[Variation, BodyVelocity, WheelTorque, Robot], Variation]:
    """Return what sums the variation of a run: of the torque, or of the command where a base takes no torque."""
    if not varies:
        return unvaried
    return varied_command if takes_velocity else varied_torque
