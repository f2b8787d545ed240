"""
Quantities to messages; :mod:`mobile_robot_control.readings` is the way back.

A node makes each of its messages once and fills it at every step: to make one takes rclpy several times as long as to
fill it, and publishing copies.
"""

import math
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import PoseStamped, TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import JointState

from mobile_robot_control.quantities import BodyVelocity, Pose, TrackingError, WheelTorque, WheelVelocity
from mobile_robot_control.readings import WHEEL_JOINTS

_NANOSECONDS = 1_000_000_000


def _set_stamp(message: Any, stamp: int) -> None:
    """Write a stamp [ns] into the header; the Time that is there serves again."""
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, _NANOSECONDS)


def _set_pose(message: Any, pose: Pose) -> None:
    message.position.x, message.position.y = pose.x, pose.y
    message.orientation.z, message.orientation.w = math.sin(0.5 * pose.heading), math.cos(0.5 * pose.heading)


def odometry_message(frame: str, child_frame: str) -> Odometry:
    """
    Make an odometry message without a stamp, to be filled by :func:`fill_odometry`.

    Parameters
    ----------
    frame, child_frame : str
        Of the pose, and of the twist.

    Returns
    -------
    Odometry
        Covariances zero.

    """
    message = Odometry(child_frame_id=child_frame)
    message.header.frame_id = frame
    return message


def fill_odometry(message: Odometry, stamp: int, pose: Pose, velocity: BodyVelocity) -> Odometry:
    """
    Write pose and velocity into an odometry message.

    Parameters
    ----------
    message : Odometry
        Changed.
    stamp : int
        [ns].
    pose : Pose
        [m], [rad].
    velocity : BodyVelocity
        In the child frame [m/s], [rad/s].

    Returns
    -------
    Odometry
        The same message.

    """
    _set_stamp(message, stamp)
    _set_pose(message.pose.pose, pose)
    message.twist.twist.linear.x = velocity.linear
    message.twist.twist.angular.z = velocity.angular
    return message


def twist_message(frame: str) -> TwistStamped:
    """
    Make a body velocity command without a stamp, to be filled by :func:`fill_twist`.

    Parameters
    ----------
    frame : str
        The robot's.

    Returns
    -------
    TwistStamped
        For `cmd_vel`.

    """
    message = TwistStamped()
    message.header.frame_id = frame
    return message


def fill_twist(message: TwistStamped, stamp: int, velocity: BodyVelocity) -> TwistStamped:
    """
    Write a body velocity command.

    Parameters
    ----------
    message : TwistStamped
        Changed.
    stamp : int
        [ns].
    velocity : BodyVelocity
        [m/s], [rad/s].

    Returns
    -------
    TwistStamped
        The same message.

    """
    _set_stamp(message, stamp)
    message.twist.linear.x, message.twist.angular.z = velocity
    return message


def error_message(frame: str) -> Vector3Stamped:
    """
    Make a tracking error without a stamp, to be filled by :func:`fill_error`.

    Parameters
    ----------
    frame : str
        The robot's.

    Returns
    -------
    Vector3Stamped
        For `tracking_error`.

    """
    message = Vector3Stamped()
    message.header.frame_id = frame
    return message


def fill_error(message: Vector3Stamped, stamp: int, error: TrackingError) -> Vector3Stamped:
    """
    Write a tracking error.

    Parameters
    ----------
    message : Vector3Stamped
        Changed.
    stamp : int
        [ns].
    error : TrackingError
        [m], [rad].

    Returns
    -------
    Vector3Stamped
        The same message: x = e1 [m], y = e2 [m], z = e3 [rad].

    """
    _set_stamp(message, stamp)
    message.vector.x, message.vector.y, message.vector.z = error
    return message


def wheels_message() -> JointState:
    """
    Make a message that names the wheels, to be filled by :func:`fill_torque` or :func:`fill_joints`.

    Returns
    -------
    JointState
        Without a stamp, for `wheel_torques` or `joint_states`.

    """
    return JointState(name=WHEEL_JOINTS)


def fill_torque(message: JointState, stamp: int, torque: WheelTorque) -> JointState:
    """
    Write wheel torques.

    Parameters
    ----------
    message : JointState
        Changed.
    stamp : int
        [ns].
    torque : WheelTorque
        [N m].

    Returns
    -------
    JointState
        The same message.

    """
    _set_stamp(message, stamp)
    message.effort = torque
    return message


def fill_joints(
    message: JointState, stamp: int, angles: tuple[float, float], velocity: WheelVelocity, torque: WheelTorque
) -> JointState:
    """
    Write the wheels' state.

    Parameters
    ----------
    message : JointState
        Changed.
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
    JointState
        The same message.

    """
    message.position, message.velocity = angles, velocity
    return fill_torque(message, stamp, torque)


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
        _set_pose(point.pose, pose)
        path.poses.append(point)
    return path
