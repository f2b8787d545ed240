"""
The first zero of a quantity while the wheels move along an exact course.

It runs in every step of a plant with non-ideal motors or friction, once for each possible next event: a wheel stops or
breaks away, or a motor meets its torque-speed line.
"""

import math
from typing import NamedTuple

from mobile_robot_control.jit import jitable_apart
from mobile_robot_control.model.modes import Mode, Modes, mode_after

_MOST_STEPS = 100
_FINEST = 1e-15


class Watch(NamedTuple):
    """
    A quantity and its coefficients: level + fade exp(-t/T) + first x1 + second x2, in the modes x1 and x2.

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


class _Bend(NamedTuple):
    """The second derivative of a mode, and bounds of its second and third derivative from now on."""

    curvature: float
    second: float
    third: float


@jitable_apart
def _bend(mode: Mode, slope: float, fading: float, lag_rate: float) -> _Bend:
    """Return the curvature of a mode and its bounds, from its slope and exp(-t/T)."""
    rate, fade = mode.rate, mode.fade * fading
    curvature = -rate * slope - lag_rate * fade
    fade, lagging = abs(fade), lag_rate * abs(fade)
    second = rate * (abs(slope) + fade) + lagging
    third = rate * (abs(curvature) + lagging) + lag_rate * lagging
    apart = rate - lag_rate
    if fade == 0.0 or apart == 0.0:
        return _Bend(curvature, second, third)
    # each exponential by itself: a far smaller bound once one has decayed, but not for similar rates
    follows = lag_rate * mode.fade * fading / apart
    own, follows = abs(slope + follows), abs(follows)
    return _Bend(curvature, min(second, rate * own + lag_rate * follows),
                 min(third, rate * rate * own + lag_rate * lag_rate * follows))


@jitable_apart
def _safe_step(value: float, slope: float, curvature: float, second: float, third: float) -> float:
    """Return a time [s] within which a quantity cannot fall to zero, given bounds of its derivatives; 0 at a zero."""
    if second <= 0.0:
        return value / -slope if slope < 0.0 else math.inf
    root = math.sqrt(slope * slope + 2.0 * second * value)
    step = 2.0 * value / (root - slope) if slope < 0.0 else (slope + root) / second
    if curvature <= 0.0:
        return step
    if third <= 0.0:
        return step if slope < 0.0 else math.inf
    if slope >= 0.0:
        # it rises at least until its curvature can vanish, and falls back after three times that at the earliest
        return max(step, 3.0 * curvature / third)
    if slope * slope < value * curvature:
        # a parabola of half its curvature stays above zero
        return max(step, 1.5 * curvature / third)
    return step


@jitable_apart
def first_zero(watch: Watch, modes: Modes, lag_rate: float, end: float) -> float:
    """
    Return the time [s] at which a quantity first falls to zero, or the end of the search if it does not.

    A Newton method that never steps over a zero: it uses the value, the slope, the curvature, and the largest second
    and third derivative that the exponentials can still have. It converges quadratically from before the zero, to
    rounding errors.

    Parameters
    ----------
    watch : Watch
        The quantity; at the start it is positive, or zero and rising. Otherwise the start counts as its zero.
    modes : Modes
        The motion.
    lag_rate : float
        1/T [1/s], 0 without a lag.
    end : float
        End of the search [s].
    """
    first, second = modes
    time, fading = 0.0, 1.0
    a, b = first.start, second.start
    for _ in range(_MOST_STEPS):
        slope_a = first.push + first.fade * fading - first.rate * a
        slope_b = second.push + second.fade * fading - second.rate * b
        fade = watch.fade * fading
        value = watch.level + fade + watch.first * a + watch.second * b
        slope = watch.first * slope_a + watch.second * slope_b - lag_rate * fade
        if value <= 0.0:
            if not slope > 0.0:
                return time
            value = 0.0
        bend_a = _bend(first, slope_a, fading, lag_rate)
        bend_b = _bend(second, slope_b, fading, lag_rate)
        bent = lag_rate * lag_rate * fade
        ahead = _safe_step(
            value,
            slope,
            watch.first * bend_a.curvature + watch.second * bend_b.curvature + bent,
            abs(watch.first) * bend_a.second + abs(watch.second) * bend_b.second + abs(bent),
            abs(watch.first) * bend_a.third + abs(watch.second) * bend_b.third + lag_rate * abs(bent),
        )
        if slope < 0.0 and ahead <= _FINEST * end:
            return time
        time += max(ahead, 2.0 * _FINEST * end)
        if not time < end:
            return end
        a, _ = mode_after(first, lag_rate, time)
        b, _ = mode_after(second, lag_rate, time)
        if lag_rate > 0.0:
            fading = math.exp(-lag_rate * time)
    return time
