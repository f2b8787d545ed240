"""The loop's topics of a run as plain arrays by stamp, whatever the run was read from."""

from array import array
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError, WheelTorque, WheelVelocity
from mobile_robot_control.readings import (
    read_error,
    read_odometry,
    read_torque,
    read_twist,
    read_wheel_angles,
    read_wheel_velocity,
)
from mobile_robot_control.simulation.closed_loop import PositionTick, Sample

FAST = ('joint_states', 'wheel_torques')
SLOW = ('odom', 'reference', 'cmd_vel', 'tracking_error')
_WALL = 10**15
"""[ns]: eleven days; later stamps are those of a wall clock, not of a run."""
_SURE = 50
"""So many stamps after a fall, behind as many before it, are a new run whose start was missed, and not a stranger."""


def _odometry(message: Any) -> tuple[float, ...]:
    pose, velocity = read_odometry(message)
    return (*pose, *velocity)


def _joints(message: Any) -> tuple[float, ...]:
    return (*read_wheel_angles(message), *read_wheel_velocity(message), *read_torque(message))


READ: dict[str, Callable[[Any], tuple[float, ...]]] = {
    'joint_states': _joints, 'wheel_torques': read_torque, 'odom': _odometry, 'reference': _odometry,
    'cmd_vel': read_twist, 'tracking_error': read_error,
}
"""What a message of each loop topic holds, in a row of COLUMNS."""
COLUMNS = {
    'joint_states': ('right_angle', 'left_angle', 'right_velocity', 'left_velocity', 'right_effort', 'left_effort'),
    'wheel_torques': ('right_effort', 'left_effort'),
    'odom': ('x', 'y', 'heading', 'linear', 'angular'),
    'reference': ('x', 'y', 'heading', 'linear', 'angular'),
    'cmd_vel': ('linear', 'angular'),
    'tracking_error': ('longitudinal', 'lateral', 'heading'),
}


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
        Row by row, as many a stamp as COLUMNS names.

    """

    stamps: 'array[int]'
    received: 'array[int]'
    values: 'array[float]'


def _silence() -> Signal:
    return Signal(array('q'), array('q'), array('d'))


class Collector:
    """
    Gathers the loop topics of the last run that it is told of.

    Attributes
    ----------
    disordered : int
        Messages that came after a later stamp of their topic; they are put in order.

    """

    def __init__(self) -> None:
        self.disordered = 0
        self._heard = {topic: _silence() for topic in COLUMNS}
        self._starts: Counter[str] = Counter()
        self._descents: dict[str, int] = {}

    def add(self, topic: str, stamp: int, values: Iterable[float], received: int | None = None) -> None:
        """
        Take in one message; a repeat says the same again, and stamp 0 after any other begins a new run.

        Parameters
        ----------
        topic : str
            One of COLUMNS.
        stamp : int
            [ns].
        values : iterable of float
            As COLUMNS names them.
        received : int or None
            Wall time [ns].

        """
        signal = self._heard[topic]
        newest = signal.stamps[-1] if signal.stamps else -1
        if stamp == newest:
            return
        if stamp == 0 and newest > 0:
            # each topic begins anew by itself: a recorder may hear an answer before the question
            signal = self._heard[topic] = _silence()
            self._starts[topic] += 1
            self._descents.pop(topic, None)
        elif stamp < newest:
            self.disordered += 1
            self._descents[topic] = len(signal.stamps)
        signal.stamps.append(stamp)
        signal.values.extend(values)
        if received is not None:
            signal.received.append(received)
        fell = self._descents.get(topic)
        if (fell is not None and fell >= _SURE and len(signal.stamps) - fell == _SURE
                and stamp < min(signal.stamps[fell - _SURE:fell])):
            self._heard[topic] = self._since(topic, fell)
            self._starts[topic] += 1
            self.disordered -= 1
            del self._descents[topic]

    def add_sample(self, sample: Sample) -> None:
        """
        Take in what all topics say at one time.

        Parameters
        ----------
        sample : Sample
            Later than the last.

        """
        stamp, tick = round(sample.time * 1e9), sample.tick
        self.add('joint_states', stamp, (sample.right_angle, sample.left_angle, *sample.wheels, *sample.applied))
        self.add('wheel_torques', stamp, sample.torque)
        at = round(tick.time * 1e9)
        self.add('odom', at, (*tick.pose, *tick.velocity))
        self.add('reference', at, (*tick.reference.pose, *tick.reference.velocity))
        self.add('cmd_vel', at, sample.command)
        self.add('tracking_error', at, tick.error)

    @property
    def earlier_runs(self) -> int:
        """Runs left out because another began after them."""
        return max(self._starts['joint_states'], self._starts['odom'])

    @property
    def signals(self) -> dict[str, Signal]:
        """By topic; empty arrays for one that was silent in the last run."""
        return {topic: _in_order(self._of_last_run(topic), len(COLUMNS[topic])) for topic in COLUMNS}

    def _of_last_run(self, topic: str) -> Signal:
        signal = self._heard[topic]
        if self._starts[topic] >= self.earlier_runs:
            return signal
        # the recorder missed this topic's stamp 0: the run is what came since the stamps last fell
        if topic in self._descents:
            return self._since(topic, self._descents[topic])
        # or it was not heard before: then it still talks when the last run has begun
        begun = [heard.received[0] for other, heard in self._heard.items()
                 if self._starts[other] == self.earlier_runs and heard.received]
        talks = signal.received and begun and signal.received[-1] > max(begun)
        return signal if talks else _silence()

    def _since(self, topic: str, first: int) -> Signal:
        signal = self._heard[topic]
        return Signal(signal.stamps[first:], signal.received[first:], signal.values[first * len(COLUMNS[topic]):])


def _in_order(signal: Signal, width: int) -> Signal:
    """Sort by stamp where need be; of several messages with one stamp the first stays."""
    stamps = signal.stamps
    order: list[int] = []
    for n in sorted(range(len(stamps)), key=stamps.__getitem__):
        if not order or stamps[n] > stamps[order[-1]]:
            order.append(n)
    if order == list(range(len(stamps))):
        return signal
    return Signal(
        array('q', (stamps[n] for n in order)),
        array('q', (signal.received[n] for n in order) if signal.received else ()),
        array('d', (value for n in order for value in signal.values[n * width:(n + 1) * width])),
    )


def origin(signals: dict[str, Signal]) -> int:
    """
    Give the stamp that a run's time is counted from.

    Parameters
    ----------
    signals : dict of str to Signal
        By topic.

    Returns
    -------
    int
        0 in lockstep; on the wall clock the first stamp of ``reference``, when the curve begins [ns].

    """
    first = {topic: signal.stamps[0] for topic, signal in signals.items() if signal.stamps}
    begun = first.get('reference', min(first.values(), default=0))
    return begun if begun > _WALL else 0


def _rows(signal: Signal, width: int) -> Iterator[tuple[int, tuple[float, ...]]]:
    for n, stamp in enumerate(signal.stamps):
        yield stamp, tuple(signal.values[n * width:(n + 1) * width])


class _Held:
    """Steps through a signal and holds its newest row."""

    def __init__(self, topic: str, signal: Signal) -> None:
        self._rows = _rows(signal, len(COLUMNS[topic]))
        self._next = next(self._rows, None)
        self.stamp = -1
        self.row: tuple[float, ...] = ()

    def until(self, stamp: int) -> None:
        while self._next is not None and self._next[0] <= stamp:
            self.stamp, self.row = self._next
            self._next = next(self._rows, None)


def joined(signals: dict[str, Signal]) -> Iterator[Sample]:
    """
    Join the topics by stamp into what they say together at each time of the fast loop.

    Parameters
    ----------
    signals : dict of str to Signal
        By topic.

    Yields
    ------
    Sample
        In lockstep one for each stamp that both fast topics have, with the newest position tick that all slow topics
        have. On the wall clock, where every node has stamps of its own, one for each ``joint_states``, with the
        newest of all others, from the time on when all have spoken; see :func:`origin` for how time is counted.

    """
    start = origin(signals)
    held = {topic: _Held(topic, signals[topic]) for topic in signals if topic != 'joint_states'}
    slow, torque = [held[topic] for topic in SLOW], held['wheel_torques']
    tick: PositionTick | None = None
    seen = -1
    for stamp, row in _rows(signals['joint_states'], len(COLUMNS['joint_states'])):
        for topic in held.values():
            topic.until(stamp)
        at = held['tracking_error'].stamp
        if at > seen and _whole([topic.stamp for topic in slow], start):
            seen = at
            # on the wall clock a tick is of the first sample that knows of it
            tick = _tick((stamp - start if start else at) / 1e9, held)
            command = BodyVelocity(*held['cmd_vel'].row)
        if tick is not None and (torque.stamp == stamp or (start and torque.stamp >= 0)):
            yield Sample((stamp - start) / 1e9, tick, command, row[0], row[1], WheelVelocity(*row[2:4]),
                         WheelTorque(*row[4:]), WheelTorque(*torque.row))


def _whole(stamps: list[int], start: int) -> bool:
    return min(stamps) >= 0 if start else min(stamps) == max(stamps)


def _tick(time: float, held: dict[str, _Held]) -> PositionTick:
    odom, reference = held['odom'].row, held['reference'].row
    return PositionTick(time, Pose(*odom[:3]), BodyVelocity(*odom[3:]),
                        Reference(Pose(*reference[:3]), BodyVelocity(*reference[3:])),
                        TrackingError(*held['tracking_error'].row))
