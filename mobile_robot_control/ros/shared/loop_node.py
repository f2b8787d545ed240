"""The shared parts of all nodes of the loop: checked parameters, tables of topics, a driver, events, diagnostics."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any, Generic, Protocol, TypeVar

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import period_nanoseconds
from mobile_robot_control.ros.shared.clock import refuse_negative_time
from mobile_robot_control.ros.shared.conversions import stamped_on_receipt, writer
from mobile_robot_control.ros.shared.diagnostics import Condition, Diagnostics, OverrunCounter
from mobile_robot_control.ros.shared.inputs import InputMonitor, InputValidator
from mobile_robot_control.ros.shared.lockstep import Outputs
from mobile_robot_control.ros.shared.modes import LockstepMode, WallClockMode
from mobile_robot_control.ros.shared.parameters import CheckedParameterService, declare
from mobile_robot_control.ros.shared.peers import PublisherWatch
from mobile_robot_control.ros.shared.qos import flush, publish_on, subscribe_to
from mobile_robot_control.ros.shared.run_events import RunEvents
from mobile_robot_control.ros.shared.stamp_policy import Input, Inputs, StampDecision
from mobile_robot_control.settings.nodes import with_options
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.topics import (
    ALL_LOOP_TOPICS,
    LOOPS,
    OTHER_INPUTS,
    OTHER_TOPICS,
    PLAIN_TWIST,
    RECORDED_TOPICS,
    LoopGraph,
)


class _NodeParameters(Protocol):
    @property
    def shared(self) -> Shared:
        """Parameters shared by all four nodes."""


NodeGroup = TypeVar('NodeGroup', bound=_NodeParameters)


class LoopNode(Node, Generic[NodeGroup]):
    """
    A node of the loop.

    A subclass connects its topics in its constructor, and calls `_start` at the end of it. The driver of its mode then
    calls `begin`, `step`, `rest` and `publish`.

    Parameters
    ----------
    name : str
        Of the node.
    group : type
        The NamedTuple that declares its parameters.
    overrides : mapping of str to object
        Values that replace the initial ones.

    Attributes
    ----------
    exit_code : int or None
        Set when the node ends by itself; None before.
    parameters : NodeGroup
        The present parameters.
    modes : mapping of bool to type
        Its mode in lockstep, and on the wall clock.

    """

    modes: Mapping[bool, type[Any]] = {True: LockstepMode, False: WallClockMode}
    exit_code: int | None = None
    _has_run = False
    _first_run_takes_changes = True
    _saturated = False

    def __init__(
        self, name: str, group: type[NodeGroup], overrides: Mapping[str, object] = MappingProxyType({})
    ) -> None:
        super().__init__(name, start_parameter_services=False)
        self._own_name = name  # whatever it is renamed to
        self._check_topics()
        self.parameters = self._changed = declare(self, group, overrides)
        self.shared = self.parameters.shared
        self._period, self.position_period = map(
            period_nanoseconds, (self.shared.velocity_rate, self.shared.position_rate))
        self.loop = self._loop_graph()
        self._driver: Any = None
        self._pace: OverrunCounter | None = None
        self._mode = self.modes[self.shared.lockstep]()
        self.robot_clock = self._mode.make_clock(self, self._forget_run_in_time)
        self.monitor = InputMonitor(
            self, self._mode.sources(self.loop.inputs_of(name)), self.shared.peer_timeout, self.robot_clock)
        self.validator = InputValidator(self, self.monitor, self.shared.peer_timeout)
        refuse_negative_time(self, self.validator.note_refusal)
        watched = {topic: self.kind(topic) for topic in self.loop.topics_of(name)} | {
            topic: '' for topic, nodes in OTHER_INPUTS.items() if name in nodes}
        self.watch = PublisherWatch(
            self, watched, self._mode.listeners(self.loop, name), self.shared.peer_timeout)
        self.events = RunEvents(self)
        self._askers: dict[str, set[bytes]] = {}
        self._outputs: list[tuple[str, Publisher[Any], Callable[[int, Any], bytes]]] = []

    def _connect(self, inputs: Mapping[str, Input], outputs: Iterable[str], rate: float) -> None:
        """Make driver, publishers and subscriptions for a rate [Hz]; the first input is the question in lockstep."""
        self._driver, self._pace = self._mode.make_driver(self, inputs, rate, self.position_period)
        for topic in outputs:
            self._outputs.append((topic, self._publish_on(topic), self._writer(topic)))
        for topic, one in inputs.items():
            self._subscribe(topic, one)

    def _writer(self, topic: str) -> Callable[[int, Any], bytes]:
        return writer(topic, self.shared)

    def _publish_on(self, topic: str) -> Publisher[Any]:
        """Make a publisher on a loop topic."""
        return publish_on(self, topic, self.kind(topic), event_callbacks=PublisherEventCallbacks(
            incompatible_qos=partial(self.watch.note_unfit, topic, 'subscription')))

    def _subscribe(self, topic: str, source: Input) -> None:
        """Subscribe to a loop topic."""
        validate, take, policy = self.validator.validate, self._driver.take_input, self._driver.policy(topic)

        def receive(message: bytes) -> None:
            valid = validate(topic, message, source.read, policy)
            if valid is not None:
                take(topic, valid)

        kind = self.kind(topic)
        subscribe_to(
            self, topic,
            stamped_on_receipt(self.validator, self._clock_stamp, receive) if kind == PLAIN_TWIST else receive,
            self._mode.quality(topic), kind, event_callbacks=SubscriptionEventCallbacks(
                incompatible_qos=partial(self.watch.note_unfit, topic, 'publisher')))

    def kind(self, topic: str) -> str:
        """Return the type of a topic's messages."""
        kind = {**RECORDED_TOPICS, **self.loop.topics}[topic].kind
        is_command = kind == LOOPS['torque'].topics['cmd_vel'].kind
        return PLAIN_TWIST if is_command and not self.shared.stamped_cmd_vel else kind

    def _start(self) -> None:
        """Start the parameter services and the diagnostics."""
        self.diagnostics = Diagnostics(
            self, self.validator, self.monitor, self.watch, self._pace, self._condition, self._running)
        CheckedParameterService(self, type(self.parameters), self._apply, self._refusals, self._mode.checks_beside)
        others = [node for node in self.loop.nodes if node != self._own_name]
        self.get_logger().info(f'waiting for {", ".join(self._mode.awaited(self.monitor.sources, others))}')

    def _check_topics(self) -> None:
        """Raise ParameterError if remapping gives two topics one name."""
        names: dict[str, list[str]] = {}
        for topic in {**ALL_LOOP_TOPICS, **OTHER_TOPICS, **OTHER_INPUTS}:
            names.setdefault(self.resolve_topic_name(topic), []).append(topic)
        violations = [f"{' and '.join(topics)} would be the same topic, '{name}'; change the remapping (-r) of one"
                         for name, topics in names.items() if len(topics) > 1]
        if violations:
            raise ParameterError(violations)

    # the interface to a driver, in the order of a run

    def note_run(self, decision: StampDecision, stamp: int = 0) -> None:
        """Log a run that begins, restarts or is joined at a stamp [ns]."""
        if decision is StampDecision.JOIN:
            self.get_logger().info(f'joined a run under way at t = {stamp / 1e9:g} s')
        else:
            self.get_logger().info('a new run begins' if self._has_run else 'a run begins')
            self.events.begin_run(self._has_run, self._has_run or self._first_run_takes_changes)
        self._has_run = True
        self._askers = {topic: self.watch.endpoints(topic) for topic, source in self.monitor.sources.items()
                        if source == 'plant'}

    def note_other_start(self, topic: str) -> None:
        """Count a question of stamp 0 that the same plant repeats with other numbers; another plant may."""
        if topic in self._askers and self._askers[topic] == self.watch.endpoints(topic):
            self.validator.note_other_numbers(topic, 0)

    def begin_run(self, inputs: Inputs, joins: bool) -> None:
        """Begin a run with the inputs of its first step, or join one under way."""

    def take_changes(self) -> None:
        """Apply live changes of parameters from the next step on."""
        self.parameters = self._changed

    def step(self, inputs: Inputs, dt: float) -> Outputs:
        """Step by a period [s]; return the outputs by topic."""
        raise NotImplementedError

    def publish(self, stamp: int, outputs: Outputs) -> None:
        """Publish outputs with a stamp [ns]."""
        for topic, publisher, write in self._outputs:
            if topic in outputs:
                message = write(stamp, outputs[topic])
                publisher.publish(message)
                self.note_sent(topic, message)

    def note_sent(self, topic: str, message: bytes) -> None:
        """Note a message that was published."""

    def note_step(self, stamp: int) -> None:
        """Note a step with a stamp [ns], and publish the changes that act from there on."""
        self.diagnostics.note_step(self._saturated)
        if self.events.pending and self.parameters is self._changed:
            self.events.publish_pending(stamp)

    # on the wall clock alone

    def receive(self, _topic: str, _stamp: int, value: object) -> Any:
        """Receive an input; return its content for the steps."""
        return value

    def is_held(self) -> bool:
        """Return whether the robot must stand, whatever the inputs are."""
        return False

    def resume(self) -> None:
        """Resume after a rest."""

    def rest(self) -> Outputs:
        """Forget states that must not outlast a rest; return the outputs that stop the robot."""
        return {}

    def note_stop(self, *topics: str) -> None:
        """Note that the robot stands because of silent inputs."""
        self.diagnostics.note_stop(*topics)

    def forget_run(self) -> None:
        """Forget the states of a run after a jump back of simulated time."""

    def _forget_run_in_time(self) -> None:
        self.get_logger().warning('/clock has jumped back: a new run begins with the next inputs')
        self.monitor.forget_inputs()
        self._driver.forget_run()

    def reached(self) -> int | None:
        """Return the newest simulated time [ns], if there is one."""
        reached: int | None = self._driver.accepted
        return reached

    def _loop_graph(self) -> LoopGraph:
        """Return the node's loop; all nodes but the plant have the same topics in each."""
        return with_options(LOOPS['torque'], self.shared)

    def _condition(self) -> Condition | None:
        """Return a condition known only to the node itself, or None."""
        return None

    def _running(self) -> str:
        """Return the state of a node that steps, in a word."""
        return 'running'

    def _last_condition(self) -> Condition:
        """Return the condition in the last diagnostics."""
        return Condition(DiagnosticStatus.OK, 'ended')

    def _refusals(self, _values: NodeGroup) -> Iterable[str]:
        """Return reasons to refuse parameters now."""
        return ()

    def _waits_for_a_run(self, _changed: Mapping[str, object]) -> bool:
        """Return whether changed parameters act from the next run on, and not from the next step."""
        return False

    def _apply(self, values: NodeGroup, changed: Mapping[str, object]) -> None:
        waits = self._waits_for_a_run(changed)
        self.events.note_changes(changed, waits)
        self._change(values, waits)

    def _change(self, values: NodeGroup, _waits: bool) -> None:
        """Apply parameters after a live change."""
        self.parameters = self._changed = values

    def read_again(self) -> None:
        """Read the files of loaded code again."""

    def _clock_stamp(self) -> int:
        """Return the present stamp of the wall clock [ns]."""
        return int(self.get_clock().now().nanoseconds)

    def close(self) -> None:
        """Stop the robot on the wall clock, publish the last messages, and wait for their arrival."""
        self._driver.close()
        self.events.flush()
        self.diagnostics.end(self._last_condition())
        reached = self.reached() if self._has_run else None
        self.get_logger().info('ended' if reached is None else f'ended at t = {reached / 1e9:g} s')
        flush(*(publisher for _, publisher, _ in self._outputs))
