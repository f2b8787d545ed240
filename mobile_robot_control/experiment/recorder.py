"""The recorder: it receives every topic of its namespace as serialised messages."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future

from mobile_robot_control.experiment.conduct import Conduct
from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, read_or_refuse, serialised_stamp
from mobile_robot_control.messages.types import DiagnosticArray
from mobile_robot_control.messages.writing import message_class
from mobile_robot_control.ros.shared.diagnostics import LAW_FAILED, SUBSCRIBERS_KEY
from mobile_robot_control.ros.shared.peers import publisher_names
from mobile_robot_control.ros.shared.qos import PUBLISHED, QUIET
from mobile_robot_control.ros.shared.timers import create_steady_timer
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import EVENTS, MEASURED_TOPICS, SHARED_TOPICS, LoopGraph, Topic, required

_DEPTH = 5000
AHEAD = PUBLISHED.depth // 4
"""Steps by which a lockstep run may lead its recording."""
_TURNS = 10
"""Without a message, after which none is waiting."""
NO_LIMIT = 1 << 62
"""[ns]"""
_DIAGNOSTICS = 'diagnostic_msgs/msg/DiagnosticArray'
Sink = Callable[[str, str, int, bytes, bool], None]


class Recorder(Node):
    """
    Hands every message of its namespace, and of the topics that all namespaces share, to a sink.

    Parameters
    ----------
    namespace : str
        Namespace to record.
    sink : callable
        Takes topic, type, wall time of receipt [ns], CDR, and whether the topic is latched.
    is_known : callable
        Returns whether the sink accepts a type.
    loop : LoopGraph
        Loop with the topics to record.
    conduct : mapping of str to Conduct
        Judges the topics of nodes of somebody else, by name; what those publish for recordings alone may be missing.
    attached : collection of str
        Nodes that run already.

    Attributes
    ----------
    newest : dict of str to int
        Stamp [ns] of the newest message on each topic of the loop or of its recordings, by relative name.
    law_failure : str
        A controller's report of a failed law; '' before.
    fault : str
        What a node of somebody else has done, with its name; '' before.
    received : int
        Wall time [ns] of the last message of a loop topic.
    limit : int
        Stamp [ns] at which a lockstep run must hold, however far it is recorded.
    first, last : int
        First and last stamp [ns] of recorded messages of the loop topics.

    """

    def __init__(
        self, namespace: str, sink: Sink, is_known: Callable[[str], bool], loop: LoopGraph,
        conduct: Mapping[str, Conduct] | None = None, attached: Collection[str] = (),
    ) -> None:
        super().__init__('recorder', namespace=namespace, enable_rosout=False)
        self._sink, self._is_known = sink, is_known
        self._recorded: dict[str, Any] = {}
        self._subscribers: dict[str, int] = {}
        self.newest: dict[str, int] = {}
        self.law_failure = self.fault = ''
        self._conduct, self._attached = conduct or {}, attached
        self._foreign = {loop.topics[name].publisher for name in self._conduct}
        self._counts: Counter[str] = Counter()
        self._asked_by = {answer: question for question, answer in loop.answers}
        self._controllers = {f'{self.get_namespace().rstrip("/")}/{name}'.lstrip('/'): name for name in (
            'position_controller', 'velocity_controller')}
        self.received = 0
        self.limit = self.last = NO_LIMIT
        self.first = -NO_LIMIT
        self._path, self._has_path = self.resolve_topic_name('reference_path'), False
        self._ahead = self._allowed = 0
        self._plant: Any = self.create_client(SetParameters, 'plant/set_parameters')
        self._told: Any = None
        if 'plant' in self._foreign:
            self._told = self.create_client(GetParameters, 'plant/get_parameters')
        self._graph = required(loop, self._foreign)
        self._ours = [node for node in loop.nodes if node not in self._foreign]
        self._loop, recorded = ({self.resolve_topic_name(name): topic for name, topic in topics.items()}
                                for topics in (loop.topics, loop.recorded))
        self._stamped = {**self._loop, **recorded}
        for resolved, topic in self._stamped.items():
            self._record(resolved, topic.kind, latched=False)
        self._record(self.resolve_topic_name(EVENTS), _DIAGNOSTICS, latched=True)
        self._record('/clock', 'rosgraph_msgs/msg/Clock', latched=False)
        self._record('/diagnostics', _DIAGNOSTICS, latched=False)
        create_steady_timer(0.25, self._discover, self)

    def topics_of_others(self, ours: int = 0) -> list[str]:
        """List the loop topics, by absolute name, with more publishers than ours and an attached node."""
        return [resolved for resolved, topic in self._loop.items()
                if self.count_publishers(resolved) > max(ours, topic.publisher in self._attached)]

    def all_discovered(self, but: str = '') -> bool:
        """
        Return whether every node but one has found its subscribers, by its own diagnostics.

        One of somebody else need not tell: it counts as soon as it is discovered.
        """
        needed = [(self.resolve_topic_name(name), topic) for name, topic in self._graph.topics.items()
                  if topic.publisher != but]
        return all(self.count_publishers(resolved) if topic.publisher in self._foreign else
                   self._subscribers.get(resolved, 0) > len({*topic.subscribers} & {*self._ours} - {but})
                   for resolved, topic in needed)

    def hears(self, node: str) -> bool:
        """Return whether every topic of a node, of those that others wait for, has had a message."""
        return all(name in self.newest for name, topic in self._graph.topics.items() if topic.publisher == node)

    def hears_optional(self) -> bool:
        """Return whether every topic of the loop that has a publisher has had a message."""
        return all(topic.name in self.newest or not self.count_publishers(resolved)
                   for resolved, topic in self._loop.items())

    def serves_parameters(self) -> bool:
        """Return whether a plant of somebody else serves its parameters, as nodes of rclcpp and rclpy do."""
        return bool(self._told.service_is_ready())

    def description(self, node: str) -> str:
        """Describe what has come from a node of somebody else."""
        return '; '.join(
            self._conduct[name].refusal or self._conduct[name].jump or (
                f'its newest {name} has the stamp {self.newest[name] / 1e9:.9g} s' if name in self.newest else
                f'{name} has no message' if self.count_publishers(self.resolve_topic_name(name)) else
                f'{name} has no publisher')
            for name, topic in self._graph.topics.items() if topic.publisher == node)

    def ahead(self) -> str:
        """Return the node of somebody else whose last message is not the next one; '' without one."""
        return next((self._loop[self.resolve_topic_name(name)].publisher
                     for name, conduct in self._conduct.items() if conduct.jump or conduct.refusal), '')

    def publishers(self, topic: str) -> str:
        """Return the names of a topic's publishers."""
        return publisher_names(self, topic)

    def ask_for_flow_control(self) -> Future[Any]:
        """Ask a plant of somebody else for `paused` and `hold_at`."""
        answer: Future[Any] = self._told.call_async(GetParameters.Request(names=['paused', 'hold_at']))
        return answer

    def has_every_topic(self) -> bool:
        """Return whether every loop topic has had a message, so that no more will be missed."""
        return set(self.newest) >= set(self._graph.topics)

    def is_complete(self) -> bool:
        """Return whether every loop topic that has had a message is recorded up to `last`."""
        return all(newest >= self.last for newest in self.newest.values())

    def drain(
        self, turn: Callable[[], object], silence: float, seconds: float, done: Callable[[], bool] = lambda: False
    ) -> None:
        """
        Take messages that have arrived and are not recorded yet.

        Parameters
        ----------
        turn : callable
            Spins once.
        silence : float
            It ends when no message of a loop topic comes for so long [s], and in several turns: a process that has not
            run has not looked.
        seconds : float
            It ends at the latest after this time [s]: another robot on the same topics never falls silent.
        done : callable
            It ends as soon as this holds.

        """
        deadline = time.monotonic() + seconds
        last, turns = time.monotonic(), 0
        while ((turns < _TURNS or time.monotonic() < last + silence) and time.monotonic() < deadline
               and not done()):
            received = self.received
            turn()
            turns += 1
            if self.received != received:
                last, turns = time.monotonic(), 0

    def has_every_node(self) -> bool:
        """
        Return whether, in addition, the cart's path has come, and the diagnostics of all nodes are discovered.

        A short run would end before; diagnostics may report a failed law.
        """
        return (self.has_every_topic() and (self._has_path or 'reference_cart' in self._foreign)
                and self.count_publishers('/diagnostics') >= len(self._ours))

    def resume(self, period: int = 0) -> Future[Any]:
        """
        Ask a paused plant to resume. A plant that is not discovered yet does not receive it: ask until it answers.

        Parameters
        ----------
        period : int
            Of the velocity grid [ns], in lockstep: from now on the plant holds when publishers could no longer store
            the messages that this recorder still has to take. 0 lets it run unconditionally, like the wall clock.

        Returns
        -------
        Future
            Done when the plant has accepted.

        """
        self._ahead = AHEAD * period
        self.note_whole()
        return self._set_on_plant(paused=False)

    def note_whole(self) -> None:
        """Note that from now on every message arrives here."""
        for conduct in self._conduct.values():
            conduct.is_whole = True

    def pause(self) -> Future[Any]:
        """Ask the plant to pause."""
        return self._set_on_plant(paused=True)

    def _farthest(self) -> int:
        """Return the stamp [ns] up to which the plant may run."""
        return min(self._complete_until() + self._ahead, self.limit)

    def _set_on_plant(self, **values: float) -> Future[Any]:
        if self._ahead:
            self._allowed = self._farthest()
            values['hold_at'] = self._allowed / 1e9
        answer: Future[Any] = self._plant.call_async(SetParameters.Request(
            parameters=[Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        ))
        return answer

    def _complete_until(self) -> int:
        """Return the stamp [ns] up to which every velocity tick and the answers to the plant are recorded."""
        return min(self.newest.get(topic, 0) for topic in (self._graph.clock, self._graph.command))

    def _discover(self) -> None:
        """Subscribe to every topic of the namespace, and to those that all namespaces share."""
        prefix = self.get_namespace().rstrip('/') + '/'
        self._take_best_effort()
        self._find_unfit()
        for topic, kinds in self.get_topic_names_and_types():
            if topic in self._recorded or not (topic.startswith(prefix) or topic in SHARED_TOPICS):
                continue
            offers = self.get_publishers_info_by_topic(topic)
            if not offers:
                continue
            latched = all(offer.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in offers)
            reliable = all(offer.qos_profile.reliability == ReliabilityPolicy.RELIABLE for offer in offers)
            self._recorded[topic] = None
            if not self._is_known(kinds[0]):
                self.get_logger().warning(f'{topic} is not recorded: its type {kinds[0]} is not a common one')
                continue
            try:
                self._record(topic, kinds[0], latched, reliable)
            except Exception as error:  # a package that is not installed, a name that rcl refuses
                self.get_logger().warning(f'{topic} is not recorded: {shortened(str(error))}')

    def _find_unfit(self) -> None:
        """Note an endpoint of somebody else's that DDS does not connect with those of the other nodes."""
        for resolved, topic in self._loop.items():
            if topic.name not in self._conduct or not topic.subscribers:
                continue
            for offer in self.get_publishers_info_by_topic(resolved):
                if '_UNKNOWN_' in offer.topic_type:
                    continue
                if offer.topic_type != topic.kind:
                    self._blame(topic, f'{topic.name} is of the type {offer.topic_type}, and not {topic.kind}')
                elif (offer.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
                      and self._conduct[topic.name].needs_reliable):
                    self._blame(topic, f'{topic.name} is published as best effort; make it reliable and volatile')

    def _blame(self, topic: Topic, fault: str) -> None:
        self.fault = self.fault or f'{topic.publisher}: {shortened(fault)}'

    def _judge(self, topic: Topic, stamp: int, message: bytes, now: int) -> bool:
        """Judge a message of somebody else's node; return whether it can be used."""
        conduct = self._conduct[topic.name]
        fault = conduct.take(stamp, message, now)
        question = self._asked_by.get(topic.name)
        if question and conduct.is_whole and self._ahead and not fault:
            answers, questions = self._counts[topic.name], self._counts[question]
            if answers > questions + self._ahead // conduct.period:
                fault = f'{topic.name} has {answers} messages, and {questions} were asked for on {question}'
        if fault:
            self._blame(topic, fault)
        return not conduct.refusal

    def _take_best_effort(self) -> None:
        """Subscribe again to measurements of a robot, if its driver publishes them as best effort."""
        for topic, of_loop in self._loop.items():
            if of_loop.name in MEASURED_TOPICS and (
                    self._recorded[topic].qos_profile.reliability == ReliabilityPolicy.RELIABLE) and any(
                    offer.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
                    for offer in self.get_publishers_info_by_topic(topic)):
                self.destroy_subscription(self._recorded[topic])
                self._record(topic, of_loop.kind, latched=False, reliable=False)

    def _note_diagnostics(self, message: bytes) -> None:
        """Note the diagnostics of a node; others may publish anything on the topic."""
        with suppress(RefusedMessageError):
            self._subscribers.update(read_or_refuse(
                _DIAGNOSTICS, (partial(deserialise, _DIAGNOSTICS), self._read_diagnostics), message))

    def _read_diagnostics(self, diagnostics: DiagnosticArray) -> dict[str, int]:
        """Return the number of discovered subscriptions of each loop topic, by its publisher; note a failed law."""
        for status in diagnostics.status:
            if status.name in self._controllers and status.message.startswith(LAW_FAILED):
                self.law_failure = self.law_failure or f'{self._controllers[status.name]}: {shortened(status.message)}'
        counts = {entry.key.removeprefix(SUBSCRIBERS_KEY): int(entry.value)
                  for status in diagnostics.status for entry in status.values if entry.key.startswith(SUBSCRIBERS_KEY)}
        return {topic: count for topic, count in counts.items() if topic in self._loop}

    def _record(self, topic: str, kind: str, latched: bool, reliable: bool = True) -> None:
        of_loop = self._stamped.get(topic)

        def take(message: bytes) -> None:
            now = time.time_ns()
            stamp = self.first
            if of_loop is not None:
                self.received = now
                with suppress(RefusedMessageError):
                    stamp = serialised_stamp(message)
                    self._counts[of_loop.name] += 1
                    if of_loop.name not in self._conduct or self._judge(of_loop, stamp, message, now):
                        self.newest[of_loop.name] = stamp
                # later in the run, or after a reset has begun a new one
                if (self._ahead and not self._ahead // 2 <= self._allowed - self._complete_until() <= self._ahead
                        and self._farthest() != self._allowed):
                    self._set_on_plant()
            elif topic == '/diagnostics':
                self._note_diagnostics(message)
            elif topic == self._path:
                self._has_path = True
            if self.first <= stamp <= self.last:
                self._sink(topic, kind, now, message, latched)

        quality = QoSProfile(
            depth=_DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        # an event that waits when `_take_best_effort` destroys its subscription makes rclpy raise InvalidHandle
        self._recorded[topic] = self.create_subscription(
            message_class(kind), topic, take, quality, raw=True, event_callbacks=QUIET)
