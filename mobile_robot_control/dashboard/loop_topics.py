"""The topics of the loop, sampled while a page is open."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from rclpy.node import Node

from mobile_robot_control.dashboard.polling import PolledTopic
from mobile_robot_control.dashboard.sampling import Sampler
from mobile_robot_control.topics import LOOP_TOPICS

_COMMAND, _PLAIN = 'cmd_vel', 'geometry_msgs/msg/Twist'
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
                           for name, topic in LOOP_TOPICS.items()}

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
        if kinds and command.kind not in kinds and kinds <= {LOOP_TOPICS[_COMMAND].kind, _PLAIN}:
            command.close()
            self.polled[_COMMAND] = PolledTopic(self._node, _COMMAND, kinds.pop(), _DEPTHS['position_rate'])

    def published(self) -> list[str]:
        """List the published topics by absolute name."""
        names = map(self._node.resolve_topic_name, LOOP_TOPICS)
        return [name for name in names if self._node.count_publishers(name)]
