"""A run as time series, for figures and tables."""

from collections.abc import Iterable

import numpy as np

from mobile_robot_control.recording.collector import Collector
from mobile_robot_control.recording.signals import COLUMNS, GROUND_TRUTH, TRUE_ERROR, Signal, origin
from mobile_robot_control.reporting.lines import Floats, Line
from mobile_robot_control.simulation.closed_loop import Sample

_NOTHING = Line(np.zeros(0), np.zeros(0))


class Series:
    """
    The topics of a run over its time.

    Attributes
    ----------
    signals : dict of str to Signal
        By topic.
    origin : int
        Stamp of t = 0 [ns]; not 0 on the wall clock.
    """

    def __init__(self, signals: dict[str, Signal]) -> None:
        self.signals = signals
        self.origin = origin(signals)

    def line(self, topic: str, column: str) -> Line:
        """Return a column of a topic, both of COLUMNS; empty for a topic without messages."""
        names = COLUMNS[topic]
        signal = self.signals[topic]
        values = np.frombuffer(signal.values, dtype=np.float64).reshape(-1, len(names))
        return Line(self.time(topic), values[:, names.index(column)])

    def time(self, topic: str) -> Floats:
        """Return the times of a topic's messages [s], shape (n,)."""
        stamps = np.frombuffer(self.signals[topic].stamps, dtype=np.int64)
        times: Floats = (stamps - self.origin) / 1e9
        return times

    def until(self, end: float) -> 'Series':
        """Return the messages up to a time [s], with the same origin if that is among them."""
        cut = {}
        for topic, signal in self.signals.items():
            count = int(np.searchsorted(self.time(topic), end, side='right'))
            cut[topic] = Signal(signal.stamps[:count], signal.received[:count],
                                signal.values[:count * len(COLUMNS[topic])])
        return Series(cut)

    @property
    def motion(self) -> str:
        """The topic with the poses of the robot: the true ones where they are known beside those of odometry."""
        return GROUND_TRUTH if self.signals[GROUND_TRUTH].stamps else 'odom'

    @property
    def hides_truth(self) -> bool:
        """Whether the truth is known beside what odometry shows."""
        return bool(self.signals[TRUE_ERROR].stamps)

    def error(self, column: str) -> Line:
        """Return a column of the tracking error: of the true one where it is known beside the measured one."""
        return self.line(TRUE_ERROR if self.hides_truth else 'tracking_error', column)

    def measured_error(self, column: str) -> Line:
        """Return a column of the tracking error that the controller saw; empty where it is all that there is."""
        return self.line('tracking_error', column) if self.hides_truth else _NOTHING

    def headings(self) -> tuple[Line, Line]:
        """Return the headings of robot and cart [rad] without jumps at ±π, and without whole turns between them."""
        robot, cart = (_unwrapped(self.line(topic, 'heading')) for topic in ('odom', 'reference'))
        if robot.value.size and cart.value.size:
            apart = np.interp(robot.time, cart.time, cart.value) - robot.value
            turns = round(float(np.median(apart)) / (2.0 * np.pi))
            robot = Line(robot.time, robot.value + 2.0 * np.pi * turns)
        return robot, cart

    def power(self) -> tuple[Line, Line]:
        """Return the power of the right and of the left motor [W]: torque over a step, wheel velocity at its start."""
        lines = []
        for wheel in ('right', 'left'):
            torque, speed = self.torque(wheel), self.line('joint_states', f'{wheel}_velocity')
            lines.append(Line(torque.time, torque.value * speed.value[:torque.value.size]))
        return lines[0], lines[1]

    def torque(self, wheel: str) -> Line:
        """
        Return the torque of the 'right' or 'left' wheel over each step [N m], at the step's start; empty if not known.

        The effort of a `joint_states` message was applied over the step that ended at its stamp.
        """
        effort = self.line('joint_states', f'{wheel}_effort')
        return _NOTHING if np.isnan(effort.value).all() else Line(effort.time[:-1], effort.value[1:])

    def energy(self) -> Line:
        """Return the integral of the positive power of both wheels [J]."""
        right, left = self.power()
        if not right.time.size:
            return _NOTHING
        time = self.time('joint_states')
        steps = np.diff(time)
        drawn = (np.maximum(right.value, 0.0) + np.maximum(left.value, 0.0)) * steps
        return Line(time, np.concatenate([np.zeros(1), np.cumsum(np.nan_to_num(drawn))]))


def _unwrapped(line: Line) -> Line:
    return Line(line.time, np.unwrap(line.value))


def collect(samples: Iterable[Sample]) -> Series:
    """Return the time series of samples in order of time."""
    collector = Collector()
    for sample in samples:
        collector.add_sample(sample)
    return Series(collector.signals)
