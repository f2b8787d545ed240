"""Motors with a torque that falls with speed and lags behind its request."""

from collections.abc import Iterator
from typing import Annotated, NamedTuple

from mobile_robot_control.parameters.checking import rule
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import SMALLEST, WheelTorque


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
