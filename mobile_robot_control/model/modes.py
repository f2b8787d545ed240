"""Two wheels on one axle as two independent first-order motions, solved exactly."""

import math
from typing import NamedTuple

from mobile_robot_control.jit import jitable_apart
from mobile_robot_control.model.responses import fading_response, held_response
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


class Course(NamedTuple):
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
def course(modes: Modes, lag_rate: float, time: float) -> Course:
    """Return both wheels after a time [s], to rounding errors; the lag's rate 1/T [1/s] is 0 without a lag."""
    first, second = modes
    a, turned_a = mode_after(first, lag_rate, time)
    b, turned_b = mode_after(second, lag_rate, time)
    return Course(
        WheelVelocity(first.right * a + second.right * b, first.left * a + second.left * b),
        first.right * turned_a + second.right * turned_b,
        first.left * turned_a + second.left * turned_b,
    )
