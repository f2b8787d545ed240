"""The motors: dead time and torque limit; a torque that falls with speed and lags behind its request."""

from collections.abc import Iterator
from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field, rule
from mobile_robot_control.quantities import LARGEST, SMALLEST, WheelTorque


class Motor(NamedTuple):
    """The motors of both wheels, gears included: values hold at the axle. 0 makes a motor ideal in that respect."""

    stall_torque: Annotated[
        float, Field('N m', 'torque of each motor at standstill; it falls linearly to zero at no_load_speed: larger '
                            'accelerates harder; 0 for no such line, needs no_load_speed', minimum=0.0)
    ] = 0.0
    no_load_speed: Annotated[
        float, Field('rad/s', 'speed of the wheel at which its motor gives no torque; beyond it the motor brakes: '
                              'larger drives faster; 0 for no such line, needs stall_torque', minimum=0.0)
    ] = 0.0
    time_constant: Annotated[
        float, Field('s', 'time constant of the lag of each torque behind its request, 0 for none: larger '
                          'destabilises the velocity loop', minimum=0.0)
    ] = 0.0


@rule
def _the_line_has_two_ends(motor: Motor) -> Iterator[str]:
    if motor.stall_torque > 0.0 and motor.no_load_speed == 0.0:
        yield (f'motor.stall_torque = {motor.stall_torque} N m needs motor.no_load_speed: set both, or '
               'max_wheel_torque for a limit that is the same at every speed')
    if motor.no_load_speed > 0.0 and motor.stall_torque == 0.0:
        yield (f'motor.no_load_speed = {motor.no_load_speed} rad/s needs motor.stall_torque: set both, or none for '
               'a torque that does not fall with speed')


@rule
def _what_divides_is_large_enough(motor: Motor) -> Iterator[str]:
    for name, value, unit in (('no_load_speed', motor.no_load_speed, 'rad/s'),
                              ('time_constant', motor.time_constant, 's')):
        if 0.0 < value < SMALLEST:
            yield f'motor.{name} = {value} {unit} is below {SMALLEST:g}; write a larger number, or 0 for none'


class MotorState(NamedTuple):
    """
    The state of both motors between two steps.

    Attributes
    ----------
    torque : WheelTorque
        Torques reached by the lag [N m]; the torque-speed line, which has no memory, may reduce them.
    """

    torque: WheelTorque


def motors_at_rest() -> MotorState:
    """Return the state at a run's start: no torque."""
    return MotorState(WheelTorque(0.0, 0.0))


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
