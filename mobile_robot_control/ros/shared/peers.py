"""The other nodes: several publishers, unlike endpoints, missing subscriptions, and the node that blocks a run."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

from rclpy.node import Node
from rclpy.qos import qos_policy_name_from_kind
from rclpy.subscription import Subscription

from mobile_robot_control.messages.parsing import RefusedMessageError, serialised_stamp
from mobile_robot_control.ros.shared.qos import subscribe_to
from mobile_robot_control.topics import LoopGraph, first_silent

_PARTICIPANT = 12
"""Bytes of an endpoint's GUID that identify its process."""
_COMMANDS = ('cmd_vel', 'wheel_torques')
"""Topics without which a robot stands."""
_REMEDY = 'stop all but one, or give each robot a namespace or a ROS_DOMAIN_ID of its own'


class PublisherWatch:
    """
    Counts the publishers of topics that should have one, and notes incompatible endpoints.

    Parameters
    ----------
    node : Node
        Node with the inputs and outputs.
    topics : mapping of str to str
        Type of each input and output, by relative name; '' if it does not matter.
    listeners : mapping of str to mapping of str to sequence of str
        By topic of the node, the nodes that need it, each with the topics that it publishes.
    patience : float
        Wall time [s] for which a node may be known without being a listener.

    Attributes
    ----------
    several : dict of str to str
        All publishers of a topic with more than one at the last look, joined by ' and '.
    unfit : dict of str to str
        The incompatible quality of service of other endpoints, by topic.

    """

    def __init__(
        self, node: Node, topics: Mapping[str, str], listeners: Mapping[str, Mapping[str, Sequence[str]]],
        patience: float,
    ) -> None:
        self._node, self._patience = node, patience
        # the receiver of a remapped output is unknown here
        self._listeners = {topic: nodes for topic, nodes in listeners.items()
                           if node.resolve_topic_name(topic).endswith(f'/{topic}')}
        self._topics = {topic: node.resolve_topic_name(topic) for topic in topics}
        self._kinds = {topic: kind for topic, kind in topics.items() if kind}
        self._unconnected: dict[str, int] = {}
        self._deaf_since: dict[str, float] = {}
        self.several: dict[str, str] = {}
        self.unfit: dict[str, str] = {}

    def publishers(self, topic: str) -> int:
        """Return the present number of discovered publishers of a topic."""
        return int(self._node.count_publishers(self._topics[topic]))

    def endpoints(self, topic: str) -> set[bytes]:
        """Return the publishers of a topic as DDS identifies them: a restarted node has others."""
        return {bytes(info.endpoint_gid) for info in self._node.get_publishers_info_by_topic(self._topics[topic])}

    def look(self) -> None:
        """Count publishers; log those of a topic once when it gets several."""
        several = {topic: publisher_names(self._node, resolved) for topic, resolved in self._topics.items()
                   if self._node.count_publishers(resolved) > 1}
        # the name of a node is discovered after its publishers
        several = {topic: names for topic, names in several.items() if '_UNKNOWN_' not in names}
        for topic, names in several.items():
            if topic not in self.several:
                self._node.get_logger().warning(f'{topic} has several publishers: {names}; {_REMEDY}')
        for topic in self.several:
            if topic not in several:
                self._node.get_logger().info(f'{topic} has one publisher again')
        self.several = several
        self._unconnected = {text: self._unconnected.get(text, 0) + 1 for text in self._find_unconnected()}
        for text, looks in self._unconnected.items():
            if looks == 2:  # not while a peer is discovered
                self._node.get_logger().warning(text)
        deaf, now = set(self._deaf()), time.monotonic()
        self._deaf_since = {text: self._deaf_since.get(text, now) for text in deaf}

    def _find_unconnected(self) -> Iterator[str]:
        """Yield endpoints of another type, which DDS does not connect, and commands that no node takes."""
        for topic, kind in self._kinds.items():
            resolved = self._topics[topic]
            publishes = any(publisher.topic_name == resolved for publisher in self._node.publishers)
            peers = (self._node.get_subscriptions_info_by_topic(resolved) if publishes
                     else self._node.get_publishers_info_by_topic(resolved))
            does, do = ('takes', 'publishes') if publishes else ('publishes', 'takes')
            for info in peers:
                if info.topic_type != kind and '_UNKNOWN_' not in info.node_name:
                    yield (f'{_full_name(info)} {does} {resolved} as {_short(info.topic_type)}, and this node {do} '
                           f'{_short(kind)}{_remedy(topic, kind)}')
            if publishes and topic in _COMMANDS and kind not in {info.topic_type for info in peers}:
                yield f'no node takes {resolved}: nothing moves the robot'

    def _deaf(self) -> Iterator[str]:
        """Yield the nodes that are discovered, but not as listeners of this one."""
        # Fast DDS may discover only half of a process that was suspended for longer than its lease
        for topic, nodes in self._listeners.items():
            listening = _participants(self._node.get_subscriptions_info_by_topic(self._node.resolve_topic_name(topic)))
            for node, published in nodes.items():
                publishing: set[bytes] = set().union(*(
                    _participants(self._node.get_publishers_info_by_topic(self._node.resolve_topic_name(other)))
                    for other in published))
                if publishing and not publishing & listening:
                    yield f'{node} is discovered, but not as a listener of {topic}: start this node again'

    def note_unfit(self, topic: str, whose: str, event: Any) -> None:
        """
        Note an endpoint of another node with an incompatible quality of service, which DDS does not connect.

        Parameters
        ----------
        topic : str
            By relative name.
        whose : str
            'publisher' or 'subscription'.
        event : object
            Of rclpy: QoSRequestedIncompatibleQoSInfo or QoSOfferedIncompatibleQoSInfo.

        """
        policy = qos_policy_name_from_kind(event.last_policy_kind).lower()
        ours = 'subscription' if whose == 'publisher' else 'publisher'
        warning = (f'a {whose} on {topic} is not connected: its {policy} does not fit the {ours} of this node; make '
                   'both reliable and volatile')
        if self.unfit.get(topic) != warning:
            self.unfit[topic] = warning
            self._node.get_logger().warning(warning)

    def problems(self) -> list[str]:
        """List the problems, in words."""
        deaf = [text for text, since in self._deaf_since.items() if time.monotonic() - since > self._patience]
        return [*(f'{topic} has several publishers ({names})' for topic, names in self.several.items()),
                *self._unconnected, *self.unfit.values(), *deaf]


