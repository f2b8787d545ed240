"""Both wheels within a period: their state, the torques on them, and their motion until the next event."""

import math
from typing import NamedTuple

from mobile_robot_control.jit import jitable_apart
from mobile_robot_control.model.axle import Axle
from mobile_robot_control.model.discretisation import QUADRATURE
from mobile_robot_control.model.dynamics import mean_velocity
from mobile_robot_control.model.modes import Course, Load, Modes, course
from mobile_robot_control.model.responses import held_response
from mobile_robot_control.quantities import WheelTorque

_MOST_PIECES = 24


class Wheel(NamedTuple):
    """
    One wheel and its motor at a time within a period.

    Attributes
    ----------
    speed : float
        Exactly 0.0 for a standing wheel [rad/s].
    angle : float
        Angle turned since the period's start [rad].
    fading : float
        Lagging torque minus the one asked for [N m].
    lacking : float
        ∫ of the torque asked for less the motor's since the period's start [N m s].
    direction : float
        Direction of motion against its friction: 1.0, -1.0, or 0.0 at standstill or without friction.
    line : float
        Torque-speed line that its motor is on: 1.0 forwards, -1.0 backwards, or 0.0 within both.
    """

    speed: float
    angle: float
    fading: float
    lacking: float
    direction: float
    line: float


class Rolling(NamedTuple):
    """
    Both wheels at a time within a period.

    Attributes
    ----------
    x, y : float
        Displacement since the period's start in the odometry frame [m].
    right, left : Wheel
        Of each wheel.
    """

    x: float
    y: float
    right: Wheel
    left: Wheel


class Forcing(NamedTuple):
    """
    The torques held over a period.

    Attributes
    ----------
    asked : WheelTorque
        Of the motors, limited [N m].
    outside : WheelTorque
        Torques on the wheels that do not come through the motors [N m].
    heading : float
        At the period's start [rad].
    """

    asked: WheelTorque
    outside: WheelTorque
    heading: float


@jitable_apart
def held_torque(wheel: Wheel, asked: float, outside: float, axle: Axle) -> float:
    """Return the torque [N m] on a wheel that neither fades nor depends on its speed."""
    motor = wheel.line * axle.stall_torque if wheel.line != 0.0 else asked
    return motor + outside - axle.coulomb * wheel.direction


@jitable_apart
def _damping(wheel: Wheel, axle: Axle) -> float:
    """Return the viscous damping of a wheel [N m s/rad], with that of a motor on its line."""
    viscous = axle.viscous_friction
    return viscous + axle.slope if wheel.line != 0.0 else viscous


@jitable_apart
def find_load(right: Wheel, left: Wheel, forcing: Forcing, axle: Axle) -> Load:
    """Return the load of both wheels."""
    rough = axle.coulomb > 0.0
    return Load(
        WheelTorque(held_torque(right, forcing.asked.right, forcing.outside.right, axle),
                    held_torque(left, forcing.asked.left, forcing.outside.left, axle)),
        WheelTorque(right.fading if right.line == 0.0 else 0.0, left.fading if left.line == 0.0 else 0.0),
        _damping(right, axle),
        _damping(left, axle),
        rough and right.direction == 0.0,
        rough and left.direction == 0.0,
    )


@jitable_apart
def _later(wheel: Wheel, speed: float, angle: float, asked: float, time: float, axle: Axle) -> Wheel:
    """Return a wheel and its motor after a time [s] and a turn by an angle [rad]."""
    if wheel.line != 0.0:
        lacking = (asked - wheel.line * axle.stall_torque) * time + axle.slope * angle
    elif wheel.fading != 0.0:
        lacking = -wheel.fading * held_response(axle.lag_rate, time).gain
    else:
        lacking = 0.0
    fading = wheel.fading
    if fading != 0.0:
        fading *= held_response(axle.lag_rate, time).decay
    return Wheel(speed, wheel.angle + angle, fading, wheel.lacking + lacking, wheel.direction, wheel.line)


@jitable_apart
def _travelled(rolling: Rolling, modes: Modes, begin: float, end: float, forcing: Forcing, axle: Axle
               ) -> tuple[float, float]:
    """Return the displacement [m] between two times [s] of a course."""
    first, middle, last = QUADRATURE
    length = end - begin
    one = course(modes, axle.lag_rate, begin + first * length)
    two = course(modes, axle.lag_rate, begin + middle * length)
    three = course(modes, axle.lag_rate, begin + last * length)
    x, y = mean_velocity(
        (_forward(one, axle), _forward(two, axle), _forward(three, axle)),
        (_heading(rolling, one, forcing, axle), _heading(rolling, two, forcing, axle),
         _heading(rolling, three, forcing, axle)),
    )
    return length * x, length * y


@jitable_apart
def _forward(now: Course, axle: Axle) -> float:
    """Return the forward velocity [m/s]: Eq. (5), (6)."""
    return 0.5 * axle.wheel_radius * (now.speed.right + now.speed.left)


@jitable_apart
def _heading(rolling: Rolling, now: Course, forcing: Forcing, axle: Axle) -> float:
    """Return the heading [rad]: Eq. (7), integrated."""
    turned = (rolling.right.angle + now.right_angle) - (rolling.left.angle + now.left_angle)
    return forcing.heading + 0.5 * axle.wheel_radius * turned / axle.half_separation


@jitable_apart
def rolled(rolling: Rolling, modes: Modes, forcing: Forcing, time: float, axle: Axle) -> Rolling:
    """
    Return both wheels after a time [s] without events: only speeds and lagging torques change.

    Speeds, angles and torques are exact; the position is the sixth-order quadrature of `dynamics.step`, over pieces
    that begin with the fastest time constant and double. So it is equally accurate for light robots and fast turns.
    """
    if time <= 0.0:
        return rolling
    fastest = max(modes.first.rate, modes.second.rate)
    if rolling.right.fading != 0.0 or rolling.left.fading != 0.0:
        fastest = max(fastest, axle.lag_rate)
    after = course(modes, axle.lag_rate, time)
    # a piece turns by about half a radian at most
    turns = max(abs(rolling.right.speed - rolling.left.speed), abs(after.speed.right - after.speed.left))
    longest = time / math.ceil(1.0 + turns * time * axle.wheel_radius / axle.half_separation)
    x, y, begin = rolling.x, rolling.y, 0.0
    length = min(longest, time if fastest * time <= 1.0 else 1.0 / fastest)
    for piece in range(_MOST_PIECES):
        end = begin + length if begin + length < time and piece < _MOST_PIECES - 1 else time
        along_x, along_y = _travelled(rolling, modes, begin, end, forcing, axle)
        x += along_x
        y += along_y
        if end == time:
            break
        length = min(longest, end)
        begin = end
    return Rolling(
        x,
        y,
        _later(rolling.right, after.speed.right, after.right_angle, forcing.asked.right, time, axle),
        _later(rolling.left, after.speed.left, after.left_angle, forcing.asked.left, time, axle),
    )
