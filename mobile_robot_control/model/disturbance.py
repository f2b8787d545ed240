"""Disturbances of the robot: torques on its wheels, pushes at its body."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.robot import Robot, half_separation
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import Push, WheelTorque


class Disturbance(NamedTuple):
    """Disturbance torques on the wheels."""

    time: Annotated[float, Field('s', 'start of impulse and step', minimum=0.0, maximum=1e6)] = 0.0
    impulse: Annotated[
        tuple[float, ...],
        Field('N m s', 'impulse on the right and the left wheel, within one velocity period: larger pushes the robot '
              'farther off', length=2)
    ] = (0.0, 0.0)
    step: Annotated[
        tuple[float, ...], Field('N m', 'lasting torque on the right and the left wheel: larger pushes harder',
                                 length=2)
    ] = (0.0, 0.0)


@jitable
def disturbed(torque: WheelTorque, disturbance: Disturbance, k: int, dt: float) -> WheelTorque:
    """
    Add the disturbance to the motors' torque.

    Parameters
    ----------
    torque : WheelTorque
        Of the motors [N m].
    disturbance : Disturbance
        Impulse and step.
    k : int
        Step of the velocity loop, about to begin.
    dt : float
        Its period [s].

    Returns
    -------
    WheelTorque
        Bit for bit the motors' torque if there is no disturbance.
    """
    right, left = disturbance.step
    impulse_right, impulse_left = disturbance.impulse
    if right == 0.0 and left == 0.0 and impulse_right == 0.0 and impulse_left == 0.0:
        return torque
    first = math.ceil(disturbance.time / dt - 1e-9)
    if k < first:
        return torque
    if k == first:
        right += impulse_right / dt
        left += impulse_left / dt
    return WheelTorque(torque.right + right, torque.left + left)


def wheel_torques_of(wrench: Push, robot: Robot) -> WheelTorque:
    """
    Return the torques on the wheels [N m] with the same work as a push at point A.

    Parameters
    ----------
    wrench : Push
        Force and torque in the robot's frame [N], [N m].
    robot : Robot
        Physical constants.

    Notes
    -----
    With Eq. (5)-(7) of the chapter, v = r/2 (ω_R + ω_L) and ω = r/(2R) (ω_R - ω_L), the power F v + T ω is
    τ_R ω_R + τ_L ω_L of these torques for every motion.

    """
    half_radius = 0.5 * robot.wheel_radius
    turning = wrench.torque / half_separation(robot)
    return WheelTorque(half_radius * (wrench.force + turning), half_radius * (wrench.force - turning))


def with_push(disturbance: Disturbance, wrench: Push, k: int, dt: float, robot: Robot) -> Disturbance:
    """
    Return the disturbance of one step, with a push added.

    Parameters
    ----------
    disturbance : Disturbance
        Impulse and step.
    wrench : Push
        The push, held over the step [N], [N m].
    k : int
        Step of the velocity loop, about to begin.
    dt : float
        Its period [s].
    robot : Robot
        Physical constants.

    """
    return Disturbance(step=disturbed(wheel_torques_of(wrench, robot), disturbance, k, dt))
