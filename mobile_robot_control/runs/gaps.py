"""Missing parts of a recording: silent topics, late starts, gaps."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mobile_robot_control.recording.columns import GROUND_TRUTH
from mobile_robot_control.runs.series import Series, Stamps, period
from mobile_robot_control.topics import LOOP_TOPICS

MANY_PERIODS = 2.5
"""On the wall clock, a silence longer than this many periods is a gap."""
_LATE_PERIODS = 20.0
"""On the wall clock, a silence longer than this many periods is a fault."""


class Gap(NamedTuple):
    """
    A silence in a topic.

    Attributes
    ----------
    start, end : float
        Times of the messages before and after it [s].

    """

    start: float
    end: float


def find_gaps(stamps: Stamps, start: int = 0) -> list[Gap]:
    """
    Find the silences of a topic.

    Parameters
    ----------
    stamps : array of int, shape (n,)
        Ascending [ns].
    start : int
        The stamp at which time is 0 [ns].

    Returns
    -------
    list of Gap
        In order of time.
    """
    usual = period(stamps)
    # stamps of a lockstep run lie on a grid; those of a wall clock jitter
    longest = usual * (MANY_PERIODS if start else 1.5)
    before = np.flatnonzero(np.diff(stamps) > longest)
    return [Gap(*ends) for ends in ((stamps[[before, before + 1]] - start) / 1e9).T.tolist()]


def describe_gaps(series: Series) -> Iterator[str]:
    """Yield one sentence for each fault of a recording, by topic; none for a complete run."""
    start = series.origin
    present = [signal.stamps for signal in series.signals.values() if signal.stamps.size]
    if not present:
        yield 'no message of the control loop at all'
        return
    first, last = min(int(stamps[0]) for stamps in present), max(int(stamps[-1]) for stamps in present)
    if start:
        # on the wall clock other nodes outlast the plant, and the plant exists before the curve begins
        first = start
        if series.has('joint_states'):
            last = int(series.signals['joint_states'].stamps[-1])
    if not start and first > 0:
        yield f'the recording starts late, at t = {first / 1e9:g} s'
    silent = _silent(series)
    if silent:
        yield f'no messages on {", ".join(silent)}'
    for topic in (*LOOP_TOPICS, GROUND_TRUTH):
        stamps = series.signals[topic].stamps
        if len(stamps) == 1 and last > first:
            yield f'one message only on {topic}'
        elif len(stamps) > 1:
            yield from _faults(topic, stamps, first, last, start)


def _silent(series: Series) -> list[str]:
    """Return the silent topics of the loop; a base without efforts takes no `wheel_torques`."""
    # on the wall clock a robot from outside this package may have odometry alone, and its bag the topics its owner
    # chose
    if series.origin and not series.has('joint_states'):
        return []
    takes_none = series.has('joint_states') and not series.has_torques
    return [topic for topic in LOOP_TOPICS if not series.has(topic) and not (takes_none and topic == 'wheel_torques')]


def count_missing(series: Series) -> int:
    """
    Count the messages missing in the gaps that `describe_gaps` describes, over all topics.

    On the wall clock these are only the long gaps; each counts as its length in periods of its topic.
    """
    start = series.origin
    return sum(_missing(_faulty_gaps(series.signals[topic].stamps, start), period(series.signals[topic].stamps))
               for topic in (*LOOP_TOPICS, GROUND_TRUTH))


def _patience(usual: int, start: int) -> int:
    """Return the longest silence that is no fault [ns], from the usual distance of a topic's stamps [ns]."""
    return int(usual * (_LATE_PERIODS if start else 1.5))


def _faulty_gaps(stamps: Stamps, start: int) -> list[Gap]:
    """Return the gaps that are faults: on the wall clock, an occasional delay of a node is none of the recording."""
    patience = _patience(period(stamps), start)
    return [gap for gap in find_gaps(stamps, start) if (gap.end - gap.start) * 1e9 > patience]


def _missing(found: list[Gap], usual: int) -> int:
    """Return the number of messages missing in gaps of a topic with a usual distance of stamps [ns]."""
    return sum(max(1, round((gap.end - gap.start) * 1e9 / usual) - 1) for gap in found)


def _faults(topic: str, stamps: Stamps, first: int, last: int, start: int) -> Iterator[str]:
    usual = period(stamps)
    patience = _patience(usual, start)
    if stamps[0] - first > patience:
        yield f'{topic} starts late, at t = {(stamps[0] - start) / 1e9:g} s'
    if last - stamps[-1] > patience:
        yield f'{topic} ends early, at t = {(stamps[-1] - start) / 1e9:g} s'
    found = _faulty_gaps(stamps, start)
    if found:
        missing = _missing(found, usual)
        widest = max(found, key=lambda gap: gap.end - gap.start)
        yield (f'{missing} of {len(stamps) + missing} messages missing on {topic}, in {len(found)} gap'
               f'{"s" if len(found) > 1 else ""}; the longest from t = {widest.start:g} s to {widest.end:g} s')
