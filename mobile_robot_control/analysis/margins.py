"""
Gain and delay margins of a linear loop, and of both loops along a lap; the multiplier of a lap.

The multiplier is the share of a small error that remains after a lap of a periodic loop. It decides whether the loop
is stable (Floquet). The single points of the lap do not: errors may grow on one stretch of the curve and shrink on the
rest.
"""

import math
from collections.abc import Callable, Sequence
from itertools import islice, pairwise
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.analysis.linearisation import (
    Array,
    Flags,
    FollowedTick,
    LapLoop,
    LinearLoop,
    NotFollowedError,
    Opened,
    followed_lap,
    is_smooth,
    lap_loop,
    linear_position_loop,
    linear_velocity_loop,
    numbers_of,
    reached,
    slopes_of,
    with_numbers,
)
from mobile_robot_control.analysis.modelled import drive_of, pattern_of, smooth_part
from mobile_robot_control.settings.nodes import Configuration, course_of

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
    for linear in loop:
        # the share of each part of the period in which the older of two inputs still acts
        older = np.clip(late - np.arange(parts), 0.0, 1.0)
        old, new = (np.tensordot(share, linear.inputs, 1) for share in (older, 1.0 - older))
        closed = np.zeros_like(product)
        # the state is followed by the outputs of earlier periods, the newest first
        closed[:n, :n] = linear.state
        closed[:n, n + 2 * whole:] += gain * old
        if whole:
            closed[:n, n + 2 * (whole - 1):n + 2 * whole] += gain * new
        else:
            closed[:n, :n] += gain * new @ linear.output
        closed[n:n + 2, :n] = linear.output
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
    delays = [0]
    while delays[-1] < longest:
        delays.append(min(longest, delays[-1] + max(1, delays[-1] // 8)))
    return [float(delay) for delay in delays]


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


_STRETCHES = 24
"""Stretches of a lap, linearised one after the other: an error that grows on one of them stays small."""
_MOST_ROUNDS = 6
_CLOSED = 1e-6
"""[m], [rad], [m/s]: closer laps count as the same."""
_MOST_STEPS = 2_000_000
"""Steps of the velocity loop in a round, some ten seconds."""


def lap_multiplier(lap: LapLoop, ticks: Sequence[FollowedTick], pattern: int) -> float:
    """
    Return the factor by which an error changes over a lap; from 1 on the loop is unstable.

    Parameters
    ----------
    lap : LapLoop
        Of a configuration without non-smooth parts.
    ticks : sequence of FollowedTick
        Of one lap, a whole number of patterns.
    pattern : int
        Position periods after which the events of the base repeat.

    Returns
    -------
    float
        The largest modulus of the eigenvalues of the lap's transition matrix (monodromy); nan if the motion is not
        periodic, has no derivative, or takes too long to compute.

    Notes
    -----
    After the settling the lap is not yet periodic to the last bit, and its matrix is not that of the periodic lap.
    Newton's method finds the state that a lap reproduces, with the same matrix.

    """
    try:
        return _multiplier(lap, ticks, pattern)
    except (NotFollowedError, ArithmeticError, ValueError):  # from a state that a round has led too far away
        return math.nan


def _multiplier(lap: LapLoop, ticks: Sequence[FollowedTick], pattern: int) -> float:
    poses = [tick.reference.pose for tick in ticks] + [ticks[-1].next_reference.pose]

    def rolled(state: object, first: int, last: int) -> Any:
        for tick in ticks[first:last]:
            state = lap.position_tick(state, tick.references, tick.k, tick.time, lap.loop)[0]
            for j in range(lap.ratio):
                state = lap.velocity_tick(state, tick.k + j, lap.loop)[0]
        return state

    def numbers(state: object, n: int) -> Array:
        return np.array(numbers_of(state, poses[n]))

    def stretch(state: object, first: int, last: int, chosen: Flags) -> Opened:
        """Return the chosen numbers at the end of a stretch as a function of those at its start."""
        whole = numbers(state, first)

        def end(some: Array) -> Array:
            at = whole.copy()
            at[chosen] = some
            return numbers(rolled(with_numbers(state, iter(at.tolist()), poses[first]), first, last), last)[chosen]

        return Opened(end, whole[chosen], len(whole[chosen]))

    start = ticks[0].state
    everything = np.ones(len(numbers(start, 0)), dtype=bool)
    opened = stretch(start, 0, pattern, everything)
    links = slopes_of(opened.period, opened.at) != 0.0
    pose = np.arange(len(links)) < 3
    # numbers that the pose does not reach or depend on, such as the wheels' angles, keep their error for ever
    kept = reached(links, pose) & reached(links.T, pose)
    if 2 * kept.sum() * len(ticks) * lap.ratio > _MOST_STEPS:
        return math.nan
    ends = [n * len(ticks) // _STRETCHES for n in range(_STRETCHES + 1)]
    for _ in range(_MOST_ROUNDS):
        product, state = np.eye(kept.sum()), start
        for first, last in pairwise(ends):
            opened = stretch(state, first, last, kept)
            slopes = slopes_of(opened.period, opened.at)
            if not is_smooth(opened, slopes, np.ones(opened.states, dtype=bool)):
                return math.nan
            product, state = slopes @ product, rolled(state, first, last)
        apart = numbers(state, len(ticks))[kept] - numbers(start, 0)[kept]
        if not np.isfinite(product).all():
            return math.nan
        if abs(apart).max() < _CLOSED:
            return float(max(abs(np.linalg.eigvals(product))))
        at = numbers(start, 0)
        at[kept] += np.linalg.solve(np.eye(len(apart)) - product, apart)
        start = with_numbers(start, iter(at.tolist()), poses[0])
    return math.nan


_POINTS = 24
"""Points of the lap at which the position loop is analysed; fewer if a pattern of several periods costs more."""
_LEAST_POINTS = 12
CERTAIN = 1.25
"""Gain margin, 2 dB: with it at every point of a lap, the whole lap is stable without further analysis."""
_VELOCITY_EVERY = 6
"""The velocity loop hardly changes along the curve: every sixth point is enough."""


class LapMargins(NamedTuple):
    """
    The worst margins along the curve.

    Attributes
    ----------
    margins : Margins
        The smallest ones, and the largest `lowest_gain`.
    gain_time, delay_time : float
        Time of the smallest gain and delay margin, after the beginning of the lap [s].

    """

    margins: Margins
    gain_time: float
    delay_time: float


class LoopMargins(NamedTuple):
    """
    The margins of both loops of a configuration.

    Attributes
    ----------
    velocity : LapMargins or None
        Delays in velocity periods; None for a base with its own velocity loop.
    position : LapMargins
        Delays in position periods.
    reason : str
        Why margins are unknown; '' if they are known.
    multiplier : float
        Factor by which an error of the position loop changes over a lap; nan if it is unknown, or certainly below 1,
        because every point of the lap has a gain margin of at least `CERTAIN`.

    """

    velocity: LapMargins | None
    position: LapMargins
    reason: str = ''
    multiplier: float = math.nan


def _worst(margins_by_time: Sequence[tuple[float, Margins]]) -> LapMargins:
    """Return the worst of margins by time; unknown if one of them is."""
    if any(math.isnan(margins.gain) for _, margins in margins_by_time):
        return LapMargins(UNKNOWN, math.nan, math.nan)
    gain_time, gain = min(((time, margins.gain) for time, margins in margins_by_time), key=lambda pair: pair[1])
    delay_time, delay = min(((time, margins.delay) for time, margins in margins_by_time), key=lambda pair: pair[1])
    lowest = max(margins.lowest_gain for _, margins in margins_by_time)
    return LapMargins(Margins(gain, lowest, delay), gain_time, delay_time)


def loop_margins(configuration: Configuration) -> LoopMargins:
    """
    Compute the margins of both loops along a lap.

    Parameters
    ----------
    configuration : Configuration
        Checked. Noise, limits, quantisation, dead zones and stiction are left out (`smooth_part`).

    Returns
    -------
    LoopMargins
        With a reason if the loop does not follow the reference, or has no linearisation.

    Notes
    -----
    The loop varies along the curve. Each point is analysed as if the robot continued its motion there for ever, in
    coordinates that move with the reference. This covers changes that are slow compared with the settling of the loop.
    A stretch of instability too short to matter counts fully in the margins; the multiplier of the lap decides whether
    the loop is stable.

    """
    smooth, by_torque = smooth_part(configuration), drive_of(configuration) == 'torque'
    lap, period, pattern = lap_loop(smooth), course_of(smooth.reference_cart).period, pattern_of(smooth)
    nothing = LapMargins(UNKNOWN, math.nan, math.nan)
    if not pattern:
        return LoopMargins(nothing if by_torque else None, nothing, 'the rates of the base have no common pattern')
    ticks = math.ceil(period / lap.loop.position_dt)
    points = max(_LEAST_POINTS, _POINTS // pattern)
    chosen = sorted({n * ticks // points for n in range(points)})
    velocity: list[tuple[float, Margins]] = []
    position: list[tuple[float, Margins]] = []
    followed: list[FollowedTick] = []
    try:
        followed += islice(followed_lap(smooth), -(-ticks // pattern) * pattern + pattern)
        for first in chosen:
            window = followed[first:first + pattern]
            time = window[0].time % period
            if by_torque and len(position) % _VELOCITY_EVERY == 0:
                velocity.append((time, margins_of(linear_velocity_loop(lap, window[0]))))
            position.append((time, margins_of(linear_position_loop(lap, window), longest_delay(lap.loop.position_dt))))
    except NotFollowedError as error:
        return LoopMargins(nothing if by_torque else None, nothing, str(error))
    margins = LoopMargins(_worst(velocity) if by_torque else None, _worst(position))
    if margins.position.margins.gain < CERTAIN:
        margins = margins._replace(multiplier=lap_multiplier(lap, followed[:-(-ticks // pattern) * pattern], pattern))
    is_known = all(not math.isnan(loop.margins.gain) for loop in margins[:2] if loop is not None)
    return margins if is_known else margins._replace(reason='the loop has no derivative at a point of the lap')
