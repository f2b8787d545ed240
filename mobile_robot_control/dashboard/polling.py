"""Topics sampled 20 times a second, at any rate: the newest message of each, and the number of messages."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from mobile_robot_control.ros.services.qos import LATCHED, message_class

_WINDOW = 2.0
"""[s] of wall time over which a rate is measured."""
_DRAINED = 64
"""Most messages read at once."""


class PolledTopic:
    """
    A subscription without an executor: messages between samples wake nothing up.

    Parameters
    ----------
    node : Node
        Node of the subscription; it must not be added to an executor.
    name, kind : str
        Topic and type.
    depth : int
        Messages stored between two samples.
    latched : bool
        Whether to receive the last message of publishers that keep it.
    reliable : bool
        Whether lost messages are sent again; where the next one replaces them, they need not be.

    Attributes
    ----------
    newest : bytes or None
        Bytes of the newest message.
    total : int
        Messages published since the first received one, by their sequence numbers.
    rate : float
        Messages in a second of wall time.

    """

    def __init__(self, node: Node, name: str, kind: str, depth: int = 1, latched: bool = False,
                 reliable: bool = False) -> None:
        self.kind, self.total, self.rate = kind, 0, 0.0
        self.name = node.resolve_topic_name(name)
        self._node = node
        self._sequences: dict[bytes, int] = {}
        self._begun, self._counted = time.monotonic(), 0
        self._subscription: Any = node.create_subscription(
            message_class(kind), name, self._unused, LATCHED if latched else QoSProfile(
                depth=depth, reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT),
            raw=True)
        self.newest: bytes | None = None

    @staticmethod
    def _unused(_: bytes) -> None:
        """Take the place of the callback; no executor calls it."""

    def take(self) -> list[bytes]:
        """Return the messages since the last sample, the newest last."""
        taken: list[bytes] = []
        while len(taken) < _DRAINED:
            # in the way of rclpy's executors; there is no public one
            with self._subscription.handle:
                found = self._subscription.handle.take_message(self._subscription.msg_type, self._subscription.raw)
            if found is None:
                break
            taken.append(found[0])
            self._count(found[1])
        if taken:
            self.newest = taken[-1]
        self._measure()
        return taken

    def _count(self, information: Any) -> None:
        """Count a message and those before it that were replaced unseen."""
        number, publisher = None, b''
        if isinstance(information, dict):
            number = information.get('publication_sequence_number')
            publisher = bytes((information.get('publisher_gid') or {}).get('data') or b'')
        before = self._sequences.get(publisher)
        if number is None or before is None or number <= before:
            self.total += 1
        else:
            self.total += number - before
        if number is not None:
            # publishers come and go; a graph has a few
            if len(self._sequences) > 50:
                self._sequences.clear()
            self._sequences[publisher] = number

    def _measure(self) -> None:
        now = time.monotonic()
        if now - self._begun >= _WINDOW:
            self.rate = (self.total - self._counted) / (now - self._begun)
            self._begun, self._counted = now, self.total

    def close(self) -> None:
        """End the subscription."""
        self._node.destroy_subscription(self._subscription)
