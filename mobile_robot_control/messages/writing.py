"""
Quantities to messages; `mobile_robot_control.messages.parsing` is the inverse.

A node makes a writer for each of its messages once; at every step it publishes the bytes that the writer returns.
"""

import importlib
import itertools
import math
import struct
from array import array
from collections.abc import Callable, Iterable, Sequence
from operator import attrgetter
from struct import pack_into
from typing import Any

from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped, Transform, Twist, TwistStamped, WrenchStamped
from nav_msgs.msg import Odometry, Path
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, TimeReference

from mobile_robot_control.elementary import sin_cos
from mobile_robot_control.messages.cdr import ENCAPSULATION, aligned
from mobile_robot_control.quantities import (
    NANOSECONDS,
    BodyVelocity,
    Pose,
    Push,
    Reference,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.topics import WHEEL_JOINTS

_COUNT, _DOUBLE = struct.Struct('<I'), struct.Struct('<d')


def _put(data: bytearray, number: struct.Struct, value: float) -> None:
    """Append a number at a multiple of its size."""
    data += bytes(aligned(len(data), number.size) - len(data))
    data += number.pack(value)


def _write(data: bytearray, value: Any) -> None:
    """Append a field of one of the types in the loop's messages."""
    if isinstance(value, str):
        encoded = value.encode() + b'\0'
        _put(data, _COUNT, len(encoded))
        data += encoded
    elif isinstance(value, float):
        _put(data, _DOUBLE, value)
    elif isinstance(value, int):
        _put(data, _COUNT, value)
    elif hasattr(value, 'get_fields_and_field_types'):
        for field in value.get_fields_and_field_types():
            _write(data, getattr(value, field))
    else:
        # rclpy's arrays of fixed length are NumPy's, and CDR stores no length for them
        if isinstance(value, list | array):
            _put(data, _COUNT, len(value))
        for element in value:
            _write(data, element)


def serialise(message: object) -> bytearray:
    """
    Write a message of rclpy as little-endian CDR.

    Its fields may be texts, floats, 32-bit integers and arrays of texts and floats. rclpy's own serialisation adds
    bytes at the end, and leaves uninitialised memory in the gaps.
    """
    data = bytearray(ENCAPSULATION)
    _write(data, message)
    return data


_STAMP = struct.Struct('<iI')


def message_class(kind: str) -> Any:
    """Return the rclpy class of a message type such as 'nav_msgs/msg/Odometry'."""
    package, _, name = kind.split('/')
    return getattr(importlib.import_module(f'{package}.msg'), name)


class Template:
    """
    A serialised message with a replaceable stamp and numbers.

    Publishing bytes saves rclpy the conversion to C.

    Parameters
    ----------
    message : ROS message
        The constant part. If its first field is a header or a time, the stamp there is replaced.
    put : callable
        Writes numbers into the variable fields of the message.
    count : int
        Count of the variable numbers.

    """

    def __init__(self, message: object, put: Callable[..., None], count: int) -> None:
        # once, at the start of a node: numbers that occur nowhere else in a message mark the variable fields
        marks = [math.pi * 1e200 * (n + 1) for n in range(count)]
        put(*marks)
        self._data = serialise(message)
        self._stamped = hasattr(message, 'header') or hasattr(message, 'clock')
        places = [self._data.index(_DOUBLE.pack(mark)) for mark in marks]
        starts = [n for n in range(count) if n == 0 or places[n] != places[n - 1] + _DOUBLE.size]
        self._parts = [(struct.Struct(f'<{end - start}d').pack_into, places[start], slice(start, end))
                      for start, end in itertools.pairwise([*starts, count])]

    def fill(self, stamp: int, *numbers: float) -> bytes:
        """Return the message's bytes with a stamp [ns], if it has a header, and numbers in the order of `put`."""
        data = self._data
        if self._stamped:
            _STAMP.pack_into(data, len(ENCAPSULATION), *divmod(stamp, NANOSECONDS))
        for pack, place, part in self._parts:
            pack(data, place, *numbers[part])
        return bytes(data)


def planar_quaternion(heading: float) -> tuple[float, float]:
    """Return z and w of the quaternion of a rotation [rad] about the vertical; x and y are zero."""
    return sin_cos(0.5 * heading)


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


def numbers_writer(kind: str, fields: Sequence[str], frame: str) -> Callable[[int, Iterable[float]], bytes]:
    """
    Make a function that writes numbers into a message with a header.

    Parameters
    ----------
    kind : str
        Type of the message, such as 'geometry_msgs/msg/AccelStamped'.
    fields : sequence of str
        Places of the numbers in the message, such as 'accel.linear.x'.
    frame : str
        Of the message.

    Returns
    -------
    callable
        Takes a stamp [ns] and the numbers; returns bytes.

    """
    message = message_class(kind)()
    message.header.frame_id = frame

    def put(*numbers: float) -> None:
        for field, number in zip(fields, numbers, strict=True):
            owner, _, name = field.rpartition('.')
            setattr(attrgetter(owner)(message), name, number)

    template = Template(message, put, len(fields))
    return lambda stamp, numbers: template.fill(stamp, *numbers)


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
