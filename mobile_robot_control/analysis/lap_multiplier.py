"""
The multiplier of a lap: the share of a small error that remains after a lap of a periodic loop.

It decides whether the loop is stable (Floquet). The single points of the lap do not: errors may grow on one stretch of
the curve and shrink on the rest.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from mobile_robot_control.analysis.lap import FollowedTick, LapLoop, NotFollowedError
from mobile_robot_control.analysis.linearisation import (
    Array,
    Flags,
    Opened,
    is_smooth,
    numbers_of,
    reached,
    slopes_of,
    with_numbers,
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

    def rolled(state: Any, first: int, last: int) -> Any:
        for tick in ticks[first:last]:
            state = lap.position_tick(state, tick.references, tick.k, tick.time, lap.loop)[0]
            for j in range(lap.ratio):
                state = lap.velocity_tick(state, tick.k + j, lap.loop)[0]
        return state

    def numbers(state: Any, n: int) -> Array:
        return np.array(numbers_of(state, poses[n]))

    def stretch(state: Any, first: int, last: int, chosen: Flags) -> Opened:
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
