"""Input validation: a node accepts messages with valid stamp and content, and counts the others by reason."""

import math
import time
from collections import Counter
from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy.node import Node

from mobile_robot_control.messages.parsing import RefusedMessageError, serialised_stamp
from mobile_robot_control.ros.inputs.input_monitor import InputMonitor
from mobile_robot_control.ros.inputs.stamp_policy import StampDecision, StampPolicy
from mobile_robot_control.ros.services.publisher_watch import publisher_names

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
        self, topic: str, message: bytes, read: Callable[[bytes], Any], policy: StampPolicy
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
        decision = policy.decide(stamp) if policy.forget() else StampDecision.REFUSED
        if decision is StampDecision.REFUSED:
            raise refusal
        del self._refused_stamps[topic]
        return decision

    def _compare(
        self, topic: str, stamp: int, message: bytes, value: Any, read: Callable[[bytes], Any], decision: StampDecision
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

    def read(self, topic: str, message: bytes, read: Callable[[bytes], Any]) -> Any:
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
