"""Join the topics of a run by stamp."""

from collections.abc import Iterator

from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError, WheelTorque, WheelVelocity
from mobile_robot_control.recording.signals import Signal, origin
from mobile_robot_control.simulation.closed_loop import PositionTick, Sample
from mobile_robot_control.topics import LOOP_TOPICS, POSITION_TOPICS


def _rows(signal: Signal, width: int) -> Iterator[tuple[int, tuple[float, ...]]]:
    """Yield stamp and row of each message."""
    for n, stamp in enumerate(signal.stamps):
        yield stamp, tuple(signal.values[n * width:(n + 1) * width])


class _Held:
    """Steps through a signal and holds its newest row."""

    def __init__(self, topic: str, signal: Signal) -> None:
        self._rows = _rows(signal, len(LOOP_TOPICS[topic].columns))
        self._next = next(self._rows, None)
        self.stamp = -1
        self.row: tuple[float, ...] = ()

    def until(self, stamp: int) -> None:
        """Move on to the newest row that is not later than a stamp."""
        while self._next is not None and self._next[0] <= stamp:
            self.stamp, self.row = self._next
            self._next = next(self._rows, None)


def joined(signals: dict[str, Signal]) -> Iterator[Sample]:
    """
    Join the topics by stamp into samples, one for each time of the fast loop.

    Parameters
    ----------
    signals : dict of str to Signal
        By topic.

    Yields
    ------
    Sample
        In lockstep one for each stamp that both fast topics have, with the newest position tick that all slow topics
        have. On the wall clock, where every node has stamps of its own, one for each ``joint_states``, with the
        newest of all others, from the time on when all have come; see `origin` for how time is counted.

    """
    start = origin(signals)
    held = {topic: _Held(topic, signals[topic]) for topic in signals if topic != 'joint_states'}
    slow, torque = [held[topic] for topic in POSITION_TOPICS], held['wheel_torques']
    tick: PositionTick | None = None
    seen = -1
    for stamp, row in _rows(signals['joint_states'], len(LOOP_TOPICS['joint_states'].columns)):
        for topic in held.values():
            topic.until(stamp)
        at = held['tracking_error'].stamp
        if at > seen and _is_complete([topic.stamp for topic in slow], start):
            seen = at
            # on the wall clock a tick counts at the first sample after it
            tick = _tick((stamp - start if start else at) / 1e9, held)
            command = BodyVelocity(*held['cmd_vel'].row)
        if tick is not None and (torque.stamp == stamp or (start and torque.stamp >= 0)):
            yield Sample((stamp - start) / 1e9, tick, command, row[0], row[1], WheelVelocity(*row[2:4]),
                         WheelTorque(*row[4:]), WheelTorque(*torque.row))


def _is_complete(stamps: list[int], start: int) -> bool:
    """Return whether all topics have come, and in lockstep for the same tick."""
    return min(stamps) >= 0 if start else min(stamps) == max(stamps)


def _tick(time: float, held: dict[str, _Held]) -> PositionTick:
    """Make a position tick of the newest rows."""
    odom, reference = held['odom'].row, held['reference'].row
    return PositionTick(time, Pose(*odom[:3]), BodyVelocity(*odom[3:]),
                        Reference(Pose(*reference[:3]), BodyVelocity(*reference[3:])),
                        TrackingError(*held['tracking_error'].row))
