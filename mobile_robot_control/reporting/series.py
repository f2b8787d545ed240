"""A run as time series: what the figures draw."""

from collections.abc import Iterable

import numpy as np

from mobile_robot_control.recording.collector import Collector
from mobile_robot_control.recording.signals import Signal, origin
from mobile_robot_control.reporting.lines import Floats, Line
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.topics import LOOP_TOPICS


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
        self.origin = origin(signals)

    def line(self, topic: str, column: str) -> Line:
        """
        Give a column of a topic.

        Parameters
        ----------
        topic, column : str
            Of LOOP_TOPICS.

        Returns
        -------
        Line
            Empty for a silent topic.

        """
        names = LOOP_TOPICS[topic].columns
        signal = self.signals[topic]
        values = np.frombuffer(signal.values, dtype=np.float64).reshape(-1, len(names))
        return Line(self.time(topic), values[:, names.index(column)])

    def time(self, topic: str) -> Floats:
        """
        Give the times of a topic's messages.

        Parameters
        ----------
        topic : str
            Of LOOP_TOPICS.

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
            With the same origin, if that lies in it.

        """
        cut = {}
        for topic, signal in self.signals.items():
            count = int(np.searchsorted(self.time(topic), end, side='right'))
            cut[topic] = Signal(signal.stamps[:count], signal.received[:count],
                                signal.values[:count * len(LOOP_TOPICS[topic].columns)])
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
