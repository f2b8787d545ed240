"""Both wheels within a period: two independent first-order motions on one axle, solved exactly to the next event."""

import math
from typing import NamedTuple

from mobile_robot_control.jit import jitable_apart
from mobile_robot_control.model.discretisation import QUADRATURE, fading_response, held_response
from mobile_robot_control.model.drivetrain import Axle
from mobile_robot_control.model.dynamics import mean_velocity
from mobile_robot_control.quantities import WheelTorque, WheelVelocity


class Mode(NamedTuple):
    """
    An independent motion: x' = push + fade exp(-t/T) - rate x.

    Attributes
    ----------
    rate : float
        [1/s].
    right, left : float
        Factor of x in the speed of each wheel; the speed is the sum over both modes.
    start, push, fade : float
        x(0), and the terms of the equation above.
    """

    rate: float
    right: float
    left: float
    start: float
    push: float
    fade: float


class Modes(NamedTuple):
    """Both motions; while one wheel stands the second is empty, while both stand both are."""

    first: Mode
    second: Mode


class Load(NamedTuple):
    """
    The torques on the wheels while no wheel stops or starts, and no motor reaches its line.

    Attributes
    ----------
    held, fading : WheelTorque
        Torque on each wheel at time t: held + fading exp(-t/T) - damping × speed [N m].
    right_damping, left_damping : float
        [N m s/rad].
    right_stands, left_stands : bool
        Whether each wheel stands.
    """

    held: WheelTorque
    fading: WheelTorque
    right_damping: float
    left_damping: float
    right_stands: bool
    left_stands: bool


class WheelMotion(NamedTuple):
    """
    Both wheels at a time.

    Attributes
    ----------
    speed : WheelVelocity
        [rad/s].
    right_angle, left_angle : float
        Angles turned since the start [rad].
    """

    speed: WheelVelocity
    right_angle: float
    left_angle: float


