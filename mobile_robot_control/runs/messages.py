"""The collector of messages: in any order, they become the topics of the last run."""

from array import array
from collections import Counter
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from mobile_robot_control.recording.columns import COLUMNS
from mobile_robot_control.runs.series import Signal, Stamps

_SURE = 50
"""So many stamps after a fall, with as many before it, show a new run whose start was missed."""


class LastRun(NamedTuple):
    """
    The last run among messages.

    Attributes
    ----------
    signals : dict of str to Signal
        By topic; empty for a topic that was silent in the run.
    earlier_runs : int
        Runs left out because another began after them.
    disordered : int
        Messages that came after a later stamp of their topic; they are sorted.
    contradicting : dict of str to int
        By topic, messages with the stamp of the one before them and other values; they are left out.

    """

    signals: dict[str, Signal]
    earlier_runs: int
    disordered: int
    contradicting: Mapping[str, int] = MappingProxyType({})


class Messages:
    """The messages of the loop's topics, in their order of arrival."""

    def __init__(self) -> None:
        self._columns = {topic: (array('q'), array('q'), array('d')) for topic in COLUMNS}
        self._contradicting: Counter[str] = Counter()

    def add(self, topic: str, stamp: int, values: Iterable[float], received: int | None = None) -> None:
        """
        Add one message; one with the stamp of the previous one is dropped.

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
        stamps, times, numbers = self._columns[topic]
        if not stamps or stamp != stamps[-1]:
            stamps.append(stamp)
            numbers.extend(values)
            if received is not None:
                times.append(received)
        # as bytes: a value can be nan
        elif (given := array('d', values)).tobytes() != numbers[-len(given):].tobytes():
            self._contradicting[topic] += 1

    def last_run(self) -> LastRun:
        """Return the last run among the messages; no message can be added afterwards."""
        # without a copy: an hour has some hundred megabytes
        found = last_run({topic: Signal(np.frombuffer(stamps, np.int64), np.frombuffer(times, np.int64),
                                        np.frombuffer(numbers).reshape(-1, len(COLUMNS[topic])))
                          for topic, (stamps, times, numbers) in self._columns.items()})
        return found._replace(contradicting=self._contradicting)


class _Part(NamedTuple):
    """The last run of one topic: its start, its number, the place of the last fall of stamps, and their count."""

    begin: int
    starts: int
    fell: int | None
    disordered: int


def _last_part(stamps: Stamps) -> _Part:
    """Find the start of a topic's last run: at stamp 0 after any other, or where stamps fell and stayed below."""
    found = _Part(0, 0, None, 0)
    falls = (np.flatnonzero(np.diff(stamps) < 0) + 1).tolist()
    for fall, following in zip(falls, [*falls[1:], stamps.size], strict=False):
        # in a bag without the start of a later run, its stamps fall, and stay below the former ones
        missed = (fall - found.begin >= _SURE and following - fall >= _SURE
                  and stamps[fall + _SURE - 1] < stamps[fall - _SURE:fall].min())
        found = (_Part(fall, found.starts + 1, None, found.disordered) if stamps[fall] == 0 or missed
                 else found._replace(fell=fall, disordered=found.disordered + 1))
    return found


def last_run(received: Mapping[str, Signal]) -> LastRun:
    """
    Return the last run among messages.

    Parameters
    ----------
    received : mapping of str to Signal
        Topics of COLUMNS, with their messages in order of arrival, without consecutive repeats.

    """
    parts = {topic: _last_part(signal.stamps) for topic, signal in received.items()}
    newest = max(parts[topic].starts for topic in ('joint_states', 'odom'))
    begun = [received[topic].received[part.begin] for topic, part in parts.items()
             if part.starts == newest and received[topic].received.size]
    signals = {}
    for topic, signal in received.items():
        begin, starts, fell, _ = parts[topic]
        if starts < newest:
            # each topic restarts by itself. The recorder missed this one's stamp 0: the run is what came since the last
            # fall of stamps; or the topic was not recorded before: then its messages still come when the last run has
            # begun
            goes_on = signal.received.size and begun and signal.received[-1] > max(begun)
            begin = fell if fell is not None else begin if goes_on else signal.stamps.size
        signals[topic] = _in_order(signal.part(begin, signal.stamps.size))
    return LastRun(signals, newest, sum(part.disordered for part in parts.values()))


def _in_order(signal: Signal) -> Signal:
    """Sort by stamp if necessary; of several messages with one stamp the first stays."""
    if (np.diff(signal.stamps) > 0).all():
        return signal
    stamps, order = np.unique(signal.stamps, return_index=True)
    return Signal(stamps, signal.received[order] if signal.received.size else signal.received, signal.values[order])
