"""Messages as plain objects with the fields of the ROS messages that the loop reads, without stamp and covariances."""

from typing import NamedTuple


class Header(NamedTuple):
    """std_msgs/Header."""

    frame_id: str


class JointState(NamedTuple):
    """sensor_msgs/JointState."""

    header: Header
    name: list[str]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    effort: tuple[float, ...]


class Vector(NamedTuple):
    """geometry_msgs/Point and geometry_msgs/Vector3."""

    x: float
    y: float
    z: float


class Quaternion(NamedTuple):
    """geometry_msgs/Quaternion."""

    x: float
    y: float
    z: float
    w: float


class MessagePose(NamedTuple):
    """geometry_msgs/Pose."""

    position: Vector
    orientation: Quaternion


class Twist(NamedTuple):
    """geometry_msgs/Twist."""

    linear: Vector
    angular: Vector


class PoseStamped(NamedTuple):
    """geometry_msgs/PoseStamped."""

    header: Header
    pose: MessagePose


class Path(NamedTuple):
    """nav_msgs/Path."""

    header: Header
    poses: list[PoseStamped]


class PoseWithCovariance(NamedTuple):
    """geometry_msgs/PoseWithCovariance."""

    pose: MessagePose


class TwistWithCovariance(NamedTuple):
    """geometry_msgs/TwistWithCovariance."""

    twist: Twist


class TwistStamped(NamedTuple):
    """geometry_msgs/TwistStamped."""

    header: Header
    twist: Twist


class Odometry(NamedTuple):
    """nav_msgs/Odometry."""

    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


class AccelStamped(NamedTuple):
    """geometry_msgs/AccelStamped."""

    header: Header
    accel: Twist


class TimeReference(NamedTuple):
    """sensor_msgs/TimeReference, without its source; the time is in nanoseconds."""

    header: Header
    time_ref: int


class Transform(NamedTuple):
    """geometry_msgs/Transform."""

    translation: Vector
    rotation: Quaternion


class TransformStamped(NamedTuple):
    """geometry_msgs/TransformStamped, with its stamp in nanoseconds."""

    stamp: int
    header: Header
    child_frame_id: str
    transform: Transform


class TrajectoryPoint(NamedTuple):
    """trajectory_msgs/MultiDOFJointTrajectoryPoint; the time from start is in nanoseconds."""

    transforms: tuple[Transform, ...]
    velocities: tuple[Twist, ...]
    accelerations: tuple[Twist, ...]
    time_from_start: int


class MultiDOFJointTrajectory(NamedTuple):
    """trajectory_msgs/MultiDOFJointTrajectory."""

    header: Header
    joint_names: list[str]
    points: tuple[TrajectoryPoint, ...]


class Wrench(NamedTuple):
    """geometry_msgs/Wrench."""

    force: Vector
    torque: Vector


class WrenchStamped(NamedTuple):
    """geometry_msgs/WrenchStamped."""

    header: Header
    wrench: Wrench


class Vector3Stamped(NamedTuple):
    """geometry_msgs/Vector3Stamped."""

    header: Header
    vector: Vector


class KeyValue(NamedTuple):
    """diagnostic_msgs/KeyValue."""

    key: str
    value: str


class DiagnosticStatus(NamedTuple):
    """diagnostic_msgs/DiagnosticStatus, without level and hardware_id."""

    name: str
    message: str
    values: tuple[KeyValue, ...]


class DiagnosticArray(NamedTuple):
    """diagnostic_msgs/DiagnosticArray."""

    header: Header
    status: tuple[DiagnosticStatus, ...]
