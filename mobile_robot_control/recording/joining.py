"""Join the topics of a run by stamp."""

import math
from collections.abc import Iterator

from mobile_robot_control.quantities import (
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    Truth,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.recording.gaps import period
from mobile_robot_control.recording.signals import COLUMNS, GROUND_TRUTH, TRUE_ERROR, Signal, is_lockstep, origin
from mobile_robot_control.simulation.closed_loop import PositionTick, Sample
from mobile_robot_control.topics import POSITION_TOPICS

_TICK = ('odom', 'reference', 'tracking_error')
"""What a position tick needs; other topics are held where there are any."""
_UNKNOWN = {topic: (math.nan,) * len(names) for topic, names in COLUMNS.items()}


class _Held:
    """Steps through a signal and holds its newest row."""

    def __init__(self, topic: str, signal: Signal) -> None:
        self._signal, self._width, self._n = signal, len(COLUMNS[topic]), 0
        self.present = bool(signal.stamps)
        self.stamp = -1
        self.row = _UNKNOWN[topic]

    def until(self, stamp: int) -> None:
        """Move on to the newest row that is not later than a stamp."""
        stamps, begin = self._signal.stamps, self._n
        while self._n < len(stamps) and stamps[self._n] <= stamp:
            self._n += 1
        if self._n > begin:
            self.stamp = stamps[self._n - 1]
            self.row = tuple(self._signal.values[(self._n - 1) * self._width:self._n * self._width])


def clock_topic(signals: dict[str, Signal]) -> str:
    """Return the topic whose stamps the samples have: the faster one of `joint_states` and `tracking_error`."""
    fast, slow = (period(signals[topic].stamps) for topic in ('joint_states', 'tracking_error'))
    comes = signals['joint_states'].stamps and (fast <= slow or len(signals['tracking_error'].stamps) < 2)
    return 'joint_states' if comes else 'tracking_error'


def joined(signals: dict[str, Signal]) -> Iterator[Sample]:
    """
    Join the topics by stamp into samples, one for each time of the fast loop.

    Parameters
    ----------
    signals : dict of str to Signal
        By topic; `with_errors` gives them the errors that no topic carries.

    Yields
    ------
    Sample
        In lockstep one for each stamp that both fast topics have, with the newest position tick that all slow topics
        have. On the wall clock, where every node has stamps of its own, one for each ``joint_states``, with the
        newest of all others, from the time on when all have come; see `origin` for how time is counted. Of a topic
        without messages the numbers are nan, but odometry, reference and error are needed; without ``joint_states``,
        or where they come less often than errors, there is a sample for each error.

    """
    start, lockstep, clock = origin(signals), is_lockstep(signals), clock_topic(signals)
    held = {topic: _Held(topic, signal) for topic, signal in signals.items()}
    slow = [held[topic] for topic in POSITION_TOPICS if topic in _TICK or held[topic].present]
    joints, torque = held['joint_states'], held['wheel_torques']
    tick: PositionTick | None = None
    seen = -1
    for stamp in signals[clock].stamps:
        for topic in held.values():
            topic.until(stamp)
        at = held['tracking_error'].stamp
        if at > seen and _is_complete([topic.stamp for topic in slow], lockstep):
            seen = at
            # on the wall clock a tick counts at the first sample after it
            tick = _tick((at if lockstep else stamp - start) / 1e9, held)
            command = BodyVelocity(*held['cmd_vel'].row)
            truth = _truth(held, at, lockstep)
        if tick is not None and (not torque.present or torque.stamp == stamp or (not lockstep and torque.stamp >= 0)):
            row = joints.row if clock == 'joint_states' else _UNKNOWN['joint_states']
            yield Sample((stamp - start) / 1e9, tick, command, row[0], row[1], WheelVelocity(*row[2:4]),
                         WheelTorque(*row[4:]), WheelTorque(*torque.row), truth)


def _is_complete(stamps: list[int], lockstep: bool) -> bool:
    """Return whether all topics have come, and in lockstep for the same tick."""
    return min(stamps) == max(stamps) >= 0 if lockstep else min(stamps) >= 0


def _tick(time: float, held: dict[str, _Held]) -> PositionTick:
    """Make a position tick of the newest rows."""
    odom, reference = held['odom'].row, held['reference'].row
    return PositionTick(time, Pose(*odom[:3]), BodyVelocity(*odom[3:]),
                        Reference(Pose(*reference[:3]), BodyVelocity(*reference[3:])),
                        TrackingError(*held['tracking_error'].row))


def _truth(held: dict[str, _Held], at: int, lockstep: bool) -> Truth | None:
    """Return the truth of a tick at a stamp, nan where it was not recorded; None where none is kept beside ticks."""
    error, motion = held[TRUE_ERROR], held[GROUND_TRUTH] if held[GROUND_TRUTH].present else held['odom']
    if not error.present:
        return None
    missing = lockstep and error.stamp != at
    row = _UNKNOWN[GROUND_TRUTH] if missing else motion.row
    return Truth(Pose(*row[:3]), BodyVelocity(*row[3:]),
                 TrackingError(*(_UNKNOWN[TRUE_ERROR] if missing else error.row)))
