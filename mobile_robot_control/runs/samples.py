"""The conversion of samples, simulated or from a table, to a run, and back."""

from array import array
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from mobile_robot_control.quantities import (
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    Truth,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.recording.columns import COLUMNS, GROUND_TRUTH, TRUE_ERROR
from mobile_robot_control.runs.joining import join
from mobile_robot_control.runs.messages import last_run
from mobile_robot_control.runs.series import Series, Signal, empty_signal
from mobile_robot_control.simulation.closed_loop import PositionTick, Sample
from mobile_robot_control.topics import LOOP_TOPICS

_TRUTH = (GROUND_TRUTH, TRUE_ERROR)
_AT_STEPS = ('joint_states', 'wheel_torques')
_BLOCK = 4096
"""Rows converted to samples at a time: lists of numbers are larger than arrays."""


class SampleReader:
    """Stores the numbers of samples as they pass; either all of them have a truth, or none."""

    def __init__(self) -> None:
        self._numbers = array('d')
        self._topics = tuple(LOOP_TOPICS)

    def taking(self, samples: Iterable[Sample]) -> Iterator[Sample]:
        """Yield samples, and store their numbers."""
        for sample in samples:
            tick, truth = sample.tick, sample.truth
            self._numbers.extend((
                sample.time, tick.time, sample.right_angle, sample.left_angle, *sample.wheels, *sample.applied,
                *sample.torque, *tick.pose, *tick.velocity, *tick.reference.pose, *tick.reference.velocity,
                *sample.command, *tick.error))
            if truth is not None:
                self._topics = (*LOOP_TOPICS, *_TRUTH)
                self._numbers.extend((*truth.pose, *truth.velocity, *truth.error))
            yield sample

    def series(self) -> Series:
        """Return the topics of the run."""
        widths = [len(COLUMNS[topic]) for topic in self._topics]
        ends = np.cumsum([2, *widths])
        rows = np.frombuffer(self._numbers).reshape(-1, ends[-1])
        steps, ticks = np.rint(rows[:, :2].T * 1e9).astype(np.int64)
        passed = {topic: empty_signal(topic) for topic in COLUMNS}
        for topic, begin, end in zip(self._topics, ends, ends[1:], strict=False):
            stamps, values = steps if topic in _AT_STEPS else ticks, rows[:, begin:end]
            kept = np.diff(stamps, prepend=-1) != 0
            if topic == 'wheel_torques':
                kept &= ~np.isnan(values[:, 0])
            passed[topic] = Signal(stamps[kept], empty_signal(topic).received, values[kept])
        return Series(last_run(passed).signals)


def collect(samples: Iterable[Sample]) -> Series:
    """Return the topics of a run from its samples, in order of time."""
    reader = SampleReader()
    for _ in reader.taking(samples):
        pass
    return reader.series()


def samples_of(series: Series) -> Iterator[Sample]:
    """
    Yield a run sample by sample.

    Parameters
    ----------
    series : Series
        With the errors that no topic carries, see `with_errors`.

    Yields
    ------
    Sample
        One for each row of its time base; a topic without messages gives nan.

    """
    joined, at = join(series), -1
    tick: Any = None
    for begin in range(0, joined.time.size, _BLOCK):
        rows = joined.rows(begin, begin + _BLOCK)
        columns = [rows.time, rows.number, *map(rows.values, LOOP_TOPICS), *rows.truth()]
        for (time, number, joints, torque, odom, reference, command, error, motion, true_error) in zip(
                *(column.tolist() for column in columns), strict=True):
            if number != at:
                at = number
                tick = PositionTick(float(joined.tick[number]), Pose(*odom[:3]), BodyVelocity(*odom[3:]),
                                    Reference(Pose(*reference[:3]), BodyVelocity(*reference[3:])),
                                    TrackingError(*error))
                commanded = BodyVelocity(*command)
                truth = Truth(Pose(*motion[:3]), BodyVelocity(*motion[3:]),
                              TrackingError(*true_error)) if series.hides_truth else None
            yield Sample(time, tick, commanded, joints[0], joints[1], WheelVelocity(*joints[2:4]),
                         WheelTorque(*joints[4:]), WheelTorque(*torque), truth)
