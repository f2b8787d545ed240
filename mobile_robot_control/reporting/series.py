"""A run as time series: what the figures draw."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.recording import signals as recorded
from mobile_robot_control.recording.signals import COLUMNS, Collector, Signal
from mobile_robot_control.simulation.closed_loop import Sample

Floats = NDArray[np.float64]
_BUCKETS = 1200
"""A line needs no more points than twice this: a figure is about as many pixels wide."""


class Line(NamedTuple):
    """
    One quantity over time.

    Attributes
    ----------
    time, value : array, shape (n,)
        [s], and the quantity's unit.

    """

    time: Floats
    value: Floats


class Series:
    """
    The topics of a run over its time.

    Parameters
    ----------
    signals : dict of str to Signal
        By topic.

    Attributes
    ----------
    signals : dict of str to Signal
        The same.
    origin : int
        Stamp of t = 0 [ns].

    """

    def __init__(self, signals: dict[str, Signal]) -> None:
        self.signals = signals
        self.origin = recorded.origin(signals)

    def line(self, topic: str, column: str) -> Line:
        """
        Give a column of a topic.

        Parameters
        ----------
        topic, column : str
            Of COLUMNS.

        Returns
        -------
        Line
            Empty for a silent topic.

        """
        names = COLUMNS[topic]
        signal = self.signals[topic]
        values = np.frombuffer(signal.values, dtype=np.float64).reshape(-1, len(names))
        return Line(self.time(topic), values[:, names.index(column)])

    def time(self, topic: str) -> Floats:
        """
        Give the times of a topic's messages.

        Parameters
        ----------
        topic : str
            Of COLUMNS.

        Returns
        -------
        array, shape (n,)
            [s].

        """
        stamps = np.frombuffer(self.signals[topic].stamps, dtype=np.int64)
        times: Floats = (stamps - self.origin) / 1e9
        return times

    def until(self, end: float) -> 'Series':
        """
        Give the beginning of the run.

        Parameters
        ----------
        end : float
            Time of the last messages taken [s].

        Returns
        -------
        Series
            Without times of receipt.

        """
        cut = {}
        for topic, signal in self.signals.items():
            count = int(np.searchsorted(self.time(topic), end, side='right'))
            cut[topic] = Signal(signal.stamps[:count], signal.received[:0], signal.values[:count * len(COLUMNS[topic])])
        return Series(cut)

    def headings(self) -> tuple[Line, Line]:
        """
        Give the headings of robot and cart without jumps at ±π.

        Returns
        -------
        tuple of Line and Line
            Robot's and cart's [rad]; by whole turns as near each other as they are most of the time.

        """
        robot, cart = (_unwrapped(self.line(topic, 'heading')) for topic in ('odom', 'reference'))
        if robot.value.size and cart.value.size:
            apart = np.interp(robot.time, cart.time, cart.value) - robot.value
            turns = round(float(np.median(apart)) / (2.0 * np.pi))
            robot = Line(robot.time, robot.value + 2.0 * np.pi * turns)
        return robot, cart

    def power(self) -> tuple[Line, Line]:
        """
        Give what each motor gives: the torque over a step times the wheel's velocity at the step's start.

        Returns
        -------
        tuple of Line and Line
            Right and left [W], at the steps' starts.

        """
        lines = []
        for wheel in ('right', 'left'):
            torque, speed = self.torque(wheel), self.line('joint_states', f'{wheel}_velocity')
            lines.append(Line(torque.time, torque.value * speed.value[:-1]))
        return lines[0], lines[1]

    def torque(self, wheel: str) -> Line:
        """
        Give the torque applied over each step.

        Parameters
        ----------
        wheel : str
            'right' or 'left'.

        Returns
        -------
        Line
            [N m] at the steps' starts: a message's effort was held over the step before it.

        """
        effort = self.line('joint_states', f'{wheel}_effort')
        return Line(effort.time[:-1], effort.value[1:])

    def energy(self) -> Line:
        """
        Give the integral of the positive power of both wheels.

        Returns
        -------
        Line
            [J].

        """
        right, left = self.power()
        time = self.time('joint_states')
        steps = np.diff(time)
        drawn = (np.maximum(right.value, 0.0) + np.maximum(left.value, 0.0)) * steps
        return Line(time, np.concatenate([np.zeros(min(1, time.size)), np.cumsum(drawn)]))


def _unwrapped(line: Line) -> Line:
    return Line(line.time, np.unwrap(line.value))


def broken_at_jumps(line: Line) -> Line:
    """
    Break the line of a wrapped angle where it jumps.

    Parameters
    ----------
    line : Line
        [rad] in (-π, π].

    Returns
    -------
    Line
        With a nan in each jump, where nothing is drawn.

    """
    jumps = np.nonzero(np.abs(np.diff(line.value)) > np.pi)[0] + 1
    return Line(np.insert(line.time, jumps, line.time[jumps]), np.insert(line.value, jumps, np.nan))


def collect(samples: Iterable[Sample]) -> Series:
    """
    Gather the samples of a run.

    Parameters
    ----------
    samples : iterable of Sample
        In order of time.

    Returns
    -------
    Series
        Of them.

    """
    collector = Collector()
    for sample in samples:
        collector.add_sample(sample)
    return Series(collector.signals)


def thinned(line: Line) -> Line:
    """
    Leave out points that no picture could show.

    Parameters
    ----------
    line : Line
        Any number of points.

    Returns
    -------
    Line
        Of each bucket of points the smallest and the largest value, in order of time, so that no peak is lost; a
        short line as it is.

    Examples
    --------
    >>> thinned(Line(np.arange(1e5), np.sin(np.arange(1e5)))).time.size
    2402

    """
    count = line.time.size
    if count <= 2 * _BUCKETS:
        return line
    broken = np.nonzero(np.isnan(line.value))[0]
    whole = np.where(np.isnan(line.value), 0.0, line.value)
    edges = np.linspace(0, count, _BUCKETS + 1).astype(int)[:-1]
    lowest, highest = (_extremes(whole * sign, edges) for sign in (1.0, -1.0))
    chosen = np.unique(np.concatenate([lowest, highest, broken, [0, count - 1]]))
    return Line(line.time[chosen], line.value[chosen])


def _extremes(values: Floats, edges: NDArray[np.int_]) -> NDArray[np.int_]:
    """Find the place of the smallest value of each bucket."""
    ends = np.append(edges[1:], values.size)
    return np.array([start + np.argmin(values[start:end]) for start, end in zip(edges, ends, strict=True)])