def publisher_names(node: Node, resolved: str) -> str:
    """Return the full names of a topic's publishers, by its resolved name, joined by ' and '."""
    return ' and '.join(sorted(map(_full_name, node.get_publishers_info_by_topic(resolved))))


def _full_name(info: Any) -> str:
    """Return the full name of an endpoint's node."""
    return f'{info.node_namespace.rstrip("/")}/{info.node_name}'


def _short(kind: str) -> str:
    """Return the name of a message type without its package."""
    return kind.rpartition('/')[2]


def _remedy(topic: str, kind: str) -> str:
    """Return the remedy for another type than this node's."""
    if topic != 'cmd_vel':
        return '; make both types alike'
    return f'; set stamped_cmd_vel to {str(_short(kind) == "Twist").lower()} on the wall clock'


def _participants(endpoints: Iterable[Any]) -> set[bytes]:
    """Return the processes of endpoints, as DDS identifies them."""
    return {bytes(endpoint.endpoint_gid[:_PARTICIPANT]) for endpoint in endpoints}


_STALL = 0.5
"""[s]: a shorter silence may come from a busy machine."""


class StallDetector:
    """
    Finds the node that blocks a lockstep run.

    From the first stall on it subscribes to the answers that do not go to the plant. Every running node answers a
    repeated question, so the first silent link of the chain is the missing node. The subscriptions stay: if one is
    destroyed just before the plant is suspended for longer than the timeout of DDS, other nodes may not discover the
    plant again (https://github.com/eProsima/Fast-DDS/issues/457).

    Parameters
    ----------
    node : Node
        The plant's.
    timeout : float
        Wall time of silence after which the missing node is named [s].
    loop : LoopGraph
        The plant's loop.

    Attributes
    ----------
    named : list of str
        The nodes named since the run last moved.

    """

    def __init__(self, node: Node, timeout: float, loop: LoopGraph) -> None:
        self._node, self._timeout, self._loop = node, timeout, loop
        # the answers in their order; the last one goes to the plant
        self._chain = tuple(loop.topics[answer] for _, answer in loop.answers)
        self._newest: dict[str, int] = {}
        self._subscriptions: list[Subscription[Any]] = []
        self._suspect, self._suspected_at = '', 0.0
        self.named: list[str] = []

    def note_silence(self, silence: float, stamp: int, tick: int) -> None:
        """
        Note an unanswered question.

        Parameters
        ----------
        silence : float
            Wall time since the question [s].
        stamp, tick : int
            Of the present velocity and position tick [ns].

        """
        if silence < min(_STALL, self._timeout / 2):
            return
        if not self._subscriptions:
            self._subscriptions = [subscribe_to(self._node, topic.name, self._listener(topic.name))
                                   for topic in self._chain[:-1]]
        missing = self.blocking_nodes(tick)
        if missing != self._suspect:
            self._suspect, self._suspected_at = missing, silence
        # the answer to a node that has just come back follows a moment later: the next node is not missing
        if silence - self._suspected_at > self._timeout and missing not in self.named:
            self.named.append(missing)
            self._node.get_logger().warning(
                f'waiting for {missing} at t = {stamp / 1e9:g} s: no answer for {silence:.1f} s'
            )

    def blocking_nodes(self, tick: int) -> str:
        """Name the nodes, joined with ' and ', that block a run at a position tick [ns]."""
        absent = [topic.publisher for topic in self._chain if self._node.count_publishers(topic.name) == 0]
        # the plant has no answer to the present question, so one node always counts as silent
        return ' and '.join(absent) or str(first_silent(self._newest, tick, tick, self._loop))

    def note_progress(self) -> None:
        """Note an answer to the question."""
        self._suspect = ''
        if self.named:
            self._node.get_logger().info(f'{" and ".join(self.named)} answered: the run goes on')
            self.named = []

    def _listener(self, topic: str) -> Callable[[bytes], None]:
        """Make a callback that stores the newest stamp of a topic."""

        def listen(message: bytes) -> None:
            with suppress(RefusedMessageError):
                self._newest[topic] = serialised_stamp(message)

        return listen
