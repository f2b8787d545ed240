"""Gain and delay margins of a linear loop."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.analysis.linearisation import LinearLoop

LARGEST_GAIN = 20.0
"""Margins are searched up to this factor, and down to its inverse."""
MOST_PERIODS = 20
"""Delay margins are searched up to this number of periods of the loop."""

_MOST_TIME = 0.1
"""[s]: delay margins of the position loop are searched up to this at least."""
"""Of the lap."""
_GAIN_STEPS = 25
_RESOLUTION = 1e-3


def longest_delay(period: float) -> int:
    """Return the upper end of the search for the delay margin of a position loop with a period [s] [periods]."""
    return max(MOST_PERIODS, math.ceil(_MOST_TIME / period - 1e-9))


class Margins(NamedTuple):
    """
    The stability margins of a loop.

    Attributes
    ----------
    gain : float
        Least factor above 1 on the controller's output that destabilises the loop; infinite if none is known up to
        LARGEST_GAIN.
    lowest_gain : float
        Largest factor below 1 that destabilises it; 0 if none is known down to 1 / LARGEST_GAIN.
    delay : float
        Least additional delay of the output that destabilises it [periods]; infinite if none is known up to
        `longest_delay`.

    """

    gain: float
    lowest_gain: float
    delay: float


UNSTABLE = Margins(1.0, 1.0, 0.0)
"""Of a loop that is already unstable."""
UNKNOWN = Margins(math.nan, math.nan, math.nan)
"""Of a loop without a linearisation."""


def spectral_radius_of(loop: Sequence[LinearLoop], gain: float = 1.0, delay: float = 0.0) -> float:
    """
    Return the spectral radius of a closed loop, for one period.

    Parameters
    ----------
    loop : sequence of LinearLoop
        Consecutive periods, after which the loop repeats.
    gain : float
        Factor on the controller's output.
    delay : float
        Additional delay of the output [periods]. Between two velocity ticks the two inputs are averaged: their effect
        at the end of a period is exact to first order in the velocity period.

    """
    whole, parts = math.floor(delay), len(loop[0].inputs)
    late = (delay - whole) * parts
    n = len(loop[0].state)
    product = np.eye(n + 2 * (whole + 1))
    for one in loop:
        # the share of each part of the period in which the older of two inputs still acts
        older = np.clip(late - np.arange(parts), 0.0, 1.0)
        old, new = (np.tensordot(share, one.inputs, 1) for share in (older, 1.0 - older))
        closed = np.zeros_like(product)
        # the state is followed by the outputs of earlier periods, the newest first
        closed[:n, :n] = one.state
        closed[:n, n + 2 * whole:] += gain * old
        if whole:
            closed[:n, n + 2 * (whole - 1):n + 2 * whole] += gain * new
        else:
            closed[:n, :n] += gain * new @ one.asked
        closed[n:n + 2, :n] = one.asked
        closed[n + 2:, n:-2] = np.eye(2 * whole)
        product = closed @ product
    if not np.isfinite(product).all():
        return math.inf
    return float(max(abs(np.linalg.eigvals(product))) ** (1.0 / len(loop)))


def _first_unstable(radius: Callable[[float], float], grid: Sequence[float]) -> float:
    """Return the first unstable value of a loop that is stable at the start of a grid; infinite if there is none."""
    first = next((n for n, value in enumerate(grid) if radius(value) >= 1.0), 0)
    if not first:
        return math.inf
    stable, unstable = grid[first - 1], grid[first]
    while unstable - stable > _RESOLUTION * unstable:
        middle = 0.5 * (stable + unstable)
        stable, unstable = (stable, middle) if radius(middle) >= 1.0 else (middle, unstable)
    return stable


def _delays(longest: int) -> list[float]:
    """Return the delays to try, in smaller steps for short ones."""
    found = [0]
    while found[-1] < longest:
        found.append(min(longest, found[-1] + max(1, found[-1] // 8)))
    return [float(delay) for delay in found]


def margins_of(loop: Sequence[LinearLoop], longest: int = MOST_PERIODS) -> Margins:
    """Return the margins of a loop that repeats after some periods; delays are searched up to the longest [periods]."""
    if not all(np.isfinite(part).all() for one in loop for part in one):
        return UNKNOWN
    if spectral_radius_of(loop) >= 1.0:
        return UNSTABLE
    gains = np.geomspace(1.0, LARGEST_GAIN, _GAIN_STEPS).tolist()
    return Margins(
        _first_unstable(lambda gain: spectral_radius_of(loop, gain), gains),
        1.0 / _first_unstable(lambda lower: spectral_radius_of(loop, 1.0 / lower), gains),
        _first_unstable(lambda delay: spectral_radius_of(loop, 1.0, delay), _delays(longest)),
    )
