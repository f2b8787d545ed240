"""Samples and messages to the topics of a run, and back."""

from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.loop.closed_loop import Sample
from mobile_robot_control.quantities import NANOSECONDS
from mobile_robot_control.runs.columns import COLUMNS, TRUE_ERROR, Numbers, held_of, numbers_of, sample_of
from mobile_robot_control.runs.joining import join
from mobile_robot_control.runs.series import Series, Signal, Stamps, empty_signal
from mobile_robot_control.topics import GROUND_TRUTH, LOOP_TOPICS, VELOCITY_TOPICS

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
    unstamped : tuple of str
        Topics whose stamps are all 0; they have the times of receipt instead.

    """

    signals: dict[str, Signal]
    earlier_runs: int
    disordered: int
    contradicting: Mapping[str, int] = MappingProxyType({})
    unstamped: tuple[str, ...] = ()


class Messages:
    """The messages of the loop's topics, in their order of arrival."""

    def __init__(self) -> None:
        self._columns = {topic: (array('q'), array('q'), array('d')) for topic in COLUMNS}
        self._contradicting: Counter[str] = Counter()
        self._without_stamps: dict[str, list[tuple[int, array[float]]]] = {topic: [] for topic in COLUMNS}

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
        if topic in self._without_stamps:
            if stamp:
                del self._without_stamps[topic]
            elif received is not None:
                values = array('d', values)
                self._without_stamps[topic].append((received, values))
        if not stamps or stamp != stamps[-1]:
            stamps.append(stamp)
            numbers.extend(values)
            if received is not None:
                times.append(received)
        # as bytes: a value can be nan
        elif (repeated := array('d', values)).tobytes() != numbers[-len(repeated):].tobytes():
            self._contradicting[topic] += 1

    def last_run(self) -> LastRun:
        """Return the last run among the messages; no message can be added afterwards."""
        unstamped = self._received_only()
        # without a copy: an hour has some hundred megabytes
        run = last_run({topic: Signal(np.frombuffer(stamps, np.int64), np.frombuffer(times, np.int64),
                                      np.frombuffer(numbers).reshape(-1, len(COLUMNS[topic])))
                        for topic, (stamps, times, numbers) in self._columns.items()})
        return run._replace(contradicting=self._contradicting, unstamped=unstamped)

    def _received_only(self) -> tuple[str, ...]:
        """Stamp the messages of topics whose stamps are all 0 by their receipt; return these topics."""
        # in lockstep a message of stamp 0 is repeated as it is, and other topics do not go on
        others_go_on = any(stamps[-1] > stamps[0] + NANOSECONDS // 2 for stamps, *_ in self._columns.values() if stamps)
        topics = tuple(topic for topic, messages in self._without_stamps.items()
                       if len(messages) > 1 and (others_go_on or self._contradicting[topic]))
        for topic in topics:
            del self._contradicting[topic]
            self._columns[topic] = array('q'), array('q'), array('d')
            for received, values in self._without_stamps[topic]:
                self.add(topic, received, values, received)
        return topics


class _LastPart(NamedTuple):
    """The last run of one topic: its start, its number, the place of the last fall of stamps, and their count."""

    begin: int
    starts: int
    fell: int | None
    disordered: int


def _last_part(stamps: Stamps) -> _LastPart:
    """Find the start of a topic's last run: at stamp 0 after any other, or where stamps fell and stayed below."""
    part = _LastPart(0, 0, None, 0)
    falls = (np.flatnonzero(np.diff(stamps) < 0) + 1).tolist()
    for fall, following in zip(falls, [*falls[1:], stamps.size], strict=False):
        # in a bag without the start of a later run, its stamps fall, and stay below the former ones
        missed = (fall - part.begin >= _SURE and following - fall >= _SURE
                  and stamps[fall + _SURE - 1] < stamps[fall - _SURE:fall].min())
        part = (_LastPart(fall, part.starts + 1, None, part.disordered) if stamps[fall] == 0 or missed
                else part._replace(fell=fall, disordered=part.disordered + 1))
    return part


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


_TRUTH = (GROUND_TRUTH, TRUE_ERROR)
_BLOCK = 4096
"""Rows converted to samples at a time: lists of numbers are larger than arrays."""


class SampleReader:
    """Stores the numbers of samples as they pass; either all of them have a truth, or none."""

    def __init__(self) -> None:
        self._numbers = array('d')
        self._topics: tuple[str, ...] = tuple(LOOP_TOPICS)

    def add(self, time: float, tick: float, numbers: Numbers) -> None:
        """Store the numbers of a sample of a time, with those of a position tick [s]; see `numbers_of`."""
        self._topics = tuple(numbers)
        row = [time, tick]
        for values in numbers.values():
            row += values
        self._numbers.extend(row)

    def taking(self, samples: Iterable[Sample]) -> Iterator[Sample]:
        """Yield samples, and store their numbers."""
        for sample in samples:
            self.add(sample.time, sample.tick.time, numbers_of(sample))
            yield sample

    def series(self) -> Series:
        """Return the topics of the run."""
        widths = [len(COLUMNS[topic]) for topic in self._topics]
        ends = np.cumsum([2, *widths])
        rows = np.frombuffer(self._numbers).reshape(-1, ends[-1])
        steps, ticks = np.rint(rows[:, :2].T * 1e9).astype(np.int64)
        passed = {topic: empty_signal(topic) for topic in COLUMNS}
        for topic, begin, end in zip(self._topics, ends, ends[1:], strict=False):
            stamps, values = steps if topic in VELOCITY_TOPICS else ticks, rows[:, begin:end]
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
    topics = (*LOOP_TOPICS, *(_TRUTH if series.hides_truth else ()))
    held: Any = None
    for begin in range(0, joined.time.size, _BLOCK):
        rows = joined.rows(begin, begin + _BLOCK)
        columns = [rows.time, rows.number, *map(rows.values, LOOP_TOPICS),
                   *(rows.truth() if series.hides_truth else ())]
        for time, number, *values in zip(*(column.tolist() for column in columns), strict=True):
            numbers = dict(zip(topics, values, strict=True))
            if number != at:
                at, held = number, held_of(float(joined.tick[number]), numbers)
            yield sample_of(time, held, numbers)
