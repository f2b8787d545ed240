"""The condition of a node, published on /diagnostics once a second."""

import math
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from mobile_robot_control.ros.shared.inputs import InputMonitor, InputValidator
from mobile_robot_control.ros.shared.peers import PublisherWatch
from mobile_robot_control.ros.shared.qos import flush
from mobile_robot_control.ros.shared.timers import create_steady_timer

LAW_FAILED = 'law failed'
"""State of a position controller with a failed law."""
SUBSCRIBERS_KEY = 'listeners of '
"""Prefix of a topic in the key of its number of discovered subscriptions."""


class Condition(NamedTuple):
    """
    The condition of a node.

    Attributes
    ----------
    level : bytes
        One of DiagnosticStatus: OK; WARN, it works but something is wrong; ERROR, it cannot work; STALE, it has not
        begun, for lack of input.
    state : str
        In a word: running, waiting, stopped, paused, ended, diverged, law failed; of a cart on a path also standing
        and arrived.
    waits_for : sequence of str
        Node names.
    detail : str
        The reason, in words; '' if the state implies it.

    """

    level: bytes
    state: str
    waits_for: Sequence[str] = ()
    detail: str = ''

    def text(self) -> str:
        """Return the condition in words."""
        waits = f', waits for {" and ".join(self.waits_for)}' if self.waits_for else ''
        return self.state + waits + (f': {self.detail}' if self.detail else '')


_PERIOD = 1.0
_OFTEN_SATURATED = 0.1
"""Share of steps at a torque limit above which the node warns."""


class OverrunCounter(Protocol):
    """A source of overruns: LockstepPacer in lockstep, FixedRateTimer on the wall clock."""

    overruns: int


