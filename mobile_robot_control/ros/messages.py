"""
Quantities to messages; :mod:`mobile_robot_control.readings` is the way back.

A node makes a template of each of its messages once and fills it at every step.
"""

import math
from collections.abc import Sequence

from geometry_msgs.msg import PoseStamped, TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry, Path
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from mobile_robot_control.quantities import BodyVelocity, Pose, TrackingError, WheelTorque, WheelVelocity
from mobile_robot_control.readings import WHEEL_JOINTS
from mobile_robot_control.ros.template import Template


def planar_quaternion(heading: float) -> tuple[float, float]:
    """
    Give the quaternion of a turn about the vertical.

    Parameters
    ----------
    heading : float
        [rad].

    Returns
    -------
    tuple of float
        Its z and w; x and y are zero.

    """
    return math.sin(0.5 * heading), math.cos(0.5 * heading)


def odometry_template(
    frame: str, child_frame: str, pose_variances: Sequence[float] = (0.0,) * 6,
    twist_variances: Sequence[float] = (0.0,) * 6,
) -> Template:
    """
    Make what :func:`fill_odometry` fills.

    Parameters
    ----------
    frame, child_frame : str
        Of the pose, and of the twist.
    pose_variances, twist_variances : sequence of float
        Diagonals of the covariances [m², rad²], [m²/s², rad²/s²].

    Returns
    -------
    Template
        Of nav_msgs/Odometry.

    """
    message = Odometry(child_frame_id=child_frame)
    message.header.frame_id = frame
    message.pose.covariance[::7] = pose_variances
    message.twist.covariance[::7] = twist_variances

    def put(x: float, y: float, z: float, w: float, linear: float, angular: float) -> None:
        pose, twist = message.pose.pose, message.twist.twist
        pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w = x, y, z, w
        twist.linear.x, twist.angular.z = linear, angular

    return Template(message, put, 6)


def fill_odometry(template: Template, stamp: int, pose: Pose, velocity: BodyVelocity) -> bytes:
    """
    Write pose and velocity.

    Parameters
    ----------
    template : Template
        From :func:`odometry_template`.
    stamp : int
        [ns].
    pose : Pose
        [m], [rad].
    velocity : BodyVelocity
        In the child frame [m/s], [rad/s].

    Returns
    -------
    bytes
        To be published.

    """
    return template.fill(stamp, pose.x, pose.y, *planar_quaternion(pose.heading), *velocity)


def twist_template(frame: str, stamped: bool = True) -> Template:
    """
    Make what :func:`fill_twist` fills.

    Parameters
    ----------
    frame : str
        The robot's.
    stamped : bool
        Whether the message has a header.

    Returns
    -------
    Template
        Of geometry_msgs/TwistStamped or geometry_msgs/Twist, for `cmd_vel`.

    """
    message = TwistStamped()
    message.header.frame_id = frame

    def put(linear: float, angular: float) -> None:
        message.twist.linear.x, message.twist.angular.z = linear, angular

    return Template(message if stamped else message.twist, put, 2)


def fill_twist(template: Template, stamp: int, velocity: BodyVelocity) -> bytes:
    """
    Write a body velocity command.

    Parameters
    ----------
    template : Template
        From :func:`twist_template`.
    stamp : int
        [ns].
    velocity : BodyVelocity
        [m/s], [rad/s].

    Returns
    -------
    bytes
        To be published.

    """
    return template.fill(stamp, *velocity)


def error_template(frame: str) -> Template:
    """
    Make what :func:`fill_error` fills.

    Parameters
    ----------
    frame : str
        The robot's.

    Returns
    -------
    Template
        Of geometry_msgs/Vector3Stamped, for `tracking_error`.

    """
    message = Vector3Stamped()
    message.header.frame_id = frame

    def put(longitudinal: float, lateral: float, heading: float) -> None:
        message.vector.x, message.vector.y, message.vector.z = longitudinal, lateral, heading

    return Template(message, put, 3)


def fill_error(template: Template, stamp: int, error: TrackingError) -> bytes:
    """
    Write a tracking error.

    Parameters
    ----------
    template : Template
        From :func:`error_template`.
    stamp : int
        [ns].
    error : TrackingError
        [m], [rad].

    Returns
    -------
    bytes
        To be published: x = e1 [m], y = e2 [m], z = e3 [rad].

    """
    return template.fill(stamp, *error)


def torque_template() -> Template:
    """
    Make what :func:`fill_torque` fills.

    Returns
    -------
    Template
        Of sensor_msgs/JointState with the wheels' names and efforts, for `wheel_torques`.

    """
    message = JointState(name=WHEEL_JOINTS)

    def put(right: float, left: float) -> None:
        message.effort = [right, left]

    return Template(message, put, 2)


def fill_torque(template: Template, stamp: int, torque: WheelTorque) -> bytes:
    """
    Write wheel torques.

    Parameters
    ----------
    template : Template
        From :func:`torque_template`.
    stamp : int
        [ns].
    torque : WheelTorque
        [N m].

    Returns
    -------
    bytes
        To be published.

    """
    return template.fill(stamp, *torque)


def joints_template() -> Template:
    """
    Make what :func:`fill_joints` fills.

    Returns
    -------
    Template
        Of sensor_msgs/JointState with the wheels' names, positions, velocities and efforts, for `joint_states`.

    """
    message = JointState(name=WHEEL_JOINTS)

    def put(*numbers: float) -> None:
        message.position, message.velocity, message.effort = numbers[:2], numbers[2:4], numbers[4:]

    return Template(message, put, 6)


def fill_joints(
    template: Template, stamp: int, angles: tuple[float, float], velocity: WheelVelocity, torque: WheelTorque
) -> bytes:
    """
    Write the wheels' state.

    Parameters
    ----------
    template : Template
        From :func:`joints_template`.
    stamp : int
        [ns].
    angles : tuple of float
        Right and left [rad].
    velocity : WheelVelocity
        [rad/s].
    torque : WheelTorque
        Applied over the step that ended at the stamp [N m].

    Returns
    -------
    bytes
        To be published.

    """
    return template.fill(stamp, *angles, *velocity, *torque)


def clock_template() -> Template:
    """
    Make what is filled with a stamp alone.

    Returns
    -------
    Template
        Of rosgraph_msgs/Clock, for `/clock`.

    """
    return Template(Clock(), lambda: None, 0)


def path_message(frame: str, poses: Sequence[Pose]) -> Path:
    """
    Write a path.

    Parameters
    ----------
    frame : str
        Of the poses.
    poses : sequence of Pose
        [m], [rad].

    Returns
    -------
    Path
        With stamps zero.

    """
    path = Path()
    path.header.frame_id = frame
    for pose in poses:
        point = PoseStamped()
        point.header.frame_id = frame
        point.pose.position.x, point.pose.position.y = pose.x, pose.y
        point.pose.orientation.z, point.pose.orientation.w = planar_quaternion(pose.heading)
        path.poses.append(point)
    return path
