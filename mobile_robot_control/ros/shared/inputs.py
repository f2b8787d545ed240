"""Inputs of a node: valid messages and their ages; others are counted by reason."""

import math
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rclpy.node import Node

from mobile_robot_control.messages.parsing import RefusedMessageError, serialised_stamp
from mobile_robot_control.ros.shared.clock import SteadyClock
from mobile_robot_control.ros.shared.peers import publisher_names
from mobile_robot_control.ros.shared.stamp_policy import StampDecision, StampPolicy
from mobile_robot_control.ros.shared.timers import create_steady_timer

_AHEAD, _LATE = 0.01, 0.1
"""[s]: stamps further ahead, or older, show that clocks differ."""
_SECONDS = 3
"""[s] for which even the smallest age must be beyond."""


class InputMonitor:
    """
    Monitors a node's inputs: a silent one is logged once, and its return once.

    Parameters
    ----------
    node : Node
        Node with the inputs.
    sources : mapping of str to str
        Each input topic and its publisher.
    timeout : float
        Wall time of silence [s].
    clock : SteadyClock
        Of the node, for the ages of inputs.

    Attributes
    ----------
    sources : mapping of str to str
        As given.
    latencies : dict of str to float
        Configured latency of inputs that are older than their stamps show [s].

    """

    def __init__(self, node: Node, sources: Mapping[str, str], timeout: float, clock: SteadyClock) -> None:
        self.sources = sources
        self._clock, self._taken_at = clock, dict.fromkeys(sources, -math.inf)
        self._node, self._timeout = node, timeout
        self._received_at = dict.fromkeys(sources, time.monotonic())
        self._reported: set[str] = set()
        self._received: set[str] = set()
        self.latencies: dict[str, float] = {}
        self._stamp_ages: dict[str, float] = dict.fromkeys(sources, 0.0)
        self._least: deque[dict[str, float]] = deque([{}], maxlen=_SECONDS + 1)
        self._ill_timed: dict[str, str] = {}
        create_steady_timer(min(0.5, timeout), self._report_silent, node)

    def note_input(self, topic: str, stamp_age: float) -> None:
        """Note an accepted message on a topic, and the age of its stamp [s]."""
        self._stamp_ages[topic] = stamp_age
        least = self._least[-1]
        if stamp_age < least.get(topic, math.inf):
            least[topic] = stamp_age
        clock = self._clock
        self._taken_at[topic] = now = clock.now()
        self._received_at[topic] = time.monotonic() if clock.is_simulated else now
        self._received.add(topic)
        if topic in self._reported:
            self._reported.remove(topic)
            self._node.get_logger().info(f'{topic} is back')

    def age(self, topic: str) -> float:
        """Return the robot's time since the newest message of a topic [s]; infinite before the first of a run."""
        return self._clock.now() - self._taken_at.get(topic, -math.inf)

    def stamp_age(self, topic: str) -> float:
        """Return the age of the newest stamp of a topic [s]."""
        return self.age(topic) + self._stamp_ages[topic]

    def note_second(self) -> None:
        """Begin another second, and find stamps that none of the last messages explains."""
        if len(self._least) > _SECONDS:
            self._find_ill_timed()
        self._least.append({})

    def _find_ill_timed(self) -> None:
        ill_timed: dict[str, str] = {}
        for topic in self.sources:
            least = min((one[topic] for one in self._least if topic in one), default=0.0)
            latency = self.latencies.get(topic, 0.0)
            if least < -_AHEAD and not self._clock.is_simulated:
                ill_timed[topic] = (f'{topic} is stamped {-least:.2f} s in the future: the clocks of two computers '
                                    'differ, or its publisher stamps ahead; let chrony or NTP set both clocks')
            elif least > latency + _LATE:
                ill_timed[topic] = (f'{topic} is {least:.2f} s old or more when it comes, and {latency:g} s are '
                                    'configured: the clocks of two computers differ, or its transport takes so long; '
                                    'let chrony or NTP set both clocks, or find the cause of the delay')
        for topic, text in ill_timed.items():
            if topic not in self._ill_timed:
                self._node.get_logger().warning(text)
        self._ill_timed = ill_timed

    def problems(self) -> list[str]:
        """List problems of time and stamps, in words."""
        return [*self._clock.problems(), *self._ill_timed.values()]

    def forget_inputs(self) -> None:
        """Forget the inputs of the previous run."""
        self._taken_at = dict.fromkeys(self.sources, -math.inf)

    def missing_inputs(self) -> list[str]:
        """List the nodes without any message, or without one for the timeout."""
        return list(dict.fromkeys(source for topic, source in self.sources.items()
                                  if topic not in self._received or self._is_silent(topic)))

    def _is_silent(self, topic: str) -> bool:
        return time.monotonic() - self._received_at[topic] > self._timeout

    def _report_silent(self) -> None:
        for topic, source in self.sources.items():
            if topic not in self._reported and self._is_silent(topic):
                self._reported.add(topic)
                self._node.get_logger().warning(
                    f'no {topic} for {self._timeout} s: is {source} running, on the same clock as this node?'
                )


_WARN_EVERY = 2.0
"""[s]"""
_KEPT = 8
"""Messages of each topic, stored for comparison with later ones of the same stamp."""


class ValidInput(NamedTuple):
    """
    An accepted message.

    Attributes
    ----------
    stamp : int
        [ns].
    decision : StampDecision
        Meaning of the stamp.
    value : object
        The message's content.

    """

    stamp: int
    decision: StampDecision
    value: Any


