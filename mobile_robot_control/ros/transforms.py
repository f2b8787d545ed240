"""Odometry as a transform, where tf2 is installed."""

from collections.abc import Callable

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node

from mobile_robot_control.messages.writing import planar_quaternion
from mobile_robot_control.quantities import Pose
from mobile_robot_control.stamps import NANOSECONDS


def make_broadcaster(node: Node, frame: str, child_frame: str) -> Callable[[int, Pose], None] | None:
    """Make a function that publishes a stamp [ns] and a pose of the child frame on /tf; None without tf2_ros."""
    try:
        from tf2_ros import TransformBroadcaster  # noqa: PLC0415 (not among the wheels)
    except ImportError:
        return None
    broadcaster = TransformBroadcaster(node)

    def broadcast(stamp: int, pose: Pose) -> None:
        sent = TransformStamped(child_frame_id=child_frame)
        sent.header.frame_id = frame
        sent.header.stamp = Time(sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS)
        sent.transform.translation.x, sent.transform.translation.y = pose.x, pose.y
        sent.transform.rotation.z, sent.transform.rotation.w = planar_quaternion(pose.heading)
        broadcaster.sendTransform(sent)

    return broadcast
