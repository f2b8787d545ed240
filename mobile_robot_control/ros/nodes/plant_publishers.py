"""The plant's publishers: measured odometry and joint states, and topics derived from odometry."""

from collections.abc import Callable, Sequence
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from mobile_robot_control.configuration.nodes import PlantParameters, has_exact_odometry
from mobile_robot_control.messages import writing
from mobile_robot_control.messages.writing import planar_quaternion
from mobile_robot_control.quantities import Pose
from mobile_robot_control.ros.nodes.simulated_robot import SimulatedRobot
from mobile_robot_control.ros.services.qos import PUBLISHED, flush
from mobile_robot_control.stamps import NANOSECONDS, period_nanoseconds


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


_LAST = 3.0
"""[s] of wall time for the arrival of the last messages; a recorder on a busy machine needs some of it."""


def _sums(first: Sequence[float], second: Sequence[float]) -> list[float]:
    return [a + b for a, b in zip(first, second, strict=True)]


class PlantPublishers:
    """
    Publishes the plant's state.

    Parameters
    ----------
    node : Node
        The plant's.
    values : PlantParameters
        Initial parameters.
    robot : SimulatedRobot
        The measured robot.
    publish_on : callable
        Makes the node's publisher on a loop topic.

    """

    def __init__(
        self, node: Node, values: PlantParameters, robot: SimulatedRobot, publish_on: Callable[[str], Any]
    ) -> None:
        shared = values.shared
        self._robot = robot
        frames = shared.odom_frame_id, shared.base_frame_id
        injected = robot.variances()
        self._write_odometry = writing.odometry_writer(
            *frames, _sums(values.pose_covariance_diagonal, injected[0]),
            _sums(values.twist_covariance_diagonal, injected[1]))
        self._write_truth = writing.odometry_writer(*frames)
        exact = has_exact_odometry(values)
        self._ground_truth = None if exact else node.create_publisher(Odometry, 'ground_truth', PUBLISHED)
        self._write_joints = writing.joints_writer(has_effort=not robot.takes_velocity)
        self._write_clock = writing.clock_writer()
        self._write_time = writing.time_writer()
        self._odom_time = publish_on('odom_time') if shared.has_odom_time else None
        self._odom, self._joint_states = publish_on('odom'), publish_on('joint_states')
        publish_clock = values.publish_clock and shared.lockstep
        self._clock = node.create_publisher(Clock, '/clock', PUBLISHED) if publish_clock else None
        self._broadcast = make_broadcaster(node, *frames) if values.publish_tf else None
        self._newest: tuple[int, Pose, bytes]
        self._sampled, self._truth, self._time = -1, b'', b''
        self._period = period_nanoseconds(shared.velocity_rate)
        self._stamps_samples = shared.stamps_samples

    def publish_odometry(self, stamp: int) -> None:
        """Publish, with a stamp [ns], the measured pose and, if odometry is not exact, the true one."""
        pose, twist = self._robot.measured_odometry()
        if self._odom_time is not None:
            self._time = self._write_time(stamp, self._robot.sampled * self._period)
        elif self._stamps_samples:
            stamp -= (self._robot.k - self._robot.sampled) * self._period
        self._newest = stamp, pose, self._write_odometry(stamp, pose, twist)
        self._truth = self._true_motion(stamp)
        self.repeat_odometry()

    def publish_sample(self, stamp: int) -> None:
        """Publish odometry if a new sample has arrived, with the present stamp [ns]."""
        if self._robot.sampled != self._sampled:
            self._sampled = self._robot.sampled
            self.publish_odometry(stamp)

    def _true_motion(self, stamp: int) -> bytes:
        if self._ground_truth is None:
            return b''
        state = self._robot.state
        return self._write_truth(stamp, state.pose, state.velocity)

    def repeat_odometry(self) -> None:
        """Publish the newest odometry, and the truth beside it, for the first time or again."""
        stamp, pose, odometry = self._newest
        if self._odom_time is not None:
            self._odom_time.publish(self._time)
        self._odom.publish(odometry)
        if self._ground_truth is not None:
            self._ground_truth.publish(self._truth)
        if self._clock is not None:
            self._clock.publish(self._write_clock(stamp))
        if self._broadcast is not None:
            self._broadcast(stamp, pose)

    def publish_joint_states(self, stamp: int) -> None:
        """Publish, with a stamp [ns], the wheels' angles, measured velocities, and torques over the last step."""
        angles, velocities = self._robot.measured_wheels()
        self._joint_states.publish(self._write_joints(stamp, angles, velocities, self._robot.applied))

    def flush(self) -> None:
        """Wait briefly until all messages have reached every subscriber."""
        every = (self._odom, self._joint_states, self._ground_truth, self._clock, self._odom_time)
        flush(*(publisher for publisher in every if publisher is not None), seconds=_LAST)
