"""What is missing from a recording: silent topics, late starts, gaps."""

import itertools
from array import array
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from mobile_robot_control.recording.signals import GROUND_TRUTH, Signal, has_torques, origin
from mobile_robot_control.topics import LOOP_TOPICS

MANY_PERIODS = 2.5
"""On the wall clock, a silence longer than this many periods is a gap."""
_LATE_PERIODS = 20.0
"""On the wall clock, one longer than this many is a fault."""


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


def period(stamps: 'array[int]') -> int:
    """
    Return the usual distance between ascending stamps [ns]; 0 for fewer than two.

    It is the commonest distance where the stamps lie on a grid, and their median elsewhere.
    """
    distances = [after - before for before, after in itertools.pairwise(stamps)]
    if not distances:
        return 0
    common, times = Counter(distances).most_common(1)[0]
    return common if times > len(distances) // 2 else sorted(distances)[len(distances) // 2]


def find_gaps(stamps: 'array[int]', start: int = 0) -> list[Gap]:
    """
    Find the silences of a topic.

    Parameters
    ----------
    stamps : array of int
        Ascending [ns].
    start : int
        The stamp that time is counted from [ns].

    Returns
    -------
    list of Gap
        In order of time.
    """
    usual = period(stamps)
    # stamps of a lockstep run lie on a grid; those of a wall clock jitter
    longest = usual * (MANY_PERIODS if start else 1.5)
    return [Gap((before - start) / 1e9, (after - start) / 1e9)
            for before, after in itertools.pairwise(stamps) if after - before > longest]


def describe_gaps(signals: dict[str, Signal]) -> Iterator[str]:
    """Yield one sentence for each fault of a recording, by topic; none for a complete run."""
    start = origin(signals)
    present = [signal.stamps for signal in signals.values() if signal.stamps]
    if not present:
        yield 'no message of the control loop at all'
        return
    first, last = min(stamps[0] for stamps in present), max(stamps[-1] for stamps in present)
    if start:
        # nodes on the wall clock live on when the plant has ended, and the plant is there before the curve begins
        first, last = start, (signals['joint_states'].stamps or [last])[-1]
    if not start and first > 0:
        yield f'the recording starts late, at t = {first / 1e9:g} s'
    silent = _silent(signals)
    if silent:
        yield f'no messages on {", ".join(silent)}'
    for topic in (*LOOP_TOPICS, GROUND_TRUTH):
        stamps = signals[topic].stamps
        if len(stamps) == 1 and last > first:
            yield f'one message only on {topic}'
        elif len(stamps) > 1:
            yield from _faults(topic, stamps, first, last, start)


def _silent(signals: dict[str, Signal]) -> list[str]:
    """
    Return the topics of the loop that carried nothing; a base that tells no efforts takes no `wheel_torques`.

    On the wall clock a robot that is not of this package may have odometry alone, and its bag what its owner recorded.
    """
    if origin(signals) and not signals['joint_states'].stamps:
        return []
    takes_none = signals['joint_states'].stamps and not has_torques(signals)
    return [topic for topic in LOOP_TOPICS
            if not signals[topic].stamps and not (takes_none and topic == 'wheel_torques')]


def count_missing(signals: dict[str, Signal]) -> int:
    """
    Count the messages that are missing in the gaps of all topics that `describe_gaps` describes.

    On the wall clock these are the long ones alone, of which each counts as many periods of its topic as it is long.
    """
    start = origin(signals)
    return sum(_missing(_faulty_gaps(signals[topic].stamps, start), period(signals[topic].stamps))
               for topic in (*LOOP_TOPICS, GROUND_TRUTH))


def _patience(usual: int, start: int) -> int:
    """Return how long a silence may be before it is a fault [ns], from the usual distance of a topic's stamps [ns]."""
    return int(usual * (_LATE_PERIODS if start else 1.5))


def _faulty_gaps(stamps: 'array[int]', start: int) -> list[Gap]:
    """Return the gaps that are faults: on the wall clock a node that is late now and then is none of the recording."""
    patience = _patience(period(stamps), start)
    return [gap for gap in find_gaps(stamps, start) if (gap.end - gap.start) * 1e9 > patience]


def _missing(found: list[Gap], usual: int) -> int:
    """Return how many messages are missing in gaps of a topic with a usual distance of stamps [ns]."""
    return sum(max(1, round((gap.end - gap.start) * 1e9 / usual) - 1) for gap in found)


def _faults(topic: str, stamps: 'array[int]', first: int, last: int, start: int) -> Iterator[str]:
    """Yield the faults of one topic."""
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