NO_MODE = Mode(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""The mode of a standing wheel."""


@jitable_apart
def find_modes(speed: WheelVelocity, load: Load, linear: float, angular: float) -> Modes:
    """
    Decouple Eq. (13)-(14) of the chapter, with individual damping and torque at each wheel.

    Parameters
    ----------
    speed : WheelVelocity
        At the start [rad/s].
    load : Load
        Torques and damping.
    linear, angular : float
        A + B and A - B [kg m²].
    """
    own = 0.5 * (linear + angular)
    if load.right_stands and load.left_stands:
        return Modes(NO_MODE, NO_MODE)
    # beside a standing wheel: A dω/dt = τ - D ω
    if load.right_stands:
        return Modes(Mode(load.left_damping / own, 0.0, 1.0, speed.left, load.held.left / own, load.fading.left / own),
                     NO_MODE)
    if load.left_stands:
        return Modes(
            Mode(load.right_damping / own, 1.0, 0.0, speed.right, load.held.right / own, load.fading.right / own),
            NO_MODE)
    # sum and difference of the wheels, with a kinetic energy of x²/2 each
    along, around = math.sqrt(0.5 / linear), math.sqrt(0.5 / angular)
    first = Mode(
        0.5 * (load.right_damping + load.left_damping) / linear, along, along,
        along * linear * (speed.right + speed.left),
        along * (load.held.right + load.held.left),
        along * (load.fading.right + load.fading.left),
    )
    second = Mode(
        0.5 * (load.right_damping + load.left_damping) / angular, around, -around,
        around * angular * (speed.right - speed.left),
        around * (load.held.right - load.held.left),
        around * (load.fading.right - load.fading.left),
    )
    mixed = along * around * (load.right_damping - load.left_damping)
    return _rotated(first, second, mixed) if mixed != 0.0 else Modes(first, second)


@jitable_apart
def _rotated(first: Mode, second: Mode, mixed: float) -> Modes:
    """Decouple two motions that damp each other, by a Jacobi rotation of their symmetric damping matrix."""
    half = 0.5 * (second.rate - first.rate) / mixed
    tangent = (1.0 if half >= 0.0 else -1.0) / (abs(half) + math.sqrt(half * half + 1.0))
    cosine = 1.0 / math.sqrt(tangent * tangent + 1.0)
    sine = tangent * cosine
    return Modes(
        Mode(
            max(0.0, first.rate - tangent * mixed),
            cosine * first.right - sine * second.right,
            cosine * first.left - sine * second.left,
            cosine * first.start - sine * second.start,
            cosine * first.push - sine * second.push,
            cosine * first.fade - sine * second.fade,
        ),
        Mode(
            max(0.0, second.rate + tangent * mixed),
            sine * first.right + cosine * second.right,
            sine * first.left + cosine * second.left,
            sine * first.start + cosine * second.start,
            sine * first.push + cosine * second.push,
            sine * first.fade + cosine * second.fade,
        ),
    )


@jitable_apart
def mode_after(mode: Mode, lag_rate: float, time: float) -> tuple[float, float]:
    """Return x after a time [s], and its integral; the lag's rate 1/T [1/s] is 0 without a lag."""
    own = held_response(mode.rate, time)
    value = own.decay * mode.start + own.gain * mode.push
    covered = own.gain * mode.start + own.travel * mode.push
    if mode.fade == 0.0:
        return value, covered
    other = fading_response(mode.rate, lag_rate, time)
    return value + other.gain * mode.fade, covered + other.travel * mode.fade


@jitable_apart
def course(modes: Modes, lag_rate: float, time: float) -> WheelMotion:
    """Return both wheels after a time [s], to rounding errors; the lag's rate 1/T [1/s] is 0 without a lag."""
    first, second = modes
    a, turned_a = mode_after(first, lag_rate, time)
    b, turned_b = mode_after(second, lag_rate, time)
    return WheelMotion(
        WheelVelocity(first.right * a + second.right * b, first.left * a + second.left * b),
        first.right * turned_a + second.right * turned_b,
        first.left * turned_a + second.left * turned_b,
    )


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
    request : WheelTorque
        Of the motors, limited [N m].
    outside : WheelTorque
        Torques on the wheels that do not come through the motors [N m].
    heading : float
        At the period's start [rad].
    """

    request: WheelTorque
    outside: WheelTorque
    heading: float


@jitable_apart
def held_torque(wheel: Wheel, request: float, outside: float, axle: Axle) -> float:
    """Return the torque [N m] on a wheel that neither fades nor depends on its speed."""
    motor = wheel.line * axle.stall_torque if wheel.line != 0.0 else request
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
        WheelTorque(held_torque(right, forcing.request.right, forcing.outside.right, axle),
                    held_torque(left, forcing.request.left, forcing.outside.left, axle)),
        WheelTorque(right.fading if right.line == 0.0 else 0.0, left.fading if left.line == 0.0 else 0.0),
        _damping(right, axle),
        _damping(left, axle),
        rough and right.direction == 0.0,
        rough and left.direction == 0.0,
    )


@jitable_apart
def _later(wheel: Wheel, speed: float, angle: float, request: float, time: float, axle: Axle) -> Wheel:
    """Return a wheel and its motor after a time [s] and a turn by an angle [rad]."""
    if wheel.line != 0.0:
        lacking = (request - wheel.line * axle.stall_torque) * time + axle.slope * angle
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
    at_first = course(modes, axle.lag_rate, begin + first * length)
    at_middle = course(modes, axle.lag_rate, begin + middle * length)
    at_last = course(modes, axle.lag_rate, begin + last * length)
    x, y = mean_velocity(
        (_forward(at_first, axle), _forward(at_middle, axle), _forward(at_last, axle)),
        (_heading(rolling, at_first, forcing, axle), _heading(rolling, at_middle, forcing, axle),
         _heading(rolling, at_last, forcing, axle)),
    )
    return length * x, length * y


@jitable_apart
def _forward(now: WheelMotion, axle: Axle) -> float:
    """Return the forward velocity [m/s]: Eq. (5), (6)."""
    return 0.5 * axle.wheel_radius * (now.speed.right + now.speed.left)


@jitable_apart
def _heading(rolling: Rolling, now: WheelMotion, forcing: Forcing, axle: Axle) -> float:
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
        _later(rolling.right, after.speed.right, after.right_angle, forcing.request.right, time, axle),
        _later(rolling.left, after.speed.left, after.left_angle, forcing.request.left, time, axle),
    )
