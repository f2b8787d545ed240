"""The graph as the page sees it: topics sampled 20 times a second, and the state of each node in words."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from collections.abc import Iterable
from functools import partial
from typing import Any, NamedTuple

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from mobile_robot_control.dashboard.sampling import Sampler
from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, read_or_refuse
from mobile_robot_control.messages.writing import message_class
from mobile_robot_control.ros.shared.qos import LATCHED
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import LOOP_TOPICS, PLAIN_TWIST, SHOWN_TOPICS

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
                message = self._subscription.handle.take_message(self._subscription.msg_type, self._subscription.raw)
            if message is None:
                break
            taken.append(message[0])
            self._count(message[1])
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


_COMMAND = 'cmd_vel'
_DEPTHS = {'position_rate': 8, 'velocity_rate': 32}
"""Messages stored between two samples, enough to find one stamp in all topics during a run."""


class LoopTopics:
    """
    Subscribes to the loop's topics, only while a page is open.

    Each message costs its publisher and this process some microseconds, which a run as fast as possible cannot spare.

    Parameters
    ----------
    node : Node
        Node of the subscriptions.

    Attributes
    ----------
    polled : dict of str to PolledTopic
        By relative name; empty while there is no subscription.
    sampler : Sampler
        Makes rows of their messages.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.polled: dict[str, PolledTopic] = {}
        self.sampler = Sampler()

    def subscribe(self) -> None:
        """Subscribe, and begin a new row; existing subscriptions stay."""
        if not self.polled:
            self.sampler = Sampler()
            self.polled = {name: PolledTopic(self._node, name, topic.kind, _DEPTHS[topic.rate])
                           for name, topic in SHOWN_TOPICS.items()}

    def unsubscribe(self) -> None:
        """End all subscriptions."""
        for topic in self.polled.values():
            topic.close()
        self.polled = {}

    def look(self) -> None:
        """Read the newest messages of each, and fill the row from those of one stamp."""
        for name, topic in self.polled.items():
            self.sampler.take(name, topic.kind, topic.take())
        self.sampler.fill()

    def follow_type(self) -> None:
        """Subscribe to commands of the published type: some bases take only plain ones."""
        if not self.polled:
            return
        command = self.polled[_COMMAND]
        kinds = {offer.topic_type for offer in self._node.get_publishers_info_by_topic(command.name)}
        if kinds and command.kind not in kinds and kinds <= {LOOP_TOPICS[_COMMAND].kind, PLAIN_TWIST}:
            command.close()
            self.polled[_COMMAND] = PolledTopic(self._node, _COMMAND, kinds.pop(), _DEPTHS['position_rate'])

    def published(self) -> list[str]:
        """List the published topics by absolute name."""
        names = map(self._node.resolve_topic_name, LOOP_TOPICS)
        return [name for name in names if self._node.count_publishers(name)]


_KIND = 'diagnostic_msgs/msg/DiagnosticArray'
_GOOD = ('running', 'standing', 'arrived', 'paused')
_SILENT = 3.0
"""[s] of wall time without a report before a node counts as silent."""
_MOST = 60
"""Most stored nodes."""


class _Report(NamedTuple):
    """The newest report of a node: time of receipt [s], text, refusals by topic and reason, plans without a change."""

    came: float
    text: str
    refused: int
    reasons: dict[str, int]
    unchanged: int


class NodeStates:
    """The newest report of each node."""

    def __init__(self) -> None:
        self._reports: dict[str, _Report] = {}

    def take(self, message: bytes) -> None:
        """Receive a message; an unreadable one changes nothing."""
        try:
            array = read_or_refuse(_KIND, (partial(deserialise, _KIND),), message)
        except RefusedMessageError:
            return
        for status in array.status[:20]:
            values = {entry.key: entry.value for entry in status.values[:200]}
            name = '/' + shortened(status.name, 200)
            if len(self._reports) >= _MOST and name not in self._reports:
                self._reports.pop(min(self._reports, key=lambda known: self._reports[known].came))
            self._reports[name] = _Report(
                time.monotonic(), shortened(status.message), _count(values.get('refused', '0')),
                {shortened(key.removeprefix('refused '), 120): _count(value) for key, value in values.items()
                 if key.startswith('refused ')}, _count(values.get('plans unchanged', '0')))

    def of(self, names: Iterable[str]) -> list[dict[str, Any]]:
        """Return the states of nodes by their full names, ready for JSON."""
        return [self._of(name) for name in names]

    def _of(self, name: str) -> dict[str, Any]:
        report = self._reports.get(name)
        if report is None:
            return {'name': name, 'text': 'no report yet', 'good': False, 'refused': 0, 'reasons': {},
                    'unchanged': 0}
        silent = time.monotonic() - report.came
        ended = report.text == 'ended'
        words = report.text if silent < _SILENT or ended else (
            f'silent for {silent:.0f} s; the last report was: {report.text}')
        return {'name': name, 'text': words, 'good': silent < _SILENT and report.text in _GOOD,
                'refused': report.refused, 'reasons': report.reasons, 'unchanged': report.unchanged}


def _count(digits: str) -> int:
    """Return a count of a report; 0 for another text."""
    return int(digits) if digits.isdecimal() and len(digits) < 16 else 0
