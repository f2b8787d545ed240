"""Wheel encoders: angles in whole ticks, and velocities as differences of angles, as in firmware."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.events import periods
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import WheelVelocity

LONGEST_WINDOW = 64
"""In periods of the velocity loop."""


class Encoders(NamedTuple):
    """Encoders of the wheels; with both fields 0 they give the true angles and velocities."""

    ticks: Annotated[
        int, Field('', 'ticks in a revolution of the wheel, with gear and quadrature, 0 for none: larger makes angles '
                   'and velocities of the wheels finer', minimum=0, maximum=2**31 - 1)
    ] = 0
    window: Annotated[
        float, Field('s', 'time between the two angles of a velocity, rounded up to velocity periods; 0 for one '
                          'period, or without ticks for the true velocity: larger makes velocities finer and later',
                     minimum=0.0)
    ] = 0.0


class WheelAngles(NamedTuple):
    """Angles of the wheels [rad], not wrapped."""

    right: float
    left: float


class EncoderConstants(NamedTuple):
    """
    Encoders on a velocity grid.

    Attributes
    ----------
    tick : float
        Angle between two ticks [rad]; 0 without ticks.
    periods : int
        Velocity periods in the window, at least 1.
    window : float
        Length of the window [s].
    differences : bool
        Whether velocities are differences of angles; otherwise they are the true ones.
    """

    tick: float
    periods: int
    window: float
    differences: bool


def encoder_constants(encoders: Encoders, period: int) -> EncoderConstants:
    """Return the constants of encoders for a velocity grid with a period [ns]."""
    window = max(1, periods(encoders.window, period))
    return EncoderConstants(
        2.0 * math.pi / encoders.ticks if encoders.ticks else 0.0,
        window,
        window * period / 1e9,
        encoders.ticks > 0 or encoders.window > 0.0,
    )


@jitable
def _encoder_angle(angle: float, tick: float) -> float:
    """Return an angle [rad] in whole ticks, rounded: at a run's start wheels stand half-way between two edges."""
    return tick * math.floor(angle / tick + 0.5) if tick > 0.0 else angle


@jitable
def encoder_angles(right: float, left: float, encoders: EncoderConstants) -> WheelAngles:
    """Return the wheels' angles as encoders show them, at most half a tick from the true ones [rad]."""
    return WheelAngles(_encoder_angle(right, encoders.tick), _encoder_angle(left, encoders.tick))


@jitable
def angle_velocity(now: WheelAngles, before: WheelAngles, window: float) -> WheelVelocity:
    """Return the mean velocity between two angles of each wheel, a time [s] apart."""
    return WheelVelocity((now.right - before.right) / window, (now.left - before.left) / window)
