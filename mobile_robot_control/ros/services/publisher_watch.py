"""Who else publishes on a node's topics, whose quality of service does not fit, and who does not listen."""

import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from rclpy.node import Node
from rclpy.qos import qos_policy_name_from_kind

_PARTICIPANT = 12
"""Bytes of an endpoint's GUID that are those of its process."""
_REMEDY = 'stop all but one, or give each robot a namespace or a ROS_DOMAIN_ID of its own'


class PublisherWatch:
    """
    Counts the publishers of topics that should have one, and notes endpoints that do not fit.

    Parameters
    ----------
    node : Node
        Whose inputs and outputs.
    topics : sequence of str
        Loop topics, by relative name.
    listeners : mapping of str to mapping of str to sequence of str
        Of topics that the node publishes, the nodes that need them, each with the topics that it publishes.
    patience : float
        Wall time [s] that a node may be known without being a listener.

    Attributes
    ----------
    several : dict of str to str
        The names of all publishers of a topic that has more than one, joined by ' and ', since the last look.
    unfit : dict of str to str
        What does not fit about the quality of service of other endpoints, by topic.

    """

    def __init__(
        self, node: Node, topics: Sequence[str], listeners: Mapping[str, Mapping[str, Sequence[str]]], patience: float
    ) -> None:
        self._node, self._patience = node, patience
        # an output that was remapped goes to a node that is not known here
        self._listeners = {topic: nodes for topic, nodes in listeners.items()
                           if node.resolve_topic_name(topic).endswith(f'/{topic}')}
        self._topics = {topic: node.resolve_topic_name(topic) for topic in topics}
        self._deaf_since: dict[str, float] = {}
        self.several: dict[str, str] = {}
        self.unfit: dict[str, str] = {}

    def publishers(self, topic: str) -> int:
        """Return how many publishers a topic has now, as far as they are discovered."""
        return self._node.count_publishers(self._topics[topic])

    def endpoints(self, topic: str) -> set[bytes]:
        """Return the publishers of a topic as DDS names them: a node that was started again has others."""
        return {bytes(info.endpoint_gid) for info in self._node.get_publishers_info_by_topic(self._topics[topic])}

    def look(self) -> None:
        """Count publishers; name those of a topic that has come to have several, in the log once."""
        found = {topic: publisher_names(self._node, resolved) for topic, resolved in self._topics.items()
                 if self._node.count_publishers(resolved) > 1}
        # the name of a node is discovered after its publishers
        found = {topic: names for topic, names in found.items() if '_UNKNOWN_' not in names}
        for topic, names in found.items():
            if topic not in self.several:
                self._node.get_logger().warning(f'{topic} has several publishers: {names}; {_REMEDY}')
        for topic in self.several:
            if topic not in found:
                self._node.get_logger().info(f'{topic} has one publisher again')
        self.several = found
        deaf, now = set(self._deaf()), time.monotonic()
        self._deaf_since = {text: self._deaf_since.get(text, now) for text in deaf}

    def _deaf(self) -> Iterator[str]:
        """
        Yield which nodes are discovered, but not as listeners of this one.

        Fast DDS may discover a process only by half that was stopped for longer than its lease.
        """
        for topic, nodes in self._listeners.items():
            listening = _participants(self._node.get_subscriptions_info_by_topic(self._node.resolve_topic_name(topic)))
            for node, published in nodes.items():
                known: set[bytes] = set().union(*(
                    _participants(self._node.get_publishers_info_by_topic(self._node.resolve_topic_name(other)))
                    for other in published))
                if known and not known & listening:
                    yield f'{node} is discovered, but not as a listener of {topic}: start this node again'

    def note_unfit(self, topic: str, whose: str, event: Any) -> None:
        """
        Note that DDS does not connect an endpoint of another node, whose quality of service does not fit.

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
        text = (f'a {whose} on {topic} is not connected: its {policy} does not fit the {ours} of this node; make both '
                f'reliable and volatile')
        if self.unfit.get(topic) != text:
            self.unfit[topic] = text
            self._node.get_logger().warning(text)

    def problems(self) -> list[str]:
        """List what is wrong, in words."""
        deaf = [text for text, since in self._deaf_since.items() if time.monotonic() - since > self._patience]
        return [*(f'{topic} has several publishers ({names})' for topic, names in self.several.items()),
                *self.unfit.values(), *deaf]


def publisher_names(node: Node, resolved: str) -> str:
    """Return the full names of the nodes that publish a topic, by its resolved name, joined by ' and '."""
    infos = node.get_publishers_info_by_topic(resolved)
    return ' and '.join(sorted(f'{info.node_namespace.rstrip("/")}/{info.node_name}' for info in infos))


def _participants(endpoints: Iterable[Any]) -> set[bytes]:
    """Return the processes that endpoints belong to, as DDS names them."""
    return {bytes(endpoint.endpoint_gid[:_PARTICIPANT]) for endpoint in endpoints}