class Diagnostics:
    """
    Counts a node's steps and publishes its condition.

    Parameters
    ----------
    node : Node
        Node of the diagnostics.
    validator : InputValidator
        Counts refused messages.
    monitor : InputMonitor
        Provides the ages of the inputs and of their stamps.
    watch : PublisherWatch
        Names other publishers, and incompatible endpoints.
    pace : OverrunCounter or None
        If the node keeps its own pace.
    override : callable
        Returns a Condition known only to the node itself, or None.
    running : callable
        Returns the state of a node that steps, in a word.

    Attributes
    ----------
    more : dict of str to object
        Further numbers of the report by key.

    """

    def __init__(
        self, node: Node, validator: InputValidator, monitor: InputMonitor, watch: PublisherWatch,
        pace: OverrunCounter | None,
        override: Callable[[], Condition | None] = lambda: None,
        running: Callable[[], str] = lambda: 'running',
    ) -> None:
        self._node, self._validator, self._monitor, self._running = node, validator, monitor, running
        self._watch, self._pace, self._override = watch, pace, override
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._refused_before = self._overruns_before = 0
        self.more: dict[str, object] = {}
        self._ever_stepped = False
        self._stopped: list[str] = []
        self._told: list[str] = []
        self._last_step = math.nan
        self._begin_period()
        create_steady_timer(_PERIOD, self._report, node)

    def _begin_period(self) -> None:
        self._intervals: list[float] = []
        self._ages: dict[str, list[float]] = {topic: [] for topic in self._monitor.sources}
        self._steps = self._saturated = 0

    def note_step(self, saturated: bool = False) -> None:
        """Note a step with the newest inputs, and whether a torque limit was reached."""
        now = time.monotonic()
        # before the first step the last one is NaN, which is not above or equal to anything
        if now >= self._last_step:
            self._intervals.append(now - self._last_step)
        self._last_step = now
        for topic, ages in self._ages.items():
            ages.append(self._monitor.stamp_age(topic))
        self._steps += 1
        self._saturated += saturated
        self._ever_stepped, self._stopped = True, []

    def note_stop(self, *topics: str) -> None:
        """Note a stop of the robot because these inputs are silent; log it once."""
        self._stopped = list(dict.fromkeys(self._monitor.sources[topic] for topic in topics))
        silent = [topic for topic in topics if math.isfinite(self._monitor.age(topic))]
        if silent and self._stopped != self._told:
            self._told = self._stopped
            self._node.get_logger().error('; '.join([
                f'the robot is stopped: {" and ".join(silent)} silent, from {" and ".join(self._stopped)}',
                *self._validator.newest()]))

    def condition(self) -> Condition:
        """Return the condition, from the steps, refusals and silences since the last report."""
        override = self._override()
        if override is not None:
            return override
        missing = self._monitor.missing_inputs()
        if not self._ever_stepped:
            return Condition(DiagnosticStatus.STALE, 'waiting', missing, '; '.join(self._validator.newest()))
        if self._stopped:
            return Condition(DiagnosticStatus.ERROR, 'stopped', self._stopped, '; '.join(self._validator.newest()))
        if not self._steps:
            return Condition(DiagnosticStatus.ERROR if missing else DiagnosticStatus.WARN, 'waiting', missing,
                             '; '.join(self.problems()))
        wrong = (
            bool(missing)
            or self._validator.refused.total() > self._refused_before
            or self._overruns() > self._overruns_before
            or self._saturated > _OFTEN_SATURATED * self._steps
            or bool(self.problems())
        )
        return Condition(DiagnosticStatus.WARN if wrong else DiagnosticStatus.OK, self._running(), missing,
                         '; '.join(self.problems()))

    def problems(self) -> list[str]:
        """List problems of endpoints and stamps, and the newest refusals, in words."""
        return [*self._validator.newest(), *self._watch.problems(), *self._monitor.problems()]

    def _overruns(self) -> int:
        return self._pace.overruns if self._pace is not None else 0

    def end(self, condition: Condition) -> None:
        """Publish the last report of a node that ends, and wait for its arrival."""
        self._publish(condition)
        flush(self._publisher)

    def publish_now(self) -> None:
        """Publish the condition at once, in the middle of a period."""
        self._publish(self.condition())

    def _report(self) -> None:
        if self._told and not self._stopped:
            self._told = []
            self._node.get_logger().info('the inputs are back: the robot is no longer stopped')
        self._watch.look()
        self._monitor.note_second()
        self._publish(self.condition())
        self._refused_before, self._overruns_before = self._validator.refused.total(), self._overruns()
        self._begin_period()

    def _publish(self, condition: Condition) -> None:
        name = self._node.get_fully_qualified_name().lstrip('/')
        status = DiagnosticStatus(
            level=condition.level, name=name, hardware_id=name.rpartition('/')[0],
            message=condition.text(),
            values=[KeyValue(key=key, value=str(value)) for key, value in self._values(condition).items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)

    def _values(self, condition: Condition) -> dict[str, object]:
        """Return the numbers of the report by key."""
        refused = self._validator.refused
        values: dict[str, object] = {
            'state': condition.state, 'waits for': ', '.join(condition.waits_for), 'steps': self._steps,
            'overruns': self._overruns(),
            'saturation share': f'{self._saturated / self._steps:.3f}' if self._steps else '0.000',
            'refused': refused.total(), **{f'refused {reason}': count for reason, count in sorted(refused.items())},
        }
        values |= self.more
        values |= {f'publishers of {topic}': names for topic, names in self._watch.several.items()}
        values |= {f'quality of service of {topic}': text for topic, text in self._watch.unfit.items()}
        for publisher in self._node.publishers:
            values[SUBSCRIBERS_KEY + publisher.topic_name] = publisher.get_subscription_count()
        if self._intervals:
            values['period mean [s]'] = f'{sum(self._intervals) / len(self._intervals):.6f}'
            values['period max [s]'] = f'{max(self._intervals):.6f}'
        for topic, ages in self._ages.items():
            values[f'{topic} age now [s]'] = f'{self._monitor.stamp_age(topic):.6f}'
            if ages:
                ages.sort()
                values[f'{topic} age median [s]'] = f'{ages[len(ages) // 2]:.6f}'
                values[f'{topic} age 99 % [s]'] = f'{ages[len(ages) * 99 // 100]:.6f}'
                values[f'{topic} age max [s]'] = f'{ages[-1]:.6f}'
        return values
