"""The topics of a run over time, from any source: each topic as columns with its own stamps; and its gaps."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.figures.figure import Floats, Line
from mobile_robot_control.quantities import WALL
from mobile_robot_control.runs.columns import COLUMNS, TRUE_ERROR
from mobile_robot_control.topics import GROUND_TRUTH, LOOP_TOPICS, POSITION_TOPICS, RUN_TOPICS

Stamps = NDArray[np.int64]
_NOTHING = Line(np.zeros(0), np.zeros(0))


class Signal(NamedTuple):
    """
    One topic of a run, repeats removed.

    Attributes
    ----------
    stamps : array of int, shape (n,)
        Ascending [ns].
    received : array of int, shape (n,) or (0,)
        Wall time of the first receipt [ns]; empty if the run was not recorded over DDS.
    values : array of float, shape (n, k)
        The columns of the topic.

    """

    stamps: Stamps
    received: Stamps
    values: Floats

    def part(self, begin: int, end: int) -> 'Signal':
        """Return the messages from index `begin` up to, but without, `end`."""
        return Signal(self.stamps[begin:end], self.received[begin:end], self.values[begin:end])


def empty_signal(topic: str) -> Signal:
    """Return a topic of COLUMNS without messages."""
    return Signal(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, len(COLUMNS[topic]))))


class Series:
    """
    The topics of a run over its time.

    Parameters
    ----------
    signals : mapping of str to Signal
        By topic; omitted topics have no messages.

    Attributes
    ----------
    signals : dict of str to Signal
        By topic, all of COLUMNS.
    is_lockstep : bool
        Whether the stamps are simulated time, shared by all nodes, and not of separate clocks.
    origin : int
        Stamp of t = 0 [ns]: 0 in lockstep; elsewhere the first stamp of `reference`, the start of the curve.
    """

    def __init__(self, signals: Mapping[str, Signal]) -> None:
        self.signals = {topic: signals[topic] if topic in signals else empty_signal(topic) for topic in COLUMNS}
        first = {topic: int(signal.stamps[0]) for topic, signal in self.signals.items() if signal.stamps.size}
        begun = first.get('reference', min(first.values(), default=0))
        odom, reference = (np.unique(self.signals[topic].stamps) for topic in ('odom', 'reference'))
        self.is_lockstep = begun <= WALL and (not odom.size or not reference.size or 2 * np.intersect1d(
            odom, reference, assume_unique=True).size > max(odom.size, reference.size))
        self.origin = 0 if self.is_lockstep else begun

    def has(self, topic: str) -> bool:
        """Return whether a topic has messages."""
        return bool(self.signals[topic].stamps.size)

    def line(self, topic: str, column: str) -> Line:
        """Return a column of a topic, both of COLUMNS; empty for a topic without messages."""
        return Line(self.time(topic), self.signals[topic].values[:, COLUMNS[topic].index(column)])

    def time(self, topic: str) -> Floats:
        """Return the times of a topic's messages [s], shape (n,)."""
        times: Floats = (self.signals[topic].stamps - self.origin) / 1e9
        return times

    def span(self) -> tuple[float, float]:
        """Return the first and the last time of any message [s]."""
        times = [self.time(topic) for topic in self.signals if self.has(topic)]
        return min(float(time[0]) for time in times), max(float(time[-1]) for time in times)

    def until(self, end: float) -> 'Series':
        """Return the messages up to a time [s], with the same origin if that is among them."""
        return Series({topic: signal.part(0, int(np.searchsorted(self.time(topic), end, side='right')))
                       for topic, signal in self.signals.items()})

    def begun_when_recorded(self) -> tuple['Series', int]:
        """
        Return a partly recorded run, with time from the beginning of the recording, and the stamp of that beginning
        [ns].

        It begins at the first stamp common to all topics of the slow loop. It ends at the last one, unless another
        topic lasts three periods longer; a run on the wall clock begins with its first reference anyway.
        """
        slow = [self.signals[topic].stamps for topic in POSITION_TOPICS if self.has(topic)]
        if not slow or not self.is_lockstep:
            return self, 0
        first, last = max(stamps[0] for stamps in slow), min(stamps[-1] for stamps in slow)
        longest = max(signal.stamps[-1] for signal in self.signals.values() if signal.stamps.size)
        if slow[0].size > 1 and longest - last > 3 * (slow[0][1] - slow[0][0]):
            last = longest
        parts = {topic: signal.part(int(np.searchsorted(signal.stamps, first)),
                                    int(np.searchsorted(signal.stamps, last, side='right')))
                 for topic, signal in self.signals.items()}
        begun = Series({topic: part._replace(stamps=part.stamps - first) for topic, part in parts.items()})
        return begun, int(first)

    @property
    def motion(self) -> str:
        """The topic with the poses of the robot: the true ones if they are known beside odometry."""
        return GROUND_TRUTH if self.has(GROUND_TRUTH) else 'odom'

    @property
    def hides_truth(self) -> bool:
        """Whether the truth is known beside odometry."""
        return self.has(TRUE_ERROR)

    @property
    def has_torques(self) -> bool:
        """Whether the applied torques are known: the efforts of `joint_states`."""
        return not bool(np.isnan(self.line('joint_states', 'right_effort').value).all())

    @property
    def clock(self) -> str:
        """The topic that sets the time base: the faster one of `joint_states` and `tracking_error`."""
        fast, slow = (period(self.signals[topic].stamps) for topic in ('joint_states', 'tracking_error'))
        comes = self.has('joint_states') and (fast <= slow or self.signals['tracking_error'].stamps.size < 2)
        return 'joint_states' if comes else 'tracking_error'

    def error(self, column: str) -> Line:
        """Return a column of the tracking error: of the true one if it is known beside the measured one."""
        return self.line(TRUE_ERROR if self.hides_truth else 'tracking_error', column)

    def measured_error(self, column: str) -> Line:
        """Return a column of the tracking error that the controller saw; empty if there is no true one beside it."""
        return self.line('tracking_error', column) if self.hides_truth else _NOTHING

    def headings(self) -> tuple[Line, Line]:
        """Return the headings of robot and cart [rad] without jumps at ±π, and without whole turns between them."""
        robot, cart = (_unwrapped(self.line(topic, 'heading')) for topic in ('odom', 'reference'))
        if robot.value.size and cart.value.size:
            apart = np.interp(robot.time, cart.time, cart.value) - robot.value
            turns = round(float(np.median(apart)) / (2.0 * np.pi))
            robot = Line(robot.time, robot.value + 2.0 * np.pi * turns)
        return robot, cart

    def power(self, wheel: str) -> Line:
        """Return the power of the 'right' or 'left' motor [W]: torque over a step, wheel velocity at its start."""
        torque, speed = self.torque(wheel), self.line('joint_states', f'{wheel}_velocity')
        return Line(torque.time, torque.value * speed.value[:torque.value.size])

    def torque(self, wheel: str) -> Line:
        """
        Return the torque of the 'right' or 'left' wheel over each step [N m], at the step's start; empty if unknown.

        The effort of a `joint_states` message was applied over the step up to its stamp.
        """
        effort = self.line('joint_states', f'{wheel}_effort')
        return _NOTHING if np.isnan(effort.value).all() else Line(effort.time[:-1], effort.value[1:])

    def energy(self) -> Line:
        """Return the integral of the positive power of both wheels [J]."""
        right, left = self.power('right'), self.power('left')
        if not right.time.size:
            return _NOTHING
        time = self.time('joint_states')
        steps = np.diff(time)
        drawn = (np.maximum(right.value, 0.0) + np.maximum(left.value, 0.0)) * steps
        return Line(time, np.concatenate([np.zeros(1), np.cumsum(np.nan_to_num(drawn))]))


