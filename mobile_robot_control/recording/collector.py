"""Gather the loop topics of a run, message by message."""

import math
from array import array
from collections import Counter
from collections.abc import Iterable

from mobile_robot_control.recording.signals import COLUMNS, GROUND_TRUTH, TRUE_ERROR, Signal, empty_signal
from mobile_robot_control.simulation.closed_loop import Sample

_SURE = 50
"""So many stamps after a fall, behind as many before it, are a new run whose start was missed."""


class Collector:
    """
    Gathers the loop topics of the last run among the messages that it is given.

    Attributes
    ----------
    disordered : int
        Messages that came after a later stamp of their topic; they are put in order.
    """

    def __init__(self) -> None:
        self.disordered = 0
        self._signals = {topic: empty_signal() for topic in COLUMNS}
        self._starts: Counter[str] = Counter()
        self._descents: dict[str, int] = {}

    def add(self, topic: str, stamp: int, values: Iterable[float], received: int | None = None) -> None:
        """
        Take in one message; a repeat is dropped, and stamp 0 after any other begins a new run.

        Parameters
        ----------
        topic : str
            Of COLUMNS.
        stamp : int
            [ns].
        values : iterable of float
            The topic's columns.
        received : int or None
            Wall time [ns].
        """
        signal = self._signals[topic]
        newest = signal.stamps[-1] if signal.stamps else -1
        if stamp == newest:
            return
        if stamp == 0 and newest > 0:
            # each topic begins anew by itself: a recorder may receive an answer before the question
            signal = self._signals[topic] = empty_signal()
            self._starts[topic] += 1
            self._descents.pop(topic, None)
        elif stamp < newest:
            self.disordered += 1
            self._descents[topic] = len(signal.stamps)
        signal.stamps.append(stamp)
        signal.values.extend(values)
        if received is not None:
            signal.received.append(received)
        # where a bag lacks the start of a later run: its stamps fell, and stay below the former ones
        fell = self._descents.get(topic)
        if (fell is not None and fell >= _SURE and len(signal.stamps) - fell == _SURE
                and stamp < min(signal.stamps[fell - _SURE:fell])):
            self._signals[topic] = self._since(topic, fell)
            self._starts[topic] += 1
            self.disordered -= 1
            del self._descents[topic]

    def add_sample(self, sample: Sample) -> None:
        """Take in all topics of one time, later than the last."""
        stamp, tick = round(sample.time * 1e9), sample.tick
        self.add('joint_states', stamp, (sample.right_angle, sample.left_angle, *sample.wheels, *sample.applied))
        if not math.isnan(sample.torque.right):
            self.add('wheel_torques', stamp, sample.torque)
        at = round(tick.time * 1e9)
        self.add('odom', at, (*tick.pose, *tick.velocity))
        self.add('reference', at, (*tick.reference.pose, *tick.reference.velocity))
        self.add('cmd_vel', at, sample.command)
        self.add('tracking_error', at, tick.error)
        if sample.truth is not None:
            self.add(GROUND_TRUTH, at, (*sample.truth.pose, *sample.truth.velocity))
            self.add(TRUE_ERROR, at, sample.truth.error)

    @property
    def earlier_runs(self) -> int:
        """Runs left out because another began after them."""
        return max(self._starts['joint_states'], self._starts['odom'])

    @property
    def signals(self) -> dict[str, Signal]:
        """The signals by topic; empty for one that was silent in the last run."""
        return {topic: _in_order(self._of_last_run(topic), len(names)) for topic, names in COLUMNS.items()}

    def _of_last_run(self, topic: str) -> Signal:
        """Return what a topic carried in the last run."""
        signal = self._signals[topic]
        if self._starts[topic] >= self.earlier_runs:
            return signal
        # the recorder missed this topic's stamp 0: the run is what came since the stamps last fell
        if topic in self._descents:
            return self._since(topic, self._descents[topic])
        # or it was not recorded before: then its messages still come when the last run has begun
        begun = [one.received[0] for other, one in self._signals.items()
                 if self._starts[other] == self.earlier_runs and one.received]
        goes_on = signal.received and begun and signal.received[-1] > max(begun)
        return signal if goes_on else empty_signal()

    def _since(self, topic: str, first: int) -> Signal:
        """Return a topic's messages from the n-th on."""
        signal = self._signals[topic]
        width = len(COLUMNS[topic])
        return Signal(signal.stamps[first:], signal.received[first:], signal.values[first * width:])


def _in_order(signal: Signal, width: int) -> Signal:
    """Sort by stamp where necessary; of several messages with one stamp the first stays."""
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
