"""
The memory of a stop, outside of the process that made it.

On the wall clock the position controller publishes why the robot is stopped, and the reference cart publishes it again.
Both topics are latched: each node that is started again learns the stop from the other one.
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
    One end of the exchange: publishes a reason on one topic, and takes those of the other node from another one.

    Parameters
    ----------
    node : Node
        Position controller or reference cart.
    validator : InputValidator
        Of the node; counts what is not readable.
    own, other : str
        The topic of this node and that of the other one.
    take : callable
        Called with each reason that the other node publishes, '' for none.

    """

    def __init__(
        self, node: Node, validator: InputValidator, own: str, other: str, take: Callable[[str], None]
    ) -> None:
        self._node, self._validator, self._other, self._take = node, validator, other, take
        self._publisher = node.create_publisher(String, own, LATCHED)
        node.create_subscription(String, other, self._on_reason, LATCHED, raw=True)

    def publish(self, reason: str) -> None:
        """Publish why the robot is stopped, '' where it is not."""
        self._publisher.publish(String(data=reason))

    def has_other(self) -> bool:
        """Return whether the other node is discovered."""
        return bool(self._node.count_publishers(self._node.resolve_topic_name(self._other)))

    def _on_reason(self, message: bytes) -> None:
        reason = self._validator.read(self._other, message, _READ)
        if reason is not None:
            self._take(reason)


def remember_stops(node: Node, validator: InputValidator) -> None:
    """Make the reference cart publish again what the position controller publishes; at first, that there is no stop."""

    def remember(reason: str) -> None:
        if reason:
            node.get_logger().info(f'the robot is stopped: {reason}')
        link.publish(reason)

    link = StopLink(node, validator, STOP_MEMORY, STOPPED, remember)
    link.publish('')
