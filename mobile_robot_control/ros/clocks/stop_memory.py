"""
The memory of a stop, outside the process that made it.

On the wall clock the position controller publishes the reason of a stop, and the reference cart repeats it. Both topics
are latched: each of the two nodes learns the stop from the other one after a restart.
"""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable

from rclpy.node import Node
from std_msgs.msg import String

from mobile_robot_control.ros.inputs.conversions import bytes_reader
from mobile_robot_control.ros.inputs.input_validation import InputValidator
from mobile_robot_control.ros.services.qos import LATCHED
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import STOP_MEMORY, STOPPED

_READ = bytes_reader('std_msgs/msg/String', shortened)


class StopLink:
    """
    One end of the exchange: publishes a reason on one topic, and receives those of the other node on another one.

    Parameters
    ----------
    node : Node
        Position controller or reference cart.
    validator : InputValidator
        Of the node; counts unreadable messages.
    own, other : str
        The topics of this node and of the other one.
    take : callable
        Called with each reason from the other node, '' for none.

    """

    def __init__(
        self, node: Node, validator: InputValidator, own: str, other: str, take: Callable[[str], None]
    ) -> None:
        self._node, self._validator, self._other, self._take = node, validator, other, take
        self._publisher = node.create_publisher(String, own, LATCHED)
        node.create_subscription(String, other, self._on_reason, LATCHED, raw=True)

    def publish(self, reason: str) -> None:
        """Publish the reason of a stop, '' without one."""
        self._publisher.publish(String(data=reason))

    def has_other(self) -> bool:
        """Return whether the other node is discovered."""
        return bool(self._node.count_publishers(self._node.resolve_topic_name(self._other)))

    def _on_reason(self, message: bytes) -> None:
        reason = self._validator.read(self._other, message, _READ)
        if reason is not None:
            self._take(reason)


def remember_stops(node: Node, validator: InputValidator) -> None:
    """Let the reference cart repeat the position controller's reasons; at first, it reports no stop."""

    def remember(reason: str) -> None:
        if reason:
            node.get_logger().info(f'the robot is stopped: {reason}')
        link.publish(reason)

    link = StopLink(node, validator, STOP_MEMORY, STOPPED, remember)
    link.publish('')
