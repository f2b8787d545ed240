"""
What messages say, as quantities.

For any object with the fields of the ROS message, as rclpy and as bag readers make them; nothing of ROS is imported.
"""

import math
import struct
from collections.abc import Sequence
from typing import Any

from mobile_robot_control.quantities import BodyVelocity, Pose, TrackingError, WheelTorque, WheelVelocity

WHEEL_JOINTS = ['wheel_right_joint', 'wheel_left_joint']
"""The joints' names; wheels are named in messages, never indexed."""
_NANOSECONDS = 1_000_000_000


class Refused(ValueError):  # noqa: N818 (a verdict on a message)
    """A message that must not enter the loop; the text says why, in few words."""


def nanoseconds(stamp: Any) -> int:
    """
    Read a stamp.

    Parameters
    ----------
    stamp : builtin_interfaces/Time
        Of a message's header.

    Returns
    -------
    int
        [ns].

    """
    return int(stamp.sec) * _NANOSECONDS + int(stamp.nanosec)


def serialised_stamp(message: bytes) -> int:
    """
    Read the stamp of a serialised message whose first field is a header.

    Parameters
    ----------
    message : bytes
        CDR, little endian.

    Returns
    -------
    int
        [ns].

    """
    # four bytes of encapsulation, then the header's stamp
    seconds, rest = struct.unpack_from('<iI', message, 4)
    return int(seconds) * _NANOSECONDS + int(rest)


def _finite(name: str, *values: float) -> None:
    for value in values:
        if not math.isfinite(value):
            raise Refused(f'{name} not finite')


def read_odometry(message: Any) -> tuple[Pose, BodyVelocity]:
    """
    Read pose and velocity from an odometry message.

    Parameters
    ----------
    message : nav_msgs/Odometry
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


def read_twist(message: Any) -> BodyVelocity:
    """
    Read a body velocity command.

    Parameters
    ----------
    message : geometry_msgs/TwistStamped
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


def read_error(message: Any) -> TrackingError:
    """
    Read a tracking error.

    Parameters
    ----------
    message : geometry_msgs/Vector3Stamped
        From `tracking_error`.

    Returns
    -------
    TrackingError
        [m], [rad].

    """
    return TrackingError(message.vector.x, message.vector.y, message.vector.z)


def _by_name(message: Any, values: Sequence[float], what: str) -> tuple[float, float]:
    """Pick the right and the left wheel's value by their names."""
    names = message.name
    if len(values) != len(names):
        raise Refused(f'{what} and names differ in number')
    if names == WHEEL_JOINTS:
        right, left = values
    else:
        try:
            right, left = values[names.index(WHEEL_JOINTS[0])], values[names.index(WHEEL_JOINTS[1])]
        except ValueError:
            raise Refused('a wheel is not named') from None
    _finite(what, right, left)
    return float(right), float(left)


def read_torque(message: Any) -> WheelTorque:
    """
    Read wheel torques.

    Parameters
    ----------
    message : sensor_msgs/JointState
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


def read_wheel_velocity(message: Any) -> WheelVelocity:
    """
    Read the wheels' velocities.

    Parameters
    ----------
    message : sensor_msgs/JointState
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


def read_wheel_angles(message: Any) -> tuple[float, float]:
    """
    Read the wheels' angles.

    Parameters
    ----------
    message : sensor_msgs/JointState
        From anybody.

    Returns
    -------
    tuple of float
        Right and left [rad].

    Raises
    ------
    Refused
        If a wheel or its position is missing, or an angle is not finite.

    """
    return _by_name(message, message.position, 'position')
