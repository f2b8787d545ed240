"""The loop's topics of a run as plain arrays by stamp, whatever the run was read from."""

import math
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Callable
from typing import Any, NamedTuple

from mobile_robot_control.messages.parsing import (
    read_error,
    read_odometry,
    read_torque,
    read_twist,
    read_wheel_angles,
    read_wheel_velocity,
)
from mobile_robot_control.topics import LOOP_TOPICS, POSITION_TOPICS

GROUND_TRUTH, TRUE_ERROR = 'ground_truth', 'true_error'
COLUMNS = {
    **{name: topic.columns for name, topic in LOOP_TOPICS.items()},
    GROUND_TRUTH: LOOP_TOPICS['odom'].columns, TRUE_ERROR: LOOP_TOPICS['tracking_error'].columns,
}
"""
The columns of each signal of a run: the topics of the loop; the true motion, where it is recorded beside odometry that
hides it; and the true error, where that of `tracking_error` differs from it, which no topic carries.
"""
_UNKNOWN = (math.nan, math.nan)
_WALL = 10**15
"""[ns]: eleven days; later stamps are those of a wall clock, not of a run."""


def _odometry(message: Any) -> tuple[float, ...]:
    pose, velocity = read_odometry(message)
    return (*pose, *velocity)


def _joints(message: Any) -> tuple[float, ...]:
    """Return the columns of joint states; of a base that tells no efforts, they are nan."""
    efforts = read_torque(message) if len(message.effort) else _UNKNOWN
    return (*read_wheel_angles(message), *read_wheel_velocity(message), *efforts)


READ: dict[str, Callable[[Any], tuple[float, ...]]] = {
    'joint_states': _joints, 'wheel_torques': read_torque, 'odom': _odometry, 'reference': _odometry,
    'cmd_vel': read_twist, 'tracking_error': read_error,
}
"""Reads a message of each loop topic into its COLUMNS."""


class Signal(NamedTuple):
    """
    One topic of a run, repeats removed.

    Attributes
    ----------
    stamps : array of int
        Ascending [ns].
    received : array of int
        Wall time of the first receipt [ns]; empty where the run was not recorded over DDS.
    values : array of float
        Row by row, for each stamp as many as the topic has columns.
    """

    stamps: 'array[int]'
    received: 'array[int]'
    values: 'array[float]'


def empty_signal() -> Signal:
    """Return a signal without messages."""
    return Signal(array('q'), array('q'), array('d'))


def has_torques(signals: dict[str, Signal]) -> bool:
    """Return whether a run tells which torques were applied: the efforts of its `joint_states`."""
    efforts = signals['joint_states'].values[len(COLUMNS['joint_states']) - 2::len(COLUMNS['joint_states'])]
    return not all(map(math.isnan, efforts))


def is_lockstep(signals: dict[str, Signal]) -> bool:
    """Return whether the stamps are those of simulated time, which all nodes share, and not of clocks of their own."""
    odom, reference = (set(signals[topic].stamps) for topic in ('odom', 'reference'))
    if max(_begun(signals), default=0) > _WALL:
        return False
    return not odom or not reference or 2 * len(odom & reference) > max(len(odom), len(reference))


def _begun(signals: dict[str, Signal]) -> list[int]:
    """Return the stamp at which a run begins: the first one of the reference, or of all topics where there is none."""
    first = {topic: signal.stamps[0] for topic, signal in signals.items() if signal.stamps}
    return [first.get('reference', min(first.values()))] if first else []


def begun_when_recorded(signals: dict[str, Signal]) -> dict[str, Signal]:
    """
    Return the signals of a run of which only a part was recorded, with time from the beginning of that part.

    It begins at the first stamp that all topics of the slow loop share, and ends at the last one where no other topic
    lasts three periods longer; a run on the wall clock begins with its first reference anyway.
    """
    slow = [signals[topic].stamps for topic in POSITION_TOPICS if signals[topic].stamps]
    if not slow or not is_lockstep(signals):
        return signals
    first, last = max(stamps[0] for stamps in slow), min(stamps[-1] for stamps in slow)
    longest = max(signal.stamps[-1] for signal in signals.values() if signal.stamps)
    if len(slow[0]) > 1 and longest - last > 3 * (slow[0][1] - slow[0][0]):
        last = longest
    return {topic: _part(signal, first, last, len(COLUMNS[topic])) for topic, signal in signals.items()}


def _part(signal: Signal, first: int, last: int, width: int) -> Signal:
    """Return what a signal has from one stamp to another, with stamps from 0 on."""
    begin, end = bisect_left(signal.stamps, first), bisect_right(signal.stamps, last)
    return Signal(array('q', (stamp - first for stamp in signal.stamps[begin:end])), signal.received[begin:end],
                  signal.values[begin * width:end * width])


def origin(signals: dict[str, Signal]) -> int:
    """
    Return the stamp [ns] that a run's time is counted from.

    It is 0 in lockstep; elsewhere it is the first stamp of ``reference``, when the curve begins.
    """
    return 0 if is_lockstep(signals) else max(_begun(signals), default=0)
