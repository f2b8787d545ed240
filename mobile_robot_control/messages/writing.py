"""
Quantities to messages; `mobile_robot_control.messages.parsing` is the inverse.

A node makes a writer for each of its messages once; at every step it publishes the bytes that the writer returns.
"""

import math
from collections.abc import Callable, Sequence
from struct import pack_into

from builtin_interfaces.msg import Duration
from geometry_msgs.msg import AccelStamped, PoseStamped, Transform, Twist, TwistStamped, Vector3Stamped, WrenchStamped
from nav_msgs.msg import Odometry, Path
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, TimeReference

from mobile_robot_control.messages.cdr import ENCAPSULATION
from mobile_robot_control.messages.parsing import WHEEL_JOINTS
from mobile_robot_control.messages.serialising import serialise
from mobile_robot_control.messages.template import Template
from mobile_robot_control.quantities import (
    BodyAcceleration,
    BodyVelocity,
    Pose,
    Push,
    Reference,
    TrackingError,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.stamps import NANOSECONDS


def planar_quaternion(heading: float) -> tuple[float, float]:
    """Return z and w of the quaternion of a rotation [rad] about the vertical; x and y are zero."""
    return math.sin(0.5 * heading), math.cos(0.5 * heading)


def odometry_writer(
    frame: str, child_frame: str, pose_variances: Sequence[float] = (0.0,) * 6,
    twist_variances: Sequence[float] = (0.0,) * 6,
) -> Callable[[int, Pose, BodyVelocity], bytes]:
    """
    Make a function that writes nav_msgs/Odometry.

    Parameters
    ----------
    frame, child_frame : str
        Of the pose, and of the twist.
    pose_variances, twist_variances : sequence of float
        Diagonals of the covariances [m², rad²], [m²/s², rad²/s²].

    Returns
    -------
    callable
        Takes a stamp [ns], a pose [m, rad] and a velocity in the child frame [m/s, rad/s]; returns bytes.

    """
    message = Odometry(child_frame_id=child_frame)
    message.header.frame_id = frame
    message.pose.covariance[::7] = pose_variances
    message.twist.covariance[::7] = twist_variances

    def put(x: float, y: float, z: float, w: float, linear: float, angular: float) -> None:
        pose, twist = message.pose.pose, message.twist.twist
        pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w = x, y, z, w
        twist.linear.x, twist.angular.z = linear, angular

    template = Template(message, put, 6)

    def write(stamp: int, pose: Pose, velocity: BodyVelocity) -> bytes:
        return template.fill(stamp, pose.x, pose.y, *planar_quaternion(pose.heading), *velocity)

    return write


def twist_writer(frame: str, stamped: bool = True) -> Callable[[int, BodyVelocity], bytes]:
    """
    Make a function that writes geometry_msgs/TwistStamped, or geometry_msgs/Twist if not stamped, for `cmd_vel`.

    It takes a stamp [ns] and a body velocity in the robot's frame [m/s, rad/s].
    """
    message = TwistStamped()
    message.header.frame_id = frame

    def put(linear: float, angular: float) -> None:
        message.twist.linear.x, message.twist.angular.z = linear, angular

    template = Template(message if stamped else message.twist, put, 2)
    return lambda stamp, velocity: template.fill(stamp, *velocity)


def acceleration_writer(frame: str) -> Callable[[int, BodyAcceleration], bytes]:
    """
    Make a function that writes geometry_msgs/AccelStamped for `cmd_accel`.

    It takes a stamp [ns] and an acceleration in the robot's frame [m/s², rad/s²].
    """
    message = AccelStamped()
    message.header.frame_id = frame

    def put(linear: float, angular: float) -> None:
        message.accel.linear.x, message.accel.angular.z = linear, angular

    template = Template(message, put, 2)
    return lambda stamp, acceleration: template.fill(stamp, *acceleration)


def horizon_writer(
    frame: str, child_frame: str, ticks: int, period: int
) -> Callable[[int, Sequence[Reference]], bytes]:
    """
    Make a function that writes trajectory_msgs/MultiDOFJointTrajectory for `reference_horizon`.

    Parameters
    ----------
    frame, child_frame : str
        Of the poses; of the cart, which is that of velocities and accelerations.
    ticks : int
        Number of points after the present one.
    period : int
        Between two points [ns].

    Returns
    -------
    callable
        Takes a stamp [ns] and the references now and at the ticks ahead; returns bytes.

    """
    # imported late: most nodes write no horizon
    from trajectory_msgs.msg import (  # noqa: PLC0415
        MultiDOFJointTrajectory,
        MultiDOFJointTrajectoryPoint,
    )

    message = MultiDOFJointTrajectory(joint_names=[child_frame], points=[
        MultiDOFJointTrajectoryPoint(
            transforms=[Transform()], velocities=[Twist()], accelerations=[Twist()],
            time_from_start=Duration(sec=n * period // NANOSECONDS, nanosec=n * period % NANOSECONDS))
        for n in range(ticks + 1)])
    message.header.frame_id = frame

    def put(*numbers: float) -> None:
        for n, point in enumerate(message.points):
            at, turn = point.transforms[0].translation, point.transforms[0].rotation
            velocity, acceleration = point.velocities[0], point.accelerations[0]
            (at.x, at.y, turn.z, turn.w, velocity.linear.x, velocity.angular.z, acceleration.linear.x,
             acceleration.angular.z) = numbers[8 * n:8 * n + 8]

    template = Template(message, put, 8 * (ticks + 1))

    def write(stamp: int, references: Sequence[Reference]) -> bytes:
        numbers: list[float] = []
        for pose, velocity, acceleration in references:
            numbers += (pose.x, pose.y, *planar_quaternion(pose.heading), *velocity, *acceleration)
        return template.fill(stamp, *numbers)

    return write


def time_writer() -> Callable[[int, int], bytes]:
    """Make a function that writes sensor_msgs/TimeReference from a stamp and the time to send [ns]."""
    mark = b'\x7b\x2d\x4c\x11'
    message = TimeReference()
    message.time_ref.sec = int.from_bytes(mark, 'little')
    data = serialise(message)
    at = data.index(mark)

    def write(stamp: int, time: int) -> bytes:
        for place, nanoseconds in ((len(ENCAPSULATION), stamp), (at, time)):
            pack_into('<iI', data, place, *divmod(nanoseconds, NANOSECONDS))
        return bytes(data)

    return write


def error_writer(frame: str) -> Callable[[int, TrackingError], bytes]:
    """
    Make a function that writes geometry_msgs/Vector3Stamped for `tracking_error`: x = e1 [m], y = e2 [m], z = e3 [rad].

    It takes a stamp [ns] and a tracking error in the robot's frame.
    """
    message = Vector3Stamped()
    message.header.frame_id = frame

    def put(longitudinal: float, lateral: float, heading: float) -> None:
        message.vector.x, message.vector.y, message.vector.z = longitudinal, lateral, heading

    template = Template(message, put, 3)
    return lambda stamp, error: template.fill(stamp, *error)


def wrench_writer(frame: str) -> Callable[[int, Push], bytes]:
    """
    Make a function that writes geometry_msgs/WrenchStamped for `disturbance`.

    It takes a stamp [ns] and a push in the robot's frame [N], [N m].
    """
    message = WrenchStamped()
    message.header.frame_id = frame

    def put(force: float, torque: float) -> None:
        message.wrench.force.x, message.wrench.torque.z = force, torque

    template = Template(message, put, 2)
    return lambda stamp, wrench: template.fill(stamp, *wrench)


def torque_writer() -> Callable[[int, WheelTorque], bytes]:
    """
    Make a function that writes sensor_msgs/JointState with the wheels' names and efforts, for `wheel_torques`.

    It takes a stamp [ns] and wheel torques [N m].
    """
    message = JointState(name=WHEEL_JOINTS)

    def put(right: float, left: float) -> None:
        message.effort = [right, left]

    template = Template(message, put, 2)
    return lambda stamp, torque: template.fill(stamp, *torque)


def joints_writer(
    has_effort: bool = True,
) -> Callable[[int, tuple[float, float], WheelVelocity, WheelTorque | None], bytes]:
    """
    Make a function that writes sensor_msgs/JointState with all values of the wheels, for `joint_states`.

    It takes a stamp [ns], the angles of the right and the left wheel [rad], their velocities [rad/s], and the torques
    applied over the step up to the stamp [N m]; None for messages without effort.
    """
    message = JointState(name=WHEEL_JOINTS)

    def put(*numbers: float) -> None:
        message.position, message.velocity, message.effort = numbers[:2], numbers[2:4], numbers[4:]

    template = Template(message, put, 6 if has_effort else 4)
    return lambda stamp, angles, velocity, torque: template.fill(stamp, *angles, *velocity, *(torque or ()))


def clock_writer() -> Callable[[int], bytes]:
    """Make a function that writes rosgraph_msgs/Clock from a stamp [ns]."""
    return Template(Clock(), lambda: None, 0).fill


def path_message(frame: str, poses: Sequence[Pose]) -> Path:
    """Make a nav_msgs/Path of poses [m, rad] in a frame, with stamps zero."""
    path = Path()
    path.header.frame_id = frame
    for pose in poses:
        point = PoseStamped()
        point.header.frame_id = frame
        point.pose.position.x, point.pose.position.y = pose.x, pose.y
        point.pose.orientation.z, point.pose.orientation.w = planar_quaternion(pose.heading)
        path.poses.append(point)
    return path
