"""Quantities to messages and back; each message's two directions stand side by side."""

import math
from array import array
from collections.abc import Sequence
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import JointState

from mobile_robot_control.quantities import BodyVelocity, Pose, TrackingError, WheelTorque, WheelVelocity

RIGHT_WHEEL, LEFT_WHEEL = 'wheel_right_joint', 'wheel_left_joint'
_WHEELS = [RIGHT_WHEEL, LEFT_WHEEL]
_NANOSECONDS = 1_000_000_000


class Refused(ValueError):  # noqa: N818 (a verdict on a message)
    """A message that must not enter the loop; the text says why, in few words."""


def nanoseconds(stamp: Time) -> int:
    """
    Read a stamp.

    Parameters
    ----------
    stamp : Time
        Of a message's header.

    Returns
    -------
    int
        [ns].

    """
    return int(stamp.sec) * _NANOSECONDS + int(stamp.nanosec)


def time_message(stamp: int) -> Time:
    """
    Write a stamp.

    Parameters
    ----------
    stamp : int
        [ns].

    Returns
    -------
    Time
        For a message's header.

    """
    return Time(sec=stamp // _NANOSECONDS, nanosec=stamp % _NANOSECONDS)


def _finite(name: str, *values: float) -> None:
    for value in values:
        if not math.isfinite(value):
            raise Refused(f'{name} not finite')


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
    message.header.stamp = time_message(stamp)
    _set_pose(message.pose.pose, pose)
    message.twist.twist.linear.x = velocity.linear
    message.twist.twist.angular.z = velocity.angular
    return message


def read_odometry(message: Odometry) -> tuple[Pose, BodyVelocity]:
    """
    Read pose and velocity from an odometry message.

    Parameters
    ----------
    message : Odometry
        From anybody.

    Returns
    -------
    tuple of Pose and BodyVelocity
        [m], [rad]; [m/s], [rad/s]; what does not lie in the plane is left out.

    Raises
    ------
    Refused
        If a number is not finite or the quaternion is not of unit length.

    """
    position, q, twist = message.pose.pose.position, message.pose.pose.orientation, message.twist.twist
    x, y, z, w = q.x, q.y, q.z, q.w
    _finite('odometry', position.x, position.y, x, y, z, w, twist.linear.x, twist.angular.z)
    if abs(x * x + y * y + z * z + w * w - 1.0) > 0.01:
        raise Refused('quaternion not of unit length')
    heading = math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return Pose(position.x, position.y, heading), BodyVelocity(twist.linear.x, twist.angular.z)


def twist_message(stamp: int, frame: str, velocity: BodyVelocity) -> TwistStamped:
    """
    Write a body velocity command.

    Parameters
    ----------
    stamp : int
        [ns].
    frame : str
        The robot's.
    velocity : BodyVelocity
        [m/s], [rad/s].

    Returns
    -------
    TwistStamped
        For `cmd_vel`.

    """
    message = TwistStamped()
    message.header.stamp = time_message(stamp)
    message.header.frame_id = frame
    message.twist.linear.x = velocity.linear
    message.twist.angular.z = velocity.angular
    return message


def read_twist(message: TwistStamped) -> BodyVelocity:
    """
    Read a body velocity command.

    Parameters
    ----------
    message : TwistStamped
        From anybody.

    Returns
    -------
    BodyVelocity
        [m/s], [rad/s].

    Raises
    ------
    Refused
        If a number is not finite.

    """
    velocity = BodyVelocity(message.twist.linear.x, message.twist.angular.z)
    _finite('command', *velocity)
    return velocity


def error_message(stamp: int, frame: str, error: TrackingError) -> Vector3Stamped:
    """
    Write a tracking error.

    Parameters
    ----------
    stamp : int
        [ns].
    frame : str
        The robot's.
    error : TrackingError
        [m], [rad].

    Returns
    -------
    Vector3Stamped
        x = e1 [m], y = e2 [m], z = e3 [rad].

    """
    message = Vector3Stamped()
    message.header.stamp = time_message(stamp)
    message.header.frame_id = frame
    message.vector.x, message.vector.y, message.vector.z = error
    return message


def read_error(message: Vector3Stamped) -> TrackingError:
    """
    Read a tracking error.

    Parameters
    ----------
    message : Vector3Stamped
        From `tracking_error`.

    Returns
    -------
    TrackingError
        [m], [rad].

    """
    return TrackingError(message.vector.x, message.vector.y, message.vector.z)


def torque_message(stamp: int, torque: WheelTorque) -> JointState:
    """
    Write wheel torques.

    Parameters
    ----------
    stamp : int
        [ns].
    torque : WheelTorque
        [N m].

    Returns
    -------
    JointState
        With names and effort only.

    """
    message = JointState(name=_WHEELS, effort=array('d', torque))
    message.header.stamp = time_message(stamp)
    return message


def _by_name(message: JointState, values: Sequence[float], what: str) -> tuple[float, float]:
    """Pick the right and the left wheel's value by their names."""
    names = message.name
    if len(values) != len(names):
        raise Refused(f'{what} and names differ in number')
    if names == _WHEELS:
        right, left = values
    else:
        try:
            right, left = values[names.index(RIGHT_WHEEL)], values[names.index(LEFT_WHEEL)]
        except ValueError:
            raise Refused('a wheel is not named') from None
    _finite(what, right, left)
    return right, left


def read_torque(message: JointState) -> WheelTorque:
    """
    Read wheel torques.

    Parameters
    ----------
    message : JointState
        From anybody; the wheels may stand in any order.

    Returns
    -------
    WheelTorque
        [N m].

    Raises
    ------
    Refused
        If a wheel or its effort is missing, or a torque is not finite.

    """
    return WheelTorque(*_by_name(message, message.effort, 'effort'))


def joint_message(
    stamp: int, angles: tuple[float, float], velocity: WheelVelocity, torque: WheelTorque
) -> JointState:
    """
    Write the wheels' state.

    Parameters
    ----------
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
        For `joint_states`.

    """
    message = JointState(
        name=_WHEELS, position=array('d', angles), velocity=array('d', velocity), effort=array('d', torque)
    )
    message.header.stamp = time_message(stamp)
    return message


def read_wheel_velocity(message: JointState) -> WheelVelocity:
    """
    Read the wheels' velocities.

    Parameters
    ----------
    message : JointState
        From anybody; the wheels may stand in any order, among other joints.

    Returns
    -------
    WheelVelocity
        [rad/s].

    Raises
    ------
    Refused
        If a wheel or its velocity is missing, or a velocity is not finite.

    """
    return WheelVelocity(*_by_name(message, message.velocity, 'velocity'))


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
