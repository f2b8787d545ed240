"""
Messages to quantities, with every number checked.

The functions take any object with the fields of the ROS message, from rclpy or from a bag reader; nothing of ROS is
imported.
"""

import math
import struct
from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any, NamedTuple

from mobile_robot_control.elementary import atan2
from mobile_robot_control.quantities import (
    LARGEST,
    NANOSECONDS,
    BodyAcceleration,
    BodyVelocity,
    Pose,
    Push,
    Reference,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import WHEEL_JOINTS

_POINT_TOLERANCE = 1000
"""[ns] of tolerance for the time of a point."""


class RefusedMessageError(ValueError):
    """
    A message that must not enter the loop.

    Parameters
    ----------
    reason : str
        A few words, equal for all messages of one kind, so that they can be counted.
    detail : str
        The values found and the remedy, for the log; shortened to one line.

    """

    def __init__(self, reason: str, detail: str = '') -> None:
        self.reason, self.detail = reason, shortened(detail)
        super().__init__(f'{reason} ({self.detail})' if detail else reason)


def read_or_refuse(kind: str, steps: Sequence[Callable[[Any], object]], message: bytes) -> Any:
    """
    Convert a message's bytes by steps, one after the other: the only way in which messages are read.

    Parameters
    ----------
    kind : str
        Required type of the message, for the log.
    steps : sequence of callable
        Each takes the result of the previous one; the first takes the bytes.
    message : bytes
        Serialised, from any source.

    Raises
    ------
    RefusedMessageError
        For any error of a step.

    """
    content: Any = message
    try:
        for step in steps:
            content = step(content)
    except RefusedMessageError:
        raise
    except Exception as error:  # the bytes may be anything
        raise RefusedMessageError('not readable', f'{error}; it is no {kind}') from None
    return content


def serialised_stamp(message: bytes) -> int:
    """
    Return the stamp [ns] of a serialised message whose first field is a header.

    Raises RefusedMessageError if it is too short to have one.
    """
    try:
        # four bytes of encapsulation, the second of them the byte order, then the header's stamp
        seconds, rest = struct.unpack_from('<iI' if message[1] & 1 else '>iI', message, 4)
    except (struct.error, IndexError):
        raise RefusedMessageError('not readable', f'{len(message)} bytes hold no stamp') from None
    return int(seconds) * NANOSECONDS + int(rest)


def has_no_poses(message: bytes) -> bool:
    """Return whether a serialised nav_msgs/Path ends after its header and a count of 0; False for an unreadable one."""
    try:
        order = '<' if message[1] & 1 else '>'
        frame, = struct.unpack_from(f'{order}I', message, 12)
        # the count is aligned to four bytes
        count, = struct.unpack_from(f'{order}I', message, 16 + -(-frame // 4) * 4)
    except (struct.error, IndexError):
        return False
    return bool(count == 0)


def check_numbers(name: str, *values: float) -> None:
    """Raise RefusedMessageError if a value is not finite or beyond LARGEST."""
    for value in values:
        # in this form NaN does not pass
        if not abs(value) <= LARGEST:
            if math.isfinite(value):
                raise RefusedMessageError(f'{name} too large', f'{value:g} is beyond {LARGEST:g}')
            raise RefusedMessageError(f'{name} not finite', f'{value}')


def check_frame(field: str, frame: str, expected: str) -> None:
    """Raise RefusedMessageError if a frame is not the expected one."""
    if expected not in ('', frame):
        raise RefusedMessageError(
            f'{field} is not {expected}', f"it is '{shortened(frame, 60)}'; the parameters odom_frame_id, "
            'path_frame, base_frame_id and reference_frame_id say what is expected')


def read_odometry(message: Any, frame: str = '', child_frame: str = '') -> tuple[Pose, BodyVelocity]:
    """
    Return pose [m, rad] and body velocity [m/s, rad/s] of a nav_msgs/Odometry; components off the plane are ignored.

    The pose must be in `frame` and the twist in `child_frame` or a frame without a name; '' allows any. Raises
    RefusedMessageError if a number is not finite or beyond LARGEST, the quaternion is not of unit length, or a frame is
    wrong.
    """
    check_frame('frame_id', message.header.frame_id, frame)
    check_frame('child_frame_id', message.child_frame_id or child_frame, child_frame)
    return _motion('odometry', message.pose.pose.position, message.pose.pose.orientation, message.twist.twist)


def _motion(name: str, position: Any, q: Any, twist: Any) -> tuple[Pose, BodyVelocity]:
    """Return the planar part of a position, a quaternion and a twist, checked."""
    check_numbers(name, twist.linear.x, twist.angular.z)
    return _pose(name, position, q), BodyVelocity(twist.linear.x, twist.angular.z)


def _pose(name: str, position: Any, q: Any) -> Pose:
    """Return the planar part of a position and a quaternion, checked."""
    x, y, z, w = q.x, q.y, q.z, q.w
    check_numbers(name, position.x, position.y, x, y, z, w)
    length = x * x + y * y + z * z + w * w
    if abs(length - 1.0) > 0.01:
        raise RefusedMessageError('quaternion not of unit length', f'its length is {math.sqrt(length):g}')
    return Pose(position.x, position.y, _heading(q))


class Link(NamedTuple):
    """The pose of a frame in its parent, with a stamp [ns]."""

    stamp: int
    parent: str
    child: str
    pose: Pose


def read_transforms(messages: Sequence[Any]) -> list[Link]:
    """
    Return the planar part of geometry_msgs/TransformStamped, as `deserialise` returns it.

    Raises RefusedMessageError if a number is not finite or beyond LARGEST, or a quaternion is not of unit length.
    """
    return [Link(one.stamp, one.header.frame_id.lstrip('/'), one.child_frame_id.lstrip('/'),
                 _pose('transform', one.transform.translation, one.transform.rotation)) for one in messages]


def _heading(q: Any) -> float:
    """Return the rotation of a quaternion about the vertical [rad]."""
    return atan2(2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z)


def read_horizon(
    message: Any, ticks: int, period: int, frame: str = '', child_frame: str = ''
) -> tuple[Reference, ...]:
    """
    Return the reference now and at the next ticks of a trajectory_msgs/MultiDOFJointTrajectory.

    Parameters
    ----------
    message : object
        With the fields of the message; of each point, the first transform, velocity and acceleration are used. The
        latter two are in the cart's frame. Surplus points are ignored.
    ticks : int
        Number of points after the present one.
    period : int
        Between two points [ns].
    frame, child_frame : str
        Of the transforms, and of the cart, the first of `joint_names`; '' allows any.

    Raises
    ------
    RefusedMessageError
        If there are too few points, a point is incomplete or has the wrong time, a number is not finite or beyond
        LARGEST, a quaternion is not of unit length, or a frame is wrong.

    """
    check_frame('frame_id', message.header.frame_id, frame)
    check_frame('joint_names[0]', message.joint_names[0] if message.joint_names else '', child_frame)
    if len(message.points) <= ticks:
        raise RefusedMessageError('too few points', f'{len(message.points)}; reference_horizon = {ticks} needs '
                                  f'{ticks + 1}, the first of them now')
    references = []
    for n, point in enumerate(message.points[:ticks + 1]):
        if not (point.transforms and point.velocities and point.accelerations):
            raise RefusedMessageError('a point is not complete',
                                      f'point {n} lacks a transform, a velocity or an acceleration')
        if abs(point.time_from_start - n * period) > _POINT_TOLERANCE:
            raise RefusedMessageError('a point is not of its time', f'point {n} is of {point.time_from_start / 1e9} s '
                                      f'from the start; points are a period of {period / 1e9} s apart')
        transform, acceleration = point.transforms[0], point.accelerations[0]
        pose, velocity = _motion('horizon', transform.translation, transform.rotation, point.velocities[0])
        references.append(Reference(pose, velocity, _acceleration(acceleration)))
    return tuple(references)


def _acceleration(accel: Any) -> BodyAcceleration:
    """Return the planar part of an acceleration, checked."""
    found = BodyAcceleration(accel.linear.x, accel.angular.z)
    check_numbers('acceleration', *found)
    return found


def read_path(message: Any, frame: str = '') -> list[Pose]:
    """
    Return the poses [m], [rad] of a nav_msgs/Path; their stamps are not used, and any orientation is taken.

    `frame` is that of odometry, '' allows any; a header without a frame is in it. Raises RefusedMessageError if a
    number is not finite or beyond LARGEST, or a frame is wrong.
    """
    for header in (message.header, *(pose.header for pose in message.poses)):
        if header.frame_id:
            check_frame('frame_id', header.frame_id, frame)
    for pose in message.poses:
        check_numbers('path', pose.pose.position.x, pose.pose.position.y)
    return [Pose(pose.pose.position.x, pose.pose.position.y, _heading(pose.pose.orientation)) for pose in message.poses]


def read_goal(message: Any, frame: str = '') -> Pose:
    """
    Return the pose of a geometry_msgs/PoseStamped, whose frame is as in `read_path`.

    Raises RefusedMessageError if a number is not finite or beyond LARGEST, or the quaternion is not of unit length.
    """
    if message.header.frame_id:
        check_frame('frame_id', message.header.frame_id, frame)
    return _pose('goal', message.pose.position, message.pose.orientation)


def read_time(message: Any) -> int:
    """Return the time [ns] of a sensor_msgs/TimeReference."""
    return int(message.time_ref)


def numbers_reader(
    name: str, fields: Sequence[str], quantity: Callable[..., Any] = lambda *numbers: numbers, frame: str = ''
) -> Callable[[Any], Any]:
    """
    Make a function that reads numbers from a message with a header.

    Parameters
    ----------
    name : str
        Of the numbers, for refusals.
    fields : sequence of str
        Their places in the message, such as 'accel.linear.x'.
    quantity : callable
        Takes the numbers; by default a tuple has them.
    frame : str
        Of the message, '' allows any; a message without a frame is in it.

    Returns
    -------
    callable
        Takes a message; raises RefusedMessageError if a number is not finite or beyond LARGEST, or the frame is wrong.

    """
    # of one field, attrgetter returns no tuple
    places = attrgetter(*fields) if len(fields) > 1 else lambda message: (attrgetter(*fields)(message),)

    def read(message: Any) -> Any:
        if message.header.frame_id:
            check_frame('frame_id', message.header.frame_id, frame)
        numbers = quantity(*places(message))
        check_numbers(name, *numbers)
        return numbers

    return read


def read_twist(message: Any, frame: str = '') -> BodyVelocity:
    """
    Return the body velocity [m/s, rad/s] of a geometry_msgs/TwistStamped.

    `frame` is the robot's, '' allows any; a message without a frame is in it. Raises RefusedMessageError if a number is
    not finite or beyond LARGEST, or the frame is wrong.
    """
    if message.header.frame_id:
        check_frame('frame_id', message.header.frame_id, frame)
    return read_plain_twist(message.twist)


def read_plain_twist(message: Any) -> BodyVelocity:
    """
    Return the body velocity [m/s, rad/s] of a geometry_msgs/Twist, which has no stamp and no frame.

    Raises RefusedMessageError if a number is not finite or beyond LARGEST.
    """
    velocity = BodyVelocity(message.linear.x, message.angular.z)
    check_numbers('command', *velocity)
    return velocity


def _by_name(message: Any, values: Sequence[float], what: str) -> tuple[float, float]:
    """Return the right and the left wheel's value, found by their names."""
    names = message.name
    if len(values) != len(names):
        raise RefusedMessageError(f'{what} and names differ in number', f'{len(values)} and {len(names)}')
    if names == WHEEL_JOINTS:
        right, left = values
    else:
        try:
            right, left = values[names.index(WHEEL_JOINTS[0])], values[names.index(WHEEL_JOINTS[1])]
        except ValueError:
            raise RefusedMessageError('a wheel is not named',
                                      f'{WHEEL_JOINTS} are not all among {list(names[:9])}') from None
    check_numbers(what, right, left)
    return float(right), float(left)


def read_torque(message: Any) -> WheelTorque:
    """
    Return the wheel torques [N m] of a sensor_msgs/JointState, with the wheels in any order.

    Raises RefusedMessageError if a wheel or its effort is missing, or a torque is not finite or beyond LARGEST.
    """
    return WheelTorque(*_by_name(message, message.effort, 'effort'))


def read_wheel_velocity(message: Any) -> WheelVelocity:
    """
    Return the wheel velocities [rad/s] of a sensor_msgs/JointState, which may contain other joints.

    Raises RefusedMessageError if a wheel or its velocity is missing, or a velocity is not finite or beyond LARGEST.
    """
    return WheelVelocity(*_by_name(message, message.velocity, 'velocity'))


def read_wheel_angles(message: Any) -> tuple[float, float]:
    """
    Return the angles of the right and the left wheel [rad] of a sensor_msgs/JointState.

    Raises RefusedMessageError if a wheel or its position is missing, or an angle is not finite or beyond LARGEST.
    """
    return _by_name(message, message.position, 'position')


def read_wrench(message: Any, frame: str = '') -> Push:
    """
    Return the push [N], [N m] of a geometry_msgs/WrenchStamped: force.x and torque.z.

    `frame` is the robot's, '' allows any; a message without a frame is in it. Raises RefusedMessageError if a number is
    not finite or beyond LARGEST, another component is not zero, or the frame is wrong.
    """
    if message.header.frame_id:
        check_frame('frame_id', message.header.frame_id, frame)
    force, torque = message.wrench.force, message.wrench.torque
    check_numbers('wrench', force.x, force.y, force.z, torque.x, torque.y, torque.z)
    for name, value in (('force.y', force.y), ('force.z', force.z), ('torque.x', torque.x), ('torque.y', torque.y)):
        if value != 0.0:
            raise RefusedMessageError(f'{name} is not zero', f'it is {value:g}; a robot on wheels is pushed by force.x '
                                      'and torque.z in its own frame alone')
    return Push(force.x, torque.z)
