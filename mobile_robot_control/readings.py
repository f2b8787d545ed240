"""
What messages say, as quantities.

For any object with the fields of the ROS message, as rclpy and as bag readers make them; nothing of ROS is imported.
"""

import math
import struct
from collections.abc import Sequence
from typing import Any

from mobile_robot_control.quantities import LARGEST, BodyVelocity, Pose, TrackingError, WheelTorque, WheelVelocity

WHEEL_JOINTS = ['wheel_right_joint', 'wheel_left_joint']
"""The joints' names; wheels are named in messages, never indexed."""
_NANOSECONDS = 1_000_000_000


class Refused(ValueError):  # noqa: N818 (a verdict on a message)
    """
    A message that must not enter the loop.

    Parameters
    ----------
    reason : str
        Why, in few words that are the same for all messages alike, so that they can be counted.
    detail : str
        The values found and the remedy, for the log.

    """

    def __init__(self, reason: str, detail: str = '') -> None:
        self.reason, self.detail = reason, detail
        super().__init__(f'{reason} ({detail})' if detail else reason)


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
        CDR.

    Returns
    -------
    int
        [ns].

    Raises
    ------
    Refused
        If it is too short to have one.

    """
    try:
        # four bytes of encapsulation, which in the second says the byte order, then the header's stamp
        seconds, rest = struct.unpack_from('<iI' if message[1] & 1 else '>iI', message, 4)
    except (struct.error, IndexError):
        raise Refused('not readable', f'{len(message)} bytes hold no stamp') from None
    return int(seconds) * _NANOSECONDS + int(rest)


def _check(name: str, *values: float) -> None:
    for value in values:
        # written so that NaN does not pass
        if not abs(value) <= LARGEST:
            if math.isfinite(value):
                raise Refused(f'{name} too large', f'{value:g} is beyond {LARGEST:g}')
            raise Refused(f'{name} not finite', f'{value}')


def _check_frame(field: str, found: str, expected: str) -> None:
    if expected not in ('', found):
        raise Refused(f'{field} is not {expected}', f"it is '{found}'; the parameters odom_frame_id, base_frame_id and "
                      'reference_frame_id say what is expected')


def read_odometry(message: Any, frame: str = '', child_frame: str = '') -> tuple[Pose, BodyVelocity]:
    """
    Read pose and velocity from an odometry message.

    Parameters
    ----------
    message : nav_msgs/Odometry
        From anybody.
    frame, child_frame : str
        In which the pose and the twist must be; '' takes any.

    Returns
    -------
    tuple of Pose and BodyVelocity
        [m], [rad]; [m/s], [rad/s]; what does not lie in the plane is left out.

    Raises
    ------
    Refused
        If a number is not finite or absurdly large, the quaternion is not of unit length, or a frame is wrong.

    """
    _check_frame('frame_id', message.header.frame_id, frame)
    _check_frame('child_frame_id', message.child_frame_id, child_frame)
    position, q, twist = message.pose.pose.position, message.pose.pose.orientation, message.twist.twist
    x, y, z, w = q.x, q.y, q.z, q.w
    _check('odometry', position.x, position.y, x, y, z, w, twist.linear.x, twist.angular.z)
    length = x * x + y * y + z * z + w * w
    if abs(length - 1.0) > 0.01:
        raise Refused('quaternion not of unit length', f'its length is {math.sqrt(length):g}')
    heading = math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return Pose(position.x, position.y, heading), BodyVelocity(twist.linear.x, twist.angular.z)


def read_twist(message: Any, frame: str = '') -> BodyVelocity:
    """
    Read a body velocity command.

    Parameters
    ----------
    message : geometry_msgs/TwistStamped
        From anybody.
    frame : str
        The robot's; a message that names no frame means it. '' takes any.

    Returns
    -------
    BodyVelocity
        [m/s], [rad/s].

    Raises
    ------
    Refused
        If a number is not finite or absurdly large, or the frame is wrong.

    """
    if message.header.frame_id:
        _check_frame('frame_id', message.header.frame_id, frame)
    velocity = BodyVelocity(message.twist.linear.x, message.twist.angular.z)
    _check('command', *velocity)
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
        raise Refused(f'{what} and names differ in number', f'{len(values)} and {len(names)}')
    if names == WHEEL_JOINTS:
        right, left = values
    else:
        try:
            right, left = values[names.index(WHEEL_JOINTS[0])], values[names.index(WHEEL_JOINTS[1])]
        except ValueError:
            raise Refused('a wheel is not named', f'{WHEEL_JOINTS} are not all among {list(names)}') from None
    _check(what, right, left)
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
        If a wheel or its effort is missing, or a torque is not finite or absurdly large.

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
        If a wheel or its velocity is missing, or a velocity is not finite or absurdly large.

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
        If a wheel or its position is missing, or an angle is not finite or absurdly large.

    """
    return _by_name(message, message.position, 'position')
