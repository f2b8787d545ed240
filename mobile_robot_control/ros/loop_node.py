"""What the four nodes have in common: checked parameters, validated inputs, a rate of their own, diagnostics."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, Generic, Protocol, TypeVar

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node
from rclpy.publisher import Publisher

try:
    from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
except ImportError:  # before iron
    from rclpy.qos_event import PublisherEventCallbacks, SubscriptionEventCallbacks

from mobile_robot_control.configuration.nodes import with_options
from mobile_robot_control.configuration.shared import Shared
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.ros.diagnostics import Condition, Diagnostics, OverrunCounter
from mobile_robot_control.ros.input_monitor import InputMonitor
from mobile_robot_control.ros.input_validation import InputValidator
from mobile_robot_control.ros.pacing import FixedRateTimer
from mobile_robot_control.ros.parameter_bridge import declare
from mobile_robot_control.ros.parameter_service import CheckedParameterService
from mobile_robot_control.ros.publisher_watch import PublisherWatch
from mobile_robot_control.ros.qos import SENSORS, SUBSCRIBED, publish_on, subscribe_to
from mobile_robot_control.ros.robot_clock import RobotClock
from mobile_robot_control.ros.run_events import RunEvents
from mobile_robot_control.ros.stamp_policy import StampDecision
from mobile_robot_control.topics import ALL_LOOP_TOPICS, LOOPS, MEASURED_TOPICS, OTHER_INPUTS, OTHER_TOPICS, LoopGraph


class _NodeParameters(Protocol):
    @property
    def shared(self) -> Shared:
        """Parameters that all four nodes agree on."""


NodeGroup = TypeVar('NodeGroup', bound=_NodeParameters)


class LoopNode(Node, Generic[NodeGroup]):
    """
    One of the four nodes.

    A subclass makes its publishers and subscriptions in its constructor, and calls `_start` at the end of it.

    Parameters
    ----------
    name : str
        Of the node.
    group : type
        The NamedTuple that declares its parameters.

    Attributes
    ----------
    exit_code : int or None
        Set when the node is done by itself; None before.

    """

    exit_code: int | None = None
    _in_run = _has_run = False

    def __init__(self, name: str, group: type[NodeGroup]) -> None:
        super().__init__(name, start_parameter_services=False)
        self._own_name = name  # whatever it is renamed to
        self._check_topics()
        self._values = declare(self, group)
        self._shared = self._values.shared
        self._loop = self._loop_graph()
        self._robot_clock = RobotClock(self, self._shared.lockstep, self._begin_anew_in_time)
        self._monitor = InputMonitor(self, self._monitored(), self._shared.peer_timeout, self._robot_clock)
        self._validator = InputValidator(self, self._monitor, self._shared.peer_timeout)
        watched = [*self._loop.topics_of(name), *(topic for topic, nodes in OTHER_INPUTS.items() if name in nodes)]
        self._watch = PublisherWatch(
            self, watched, self._loop.listeners_of(name) if self._shared.lockstep else {}, self._shared.peer_timeout)
        self._events = RunEvents(self)

    def _start(self, rate: float, tick: Callable[[], None], pace: OverrunCounter | None = None) -> None:
        """Begin to serve parameters, to publish diagnostics and, on the wall clock, to tick at a rate [Hz]."""
        if pace is None and not self._shared.lockstep:
            pace = FixedRateTimer(self._robot_clock, rate, tick)
        self._diagnostics = Diagnostics(self, self._validator, self._monitor, self._watch, pace, self._condition)
        CheckedParameterService(self, type(self._values), self._apply, self._refusals)
        self.get_logger().info(f'waiting for {", ".join(self._awaited())}')

    def _subscribe(self, topic: str, take: Callable[[bytes], None]) -> None:
        """Subscribe to a loop topic; on the wall clock take what robots measure from best-effort publishers, too."""
        quality = SENSORS if topic in MEASURED_TOPICS and not self._shared.lockstep else SUBSCRIBED
        subscribe_to(self, topic, take, quality, event_callbacks=SubscriptionEventCallbacks(
            incompatible_qos=partial(self._watch.note_unfit, topic, 'publisher')))

    def _publish_on(self, topic: str) -> Publisher[Any]:
        """Make a publisher on a loop topic."""
        return publish_on(self, topic, event_callbacks=PublisherEventCallbacks(
            incompatible_qos=partial(self._watch.note_unfit, topic, 'subscription')))

    def _check_topics(self) -> None:
        """Raise ParameterError where remapping gives two topics one name."""
        names: dict[str, list[str]] = {}
        for topic in {**ALL_LOOP_TOPICS, **OTHER_TOPICS, **OTHER_INPUTS}:
            names.setdefault(self.resolve_topic_name(topic), []).append(topic)
        violations = [f"{' and '.join(topics)} would be the same topic, '{name}'; change the remapping (-r) of one"
                         for name, topics in names.items() if len(topics) > 1]
        if violations:
            raise ParameterError(violations)

    def _note_run(self, decision: StampDecision, stamp: int = 0) -> None:
        """Log that a run begins, begins anew or is joined at a stamp [ns]."""
        if decision is StampDecision.JOIN:
            self.get_logger().info(f'joined a run under way at t = {stamp / 1e9:g} s')
        else:
            self.get_logger().info('a new run begins' if self._has_run else 'a run begins')
            self._events.begin_run(self._has_run)
        self._in_run = self._has_run = True

    def _begin_anew_in_time(self) -> None:
        """Forget what belongs to a run whose simulated time has jumped back; a stop stays."""
        self.get_logger().warning('/clock has jumped back: a new run begins with the next inputs')
        self._in_run = False
        self._monitor.forget()
        self._forget()

    def _forget(self) -> None:
        """Forget inputs and states of a run on the wall clock."""

    def _awaited(self) -> list[str]:
        """Return what the node waits for before a run begins."""
        return [f'{topic} from {source}' for topic, source in self._monitor.sources.items()]

    def _reached(self) -> int | None:
        """Return the newest simulated time [ns], where there is one."""
        return None

    def _loop_graph(self) -> LoopGraph:
        """Return the loop that the node is part of; all but the plant have the same topics in each."""
        return with_options(LOOPS['torque'], self._shared)

    def _monitored(self) -> dict[str, str]:
        """Return the input topics whose silence is reported, each with its publisher."""
        return self._loop.inputs_of(self._own_name)

    def _condition(self) -> Condition | None:
        """Return a condition that only the node itself can know, or None."""
        return None

    def _last_condition(self) -> Condition:
        """Return what the last diagnostics say."""
        return Condition(DiagnosticStatus.OK, 'ended')

    def _refusals(self, _values: NodeGroup) -> Iterable[str]:
        """Return why parameters cannot be taken now."""
        return ()

    def _waits_for_a_run(self, _changed: Mapping[str, Any]) -> bool:
        """Return whether parameters that were set act from the next run on, and not from the next step."""
        return False

    def _apply(self, values: NodeGroup, changed: Mapping[str, Any]) -> None:
        waits = self._waits_for_a_run(changed)
        self._events.note(changed, waits)
        self._change(values, waits)

    def _change(self, values: NodeGroup, _waits: bool) -> None:
        """Take the parameters after a live change."""
        self._values = values

    def _clock_stamp(self) -> int:
        """Return the present stamp of the wall clock [ns]."""
        return int(self.get_clock().now().nanoseconds)

    def close(self) -> None:
        """Publish what must be published last, and wait until it has arrived."""
        self._events.flush()
        self._diagnostics.end(self._last_condition())
        reached = self._reached() if self._in_run else None
        self.get_logger().info('ended' if reached is None else f'ended at t = {reached / 1e9:g} s')
