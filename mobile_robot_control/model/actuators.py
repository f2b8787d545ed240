"""The motors: a dead time and a torque limit."""

from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import LARGEST, WheelTorque

LONGEST_DELAY = 8
"""In periods of the velocity loop."""


class Delay(NamedTuple):
    """Dead time of the motors; 0 means none."""

    velocity_steps: Annotated[
        int, Field('', 'periods of the velocity loop by which the torques act late: larger destabilises the '
                   'velocity loop', minimum=0, maximum=LONGEST_DELAY)
    ] = 0


DelayLine = tuple[WheelTorque, ...]
"""The torques asked for and not yet applied, newest first: as many as the delay has periods."""


def empty_line(delay: Delay) -> DelayLine:
    """Return the delay line at a run's start: zeros."""
    return (WheelTorque(0.0, 0.0),) * delay.velocity_steps


@jitable
def delayed(line: DelayLine, torque: WheelTorque) -> tuple[DelayLine, WheelTorque]:
    """
    Return the delay line for the next period, and the torque [N m] that acts now.

    Parameters
    ----------
    line : tuple of WheelTorque
        Torques asked for before, newest first; as long as the delay, so that code compiled without a delay has no trace
        of it.
    torque : WheelTorque
        Torque asked for now.
    """
    whole = (torque, *line)
    return whole[:-1], whole[-1]


@jitable
def saturate(torque: WheelTorque, limit: float) -> WheelTorque:
    """Limit the torque [N m] of each wheel separately; at limit 0 only the bound of a message holds."""
    bound = limit if 0.0 < limit < LARGEST else LARGEST
    return WheelTorque(max(-bound, min(bound, torque.right)), max(-bound, min(bound, torque.left)))
