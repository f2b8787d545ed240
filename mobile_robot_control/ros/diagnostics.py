"""What a node says of itself on /diagnostics, once a second."""

import math
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from mobile_robot_control.ros.border import Border
from mobile_robot_control.ros.peers import Peers
from mobile_robot_control.ros.qos import flush
from mobile_robot_control.ros.timers import every

LISTENERS = 'listeners of '
"""What stands before a topic in the key of how many the node has found that listen to it."""
_PERIOD = 1.0
_OFTEN_SATURATED = 0.1
"""Share of steps at a torque limit from which on it is worth a warning."""


class Condition(NamedTuple):
    """
    How a node is.

    Attributes
    ----------
    level : bytes
        One of DiagnosticStatus: OK; WARN, it works but something is wrong; ERROR, it cannot work; STALE, it has not
        begun, for want of input.
    state : str
        In a word: running, waiting, stopped, paused, ended, diverged.
    waits_for : sequence of str
        Node names.

    """

    level: bytes
    state: str
    waits_for: Sequence[str] = ()


class Clockwork(Protocol):
    """What may come late: Pace in lockstep, Ticker on the wall clock."""

    overruns: int


class Diagnostics:
    """
    Counts a node's steps and publishes how it is.

    Parameters
    ----------
    node : Node
        Whose diagnostics.
    border : Border
        Counts what the node refuses.
    peers : Peers
        Knows the ages of its inputs.
    clockwork : Clockwork or None
        Counts what came late, where the node keeps a pace of its own.
    override : callable
        Gives a Condition that only the node itself knows, or None.

    """

    def __init__(
        self, node: Node, border: Border, peers: Peers, clockwork: Clockwork | None,
        override: Callable[[], Condition | None] = lambda: None,
    ) -> None:
        self._node, self._border, self._peers = node, border, peers
        self._clockwork, self._override = clockwork, override
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._refused_before = self._overruns_before = 0
        self._ever_stepped = False
        self._stopped: list[str] = []
        self._last_step = math.nan
        self._begin()
        every(_PERIOD, self._report, node)

    def _begin(self) -> None:
        self._intervals: list[float] = []
        self._ages: dict[str, list[float]] = {topic: [] for topic in self._peers.sources}
        self._steps = self._saturated = 0

    def stepped(self, saturated: bool = False) -> None:
        """
        Note a step of the node with its newest inputs.

        Parameters
        ----------
        saturated : bool
            Whether a torque limit bound.

        """
        now = time.monotonic()
        # the first step has no predecessor, and NaN is not above or equal to anything
        if now >= self._last_step:
            self._intervals.append(now - self._last_step)
        self._last_step = now
        for topic, ages in self._ages.items():
            ages.append(self._peers.age(topic))
        self._steps += 1
        self._saturated += saturated
        self._ever_stepped, self._stopped = True, []

    def stopped(self, *topics: str) -> None:
        """
        Note that the node stops the robot because inputs are silent.

        Parameters
        ----------
        topics : str
            The silent ones.

        """
        self._stopped = [self._peers.sources[topic] for topic in topics]

    def condition(self) -> Condition:
        """
        Judge how the node is.

        Returns
        -------
        Condition
            From the steps, refusals and silences since the last report.

        """
        override = self._override()
        if override is not None:
            return override
        missing = self._peers.missing()
        if not self._ever_stepped:
            return Condition(DiagnosticStatus.STALE, 'waiting', missing)
        if self._stopped:
            return Condition(DiagnosticStatus.ERROR, 'stopped', self._stopped)
        if not self._steps:
            return Condition(DiagnosticStatus.ERROR if missing else DiagnosticStatus.WARN, 'waiting', missing)
        wrong = (
            bool(missing)
            or self._border.refused.total() > self._refused_before
            or self._overruns() > self._overruns_before
            or self._saturated > _OFTEN_SATURATED * self._steps
        )
        return Condition(DiagnosticStatus.WARN if wrong else DiagnosticStatus.OK, 'running', missing)

    def _overruns(self) -> int:
        return self._clockwork.overruns if self._clockwork is not None else 0

    def end(self, level: bytes = DiagnosticStatus.OK, state: str = 'ended') -> None:
        """
        Publish the last report of a node that ends, and wait until it has arrived.

        Parameters
        ----------
        level : bytes
            One of DiagnosticStatus.
        state : str
            In a word.

        """
        self._publish(Condition(level, state))
        flush(self._publisher)

    def _report(self) -> None:
        self._publish(self.condition())
        self._refused_before, self._overruns_before = self._border.refused.total(), self._overruns()
        self._begin()

    def _publish(self, condition: Condition) -> None:
        name = self._node.get_fully_qualified_name().lstrip('/')
        waits = f', waits for {" and ".join(condition.waits_for)}' if condition.waits_for else ''
        status = DiagnosticStatus(
            level=condition.level, name=name, message=condition.state + waits, hardware_id=name.rpartition('/')[0],
            values=[KeyValue(key=key, value=str(value)) for key, value in self._values(condition).items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)

    def _values(self, condition: Condition) -> dict[str, object]:
        refused = self._border.refused
        values: dict[str, object] = {
            'state': condition.state, 'waits for': ', '.join(condition.waits_for), 'steps': self._steps,
            'overruns': self._overruns(), 'saturation share': _share(self._saturated, self._steps),
            'refused': refused.total(), **{f'refused {reason}': count for reason, count in sorted(refused.items())},
        }
        for publisher in self._node.publishers:
            values[LISTENERS + publisher.topic_name] = publisher.get_subscription_count()
        if self._intervals:
            values['period mean [s]'] = f'{sum(self._intervals) / len(self._intervals):.6f}'
            values['period max [s]'] = f'{max(self._intervals):.6f}'
        for topic, ages in self._ages.items():
            values[f'{topic} age now [s]'] = f'{self._peers.age(topic):.6f}'
            if ages:
                ages.sort()
                values[f'{topic} age median [s]'] = f'{ages[len(ages) // 2]:.6f}'
                values[f'{topic} age 99 % [s]'] = f'{ages[len(ages) * 99 // 100]:.6f}'
                values[f'{topic} age max [s]'] = f'{ages[-1]:.6f}'
        return values


def _share(part: int, whole: int) -> str:
    return f'{part / whole:.3f}' if whole else '0.000'
