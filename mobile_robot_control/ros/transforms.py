"""Odometry as a transform, where tf2 is installed."""

from collections.abc import Callable

from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node


def make_broadcaster(node: Node) -> Callable[[Odometry], None] | None:
    """
    Make what sends odometry to /tf.

    Parameters
    ----------
    node : Node
        Who sends.

    Returns
    -------
    callable or None
        Takes an odometry message; None where tf2_ros is not installed.

    """
    try:
        from tf2_ros import TransformBroadcaster  # noqa: PLC0415 (not among the wheels)
    except ImportError:
        return None
    broadcaster = TransformBroadcaster(node)

    def broadcast(odometry: Odometry) -> None:
        transform = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
        position = odometry.pose.pose.position
        transform.transform.translation.x, transform.transform.translation.y = position.x, position.y
        transform.transform.rotation = odometry.pose.pose.orientation
        broadcaster.sendTransform(transform)

    return broadcast
