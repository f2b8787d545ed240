"""The first zero of what is watched while the wheels move along an exact course."""

import math
from typing import NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.modes import Mode, Modes, mode_after

_MOST_STEPS = 100
_FINEST = 1e-15


class Watch(NamedTuple):
    """
    A quantity whose first zero is looked for: level + fade exp(-t/T) + first x1 + second x2, in the modes x1 and x2.

    Attributes
    ----------
    level, fade, first, second : float
        Its coefficients.
    """

    level: float
    fade: float
    first: float
    second: float


NEVER = Watch(1.0, 0.0, 0.0, 0.0)
"""A quantity without a zero."""


@jitable
def _bend(mode: Mode, slope: float, fading: float, lag_rate: float) -> float:
    """Return a bound of the absolute second derivative of a mode from now on."""
    return mode.rate * abs(slope) + (mode.rate + lag_rate) * abs(mode.fade) * fading


@jitable
def first_zero(watch: Watch, modes: Modes, lag_rate: float, end: float) -> float:
    """
    Return when a quantity first falls to zero, or the end [s] where it does not before.

    A Newton method that never steps over a zero: each step ends where a parabola falls to zero that has the present
    value and slope, and the strongest curvature that the exponentials can still have. It converges quadratically from
    before the zero, to rounding errors.

    Parameters
    ----------
    watch : Watch
        The quantity; at the start it is positive, or zero and rising. Anything else is a zero at the start.
    modes : Modes
        The motion.
    lag_rate : float
        1/T [1/s], 0 without a lag.
    end : float
        How far to look [s].
    """
    first, second = modes
    time, fading = 0.0, 1.0
    a, b = first.start, second.start
    for _ in range(_MOST_STEPS):
        slope_a = first.push + first.fade * fading - first.rate * a
        slope_b = second.push + second.fade * fading - second.rate * b
        value = watch.level + watch.fade * fading + watch.first * a + watch.second * b
        slope = watch.first * slope_a + watch.second * slope_b - lag_rate * watch.fade * fading
        if value <= 0.0:
            if not slope > 0.0:
                return time
            value = 0.0
        bend = (abs(watch.first) * _bend(first, slope_a, fading, lag_rate)
                + abs(watch.second) * _bend(second, slope_b, fading, lag_rate)
                + lag_rate * lag_rate * abs(watch.fade) * fading)
        root = math.sqrt(slope * slope + 2.0 * bend * value)
        if slope < 0.0:
            ahead = 2.0 * value / (root - slope)
            if ahead <= _FINEST * end:
                return time
        elif bend > 0.0:
            ahead = max((slope + root) / bend, 2.0 * _FINEST * end)
        else:
            return end
        time += ahead
        if not time < end:
            return end
        a, _ = mode_after(first, lag_rate, time)
        b, _ = mode_after(second, lag_rate, time)
        if lag_rate > 0.0:
            fading = math.exp(-lag_rate * time)
    return time