class InputValidator:
    """
    Accepts messages with valid stamp and content; counts the others by reason, and warns about each, throttled.

    Parameters
    ----------
    node : Node
        Node with the inputs.
    monitor : InputMonitor
        Receives accepted messages; a refused one changes nothing, no timeout either.
    patience : float
        Wall time without an accepted message after which a repeated stamp is joined, in lockstep [s].

    Attributes
    ----------
    refused : Counter of str
        Number of refused messages by 'topic: reason'.

    """

    def __init__(self, node: Node, monitor: InputMonitor, patience: float) -> None:
        self._node, self._monitor, self._patience = node, monitor, patience
        self._taken: dict[str, dict[int, bytes]] = {}
        self._refused_stamps: dict[str, tuple[int, float]] = {}
        self.refused: Counter[str] = Counter()
        self._warned_at: dict[str, float] = {}
        self._newest: dict[str, tuple[float, str]] = {}

    def validate(
        self, topic: str, message: bytes, read: Callable[[bytes], object], policy: StampPolicy
    ) -> ValidInput | None:
        """
        Accept or refuse a message.

        Parameters
        ----------
        topic : str
            Topic of the message.
        message : bytes
            Serialised, with a header.
        read : callable
            Of `conversions.reader`.
        policy : StampPolicy
            Decides about its stamp.

        Returns
        -------
        ValidInput or None
            None for a refused message.

        """
        try:
            stamp = serialised_stamp(message)
            decision = policy.decide(stamp)
            if decision is StampDecision.REFUSED and not self._asked_again(topic, stamp):
                raise policy.refusal(stamp)
            value = read(message)
            if decision is StampDecision.REFUSED:
                decision = self._joined(topic, stamp, policy)
            if decision is not StampDecision.HOLD:
                self._compare(topic, stamp, message, value, read, decision)
        except RefusedMessageError as refusal:
            self.note_refusal(topic, refusal)
            return None
        self._monitor.note_input(topic, policy.age(stamp))
        return ValidInput(stamp, decision, value)

    def _asked_again(self, topic: str, stamp: int) -> bool:
        """Return whether the only publisher repeats a refused stamp, with no message accepted since."""
        # another plant on the same topics may have pulled this node out of its run, and ended
        now = time.monotonic()
        refused, since = self._refused_stamps.get(topic, (stamp, now))
        self._refused_stamps[topic] = stamp, since if refused == stamp else now
        waited = refused == stamp and now - since > self._patience and self._monitor.age(topic) > self._patience
        return waited and self._node.count_publishers(self._node.resolve_topic_name(topic)) == 1

    def _joined(self, topic: str, stamp: int, policy: StampPolicy) -> StampDecision:
        """Leave the policy's run; return the new meaning of a refused stamp, or raise its refusal."""
        # when a plant repeats a refused stamp, a run other than the node's own is under way
        refusal = policy.refusal(stamp)
        decision = policy.decide(stamp) if policy.leave_run() else StampDecision.REFUSED
        if decision is StampDecision.REFUSED:
            raise refusal
        del self._refused_stamps[topic]
        return decision

    def _compare(
        self, topic: str, stamp: int, message: bytes, value: object, read: Callable[[bytes], object],
        decision: StampDecision,
    ) -> None:
        """Count a message that differs from the first of its stamp; stamp 0 may be of another run."""
        # it is not refused: a restarted node may answer differently, and the run must continue
        taken = self._taken.setdefault(topic, {})
        if stamp == 0 or decision is StampDecision.JOIN:
            taken.clear()
        first = taken.setdefault(stamp, message)
        if len(taken) > _KEPT:
            del taken[next(iter(taken))]
        if stamp and first != message and read(first) != value:
            self.note_other_numbers(topic, stamp)

    def note_other_numbers(self, topic: str, stamp: int) -> None:
        """Count a message that differs from the first of its stamp [ns], and name its publishers."""
        names = publisher_names(self._node, self._node.resolve_topic_name(topic))
        self.note_refusal(topic, RefusedMessageError(
            'other numbers for a stamp', f'stamp {stamp / 1e9} s, which was taken before, published by {names}: there '
            'is a second publisher, or one that does not repeat its message byte by byte (docs/lockstep.md)'))

    def read(self, topic: str, message: bytes, read: Callable[[bytes], object]) -> Any:
        """Return the content of a message without a stamp; None for a refused message."""
        try:
            return read(message)
        except RefusedMessageError as refusal:
            self.note_refusal(topic, refusal)
            return None

    def note_refusal(self, topic: str, refusal: RefusedMessageError, every: float = _WARN_EVERY) -> None:
        """Count a refusal, and warn at most once in some time [s] for each topic and reason."""
        reason = f'{topic}: {refusal.reason}'
        self.refused[reason] += 1
        now = time.monotonic()
        self._newest[topic] = now, f'refused a message on {topic}: {refusal}'
        if now - self._warned_at.get(reason, -math.inf) >= every:
            self._warned_at[reason] = now
            self._node.get_logger().warning(self._newest[topic][1])

    def newest(self) -> list[str]:
        """List the newest refusal on each topic, as far as it is of the last moment, in words."""
        now = time.monotonic()
        return [text for at, text in self._newest.values() if now - at < _WARN_EVERY]