def _unwrapped(line: Line) -> Line:
    return Line(line.time, np.unwrap(line.value))


def period(stamps: Stamps) -> int:
    """
    Return the usual distance between ascending stamps [ns]; 0 for fewer than two.

    It is the commonest distance if the stamps lie on a grid, and otherwise their median.
    """
    distances = np.diff(stamps)
    if not distances.size:
        return 0
    values, times = np.unique(distances, return_counts=True)
    common = times.argmax()
    return int(values[common] if times[common] > distances.size // 2 else np.sort(distances)[distances.size // 2])


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
    for topic in RUN_TOPICS:
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
               for topic in RUN_TOPICS)


def _patience(usual: int, start: int) -> int:
    """Return the longest silence that is no fault [ns], from the usual distance of a topic's stamps [ns]."""
    return int(usual * (_LATE_PERIODS if start else 1.5))


def _faulty_gaps(stamps: Stamps, start: int) -> list[Gap]:
    """Return the gaps that are faults: on the wall clock, an occasional delay of a node is none of the recording."""
    patience = _patience(period(stamps), start)
    return [gap for gap in find_gaps(stamps, start) if (gap.end - gap.start) * 1e9 > patience]


def _missing(gaps: list[Gap], usual: int) -> int:
    """Return the number of messages missing in gaps of a topic with a usual distance of stamps [ns]."""
    return sum(max(1, round((gap.end - gap.start) * 1e9 / usual) - 1) for gap in gaps)


def _faults(topic: str, stamps: Stamps, first: int, last: int, start: int) -> Iterator[str]:
    usual = period(stamps)
    patience = _patience(usual, start)
    if stamps[0] - first > patience:
        yield f'{topic} starts late, at t = {(stamps[0] - start) / 1e9:g} s'
    if last - stamps[-1] > patience:
        yield f'{topic} ends early, at t = {(stamps[-1] - start) / 1e9:g} s'
    gaps = _faulty_gaps(stamps, start)
    if gaps:
        missing = _missing(gaps, usual)
        widest = max(gaps, key=lambda gap: gap.end - gap.start)
        yield (f'{missing} of {len(stamps) + missing} messages missing on {topic}, in {len(gaps)} gap'
               f'{"s" if len(gaps) > 1 else ""}; the longest from t = {widest.start:g} s to {widest.end:g} s')
