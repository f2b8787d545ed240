"""Torques on the wheels that no controller asked for."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import WheelTorque


class Disturbance(NamedTuple):
    """Torques on the wheels that no controller asked for."""

    time: Annotated[float, Field('s', 'when impulse and step begin', minimum=0.0, maximum=1e6)] = 0.0
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
        Step of the velocity loop that begins.
    dt : float
        Its period [s].

    Returns
    -------
    WheelTorque
        Bit for bit the motors' where there is no disturbance.
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
