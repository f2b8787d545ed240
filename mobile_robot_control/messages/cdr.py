"""
Deserialisation: messages from CDR, as objects with the fields of the ROS messages.

Reading is written out for the loop's types, three times as fast as a generic reader: a bag of ten minutes holds a
million messages, and rclpy is slower still. Any bytes are safe here; rclpy's own deserialisation reads beyond the end
of a truncated Twist. Tests compare with rosbags and rclpy.
"""

import struct
from collections.abc import Callable
from typing import Any, NamedTuple

from mobile_robot_control.messages.types import (
    AccelStamped,
    DiagnosticArray,
    DiagnosticStatus,
    Header,
    JointState,
    KeyValue,
    MessagePose,
    MultiDOFJointTrajectory,
    Odometry,
    Path,
    PoseStamped,
    PoseWithCovariance,
    Quaternion,
    TimeReference,
    TrajectoryPoint,
    Transform,
    TransformStamped,
    Twist,
    TwistStamped,
    TwistWithCovariance,
    Vector,
    Vector3Stamped,
    Wrench,
    WrenchStamped,
)
from mobile_robot_control.quantities import NANOSECONDS

ENCAPSULATION = b'\x00\x01\x00\x00'
"""The first bytes of plain little-endian CDR."""
START = len(ENCAPSULATION)
"""Alignment is counted from the end of the encapsulation."""
_HEADER = 12
"""Position of the header's frame_id, after its stamp."""


class _Order(NamedTuple):
    """The formats of one byte order."""

    mark: str
    length: struct.Struct
    pose_and_twist: struct.Struct
    seven: struct.Struct
    six: struct.Struct
    three: struct.Struct
    duration: struct.Struct


def _order(mark: str) -> _Order:
    """Return the formats of the byte order '<' or '>'; the covariances, of 36 numbers each, are skipped."""
    return _Order(mark, *(struct.Struct(mark + form) for form in ('I', '7d288x6d', '7d', '6d', '3d', 'iI')))


_ORDERS = {b'\0\1': _order('<'), b'\0\0': _order('>')}


def aligned(at: int, size: int) -> int:
    """Return the next position in serialised bytes that is a multiple of a size."""
    return at + (START - at) % size


def _count(order: _Order, data: bytes, at: int) -> tuple[int, int]:
    """Read an unsigned 32-bit integer; return it and the position after it."""
    at = aligned(at, 4)
    return int(order.length.unpack_from(data, at)[0]), at + 4


def _text(order: _Order, data: bytes, at: int) -> tuple[str, int]:
    """Read a string; return it and the position after it."""
    # its length is read here, not by `_count`: every message has several texts
    at = aligned(at, 4) + 4
    end = at + int(order.length.unpack_from(data, at - 4)[0])
    if end > len(data):
        raise ValueError(f'a text of {end - at} bytes ends behind the message')
    # the last byte is zero
    return data[at:end - 1 if end > at else at].decode(), end


def _texts(order: _Order, data: bytes, at: int) -> tuple[list[str], int]:
    """Read a sequence of strings; return it and the position after it."""
    count, at = _count(order, data, at)
    texts = []
    for _ in range(count):
        entry, at = _text(order, data, at)
        texts.append(entry)
    return texts, at


def _header(order: _Order, data: bytes) -> tuple[Header, int]:
    """Read a header; return it and the position after it."""
    frame, at = _text(order, data, _HEADER)
    return Header(frame), at


def _doubles(order: _Order, data: bytes, at: int) -> tuple[tuple[float, ...], int]:
    """Read a sequence of doubles; return it and the position after it."""
    count, at = _count(order, data, at)
    if count == 0:
        return (), at
    at = aligned(at, 8)
    return struct.unpack_from(f'{order.mark}{count}d', data, at), at + 8 * count


def _joint_state(order: _Order, data: bytes) -> JointState:
    header, at = _header(order, data)
    names, at = _texts(order, data, at)
    position, at = _doubles(order, data, at)
    velocity, at = _doubles(order, data, at)
    effort, _ = _doubles(order, data, at)
    return JointState(header, names, position, velocity, effort)


def _odometry(order: _Order, data: bytes) -> Odometry:
    header, at = _header(order, data)
    child_frame, at = _text(order, data, at)
    x, y, z, qx, qy, qz, qw, *twist = order.pose_and_twist.unpack_from(data, aligned(at, 8))
    pose = MessagePose(Vector(x, y, z), Quaternion(qx, qy, qz, qw))
    return Odometry(header, child_frame, PoseWithCovariance(pose), TwistWithCovariance(_twist(*twist)))


def _twist(vx: float, vy: float, vz: float, wx: float, wy: float, wz: float) -> Twist:
    return Twist(Vector(vx, vy, vz), Vector(wx, wy, wz))


def _plain_twist(order: _Order, data: bytes) -> Twist:
    return _twist(*order.six.unpack_from(data, START))


def _twist_stamped(order: _Order, data: bytes) -> TwistStamped:
    header, at = _header(order, data)
    return TwistStamped(header, _twist(*order.six.unpack_from(data, aligned(at, 8))))


def _accel_stamped(order: _Order, data: bytes) -> AccelStamped:
    header, at = _header(order, data)
    return AccelStamped(header, _twist(*order.six.unpack_from(data, aligned(at, 8))))


def _time_reference(order: _Order, data: bytes) -> TimeReference:
    header, at = _header(order, data)
    seconds, rest = order.duration.unpack_from(data, aligned(at, 4))
    return TimeReference(header, seconds * NANOSECONDS + rest)


def _rows(order: _Order, data: bytes, at: int, form: struct.Struct) -> tuple[tuple[tuple[float, ...], ...], int]:
    """Read a sequence of rows of doubles; return it and the position after it."""
    count, at = _count(order, data, at)
    if count == 0:
        return (), at
    at = aligned(at, 8)
    end = at + count * form.size
    if end > len(data):
        raise ValueError(f'{count} rows end behind the message')
    return tuple(form.iter_unpack(data[at:end])), end


def _trajectory(order: _Order, data: bytes) -> MultiDOFJointTrajectory:
    header, at = _header(order, data)
    names, at = _texts(order, data, at)
    count, at = _count(order, data, at)
    points = []
    for _ in range(count):
        transforms, at = _rows(order, data, at, order.seven)
        velocities, at = _rows(order, data, at, order.six)
        accelerations, at = _rows(order, data, at, order.six)
        at = aligned(at, 4) + order.duration.size
        seconds, rest = order.duration.unpack_from(data, at - order.duration.size)
        points.append(TrajectoryPoint(
            tuple(Transform(Vector(*row[:3]), Quaternion(*row[3:])) for row in transforms),
            tuple(_twist(*row) for row in velocities), tuple(_twist(*row) for row in accelerations),
            seconds * NANOSECONDS + rest))
    return MultiDOFJointTrajectory(header, names, tuple(points))


def _wrench_stamped(order: _Order, data: bytes) -> WrenchStamped:
    header, at = _header(order, data)
    fx, fy, fz, tx, ty, tz = order.six.unpack_from(data, aligned(at, 8))
    return WrenchStamped(header, Wrench(Vector(fx, fy, fz), Vector(tx, ty, tz)))


def _path(order: _Order, data: bytes) -> Path:
    header, at = _header(order, data)
    count, at = _count(order, data, at)
    poses = []
    for _ in range(count):
        # after the pose's stamp
        frame, at = _text(order, data, aligned(at, 4) + 8)
        at = aligned(at, 8) + order.seven.size
        x, y, z, qx, qy, qz, qw = order.seven.unpack_from(data, at - order.seven.size)
        poses.append(PoseStamped(Header(frame), MessagePose(Vector(x, y, z), Quaternion(qx, qy, qz, qw))))
    return Path(header, poses)


def path_stamps(data: bytes) -> list[int]:
    """Return the stamps of the poses of a nav_msgs/Path in plain CDR that `deserialise` reads [ns]."""
    order = _ORDERS[data[:2]]
    count, at = _count(order, data, _header(order, data)[1])
    stamps = []
    for _ in range(count):
        at = aligned(at, 4)
        seconds, nanoseconds = order.duration.unpack_from(data, at)
        stamps.append(seconds * NANOSECONDS + nanoseconds)
        at = aligned(_text(order, data, at + order.duration.size)[1], 8) + order.seven.size
    return stamps


def _pose_stamped(order: _Order, data: bytes) -> PoseStamped:
    header, at = _header(order, data)
    x, y, z, qx, qy, qz, qw = order.seven.unpack_from(data, aligned(at, 8))
    return PoseStamped(header, MessagePose(Vector(x, y, z), Quaternion(qx, qy, qz, qw)))


def _transform_at(order: _Order, data: bytes, at: int) -> tuple[TransformStamped, int]:
    """Read a stamped transform; return it and the position after it."""
    at = aligned(at, 4)
    seconds, nanoseconds = order.duration.unpack_from(data, at)
    frame, at = _text(order, data, at + order.duration.size)
    child, at = _text(order, data, at)
    at = aligned(at, 8) + order.seven.size
    x, y, z, qx, qy, qz, qw = order.seven.unpack_from(data, at - order.seven.size)
    return TransformStamped(seconds * NANOSECONDS + nanoseconds, Header(frame), child,
                            Transform(Vector(x, y, z), Quaternion(qx, qy, qz, qw))), at


def _transform_stamped(order: _Order, data: bytes) -> TransformStamped:
    return _transform_at(order, data, START)[0]


def _transforms(order: _Order, data: bytes) -> list[TransformStamped]:
    count, at = _count(order, data, START)
    transforms = []
    for _ in range(count):
        transform, at = _transform_at(order, data, at)
        transforms.append(transform)
    return transforms


def _vector_stamped(order: _Order, data: bytes) -> Vector3Stamped:
    header, at = _header(order, data)
    return Vector3Stamped(header, Vector(*order.three.unpack_from(data, aligned(at, 8))))


def _string(order: _Order, data: bytes) -> str:
    return _text(order, data, START)[0]


def _diagnostic_array(order: _Order, data: bytes) -> DiagnosticArray:
    header, at = _header(order, data)
    statuses = []
    count, at = _count(order, data, at)
    for _ in range(count):
        # a byte is the level
        name, at = _text(order, data, at + 1)
        message, at = _text(order, data, at)
        _, at = _text(order, data, at)
        pairs, at = _count(order, data, at)
        values = []
        for _ in range(pairs):
            key, at = _text(order, data, at)
            value, at = _text(order, data, at)
            values.append(KeyValue(key, value))
        statuses.append(DiagnosticStatus(name, message, tuple(values)))
    return DiagnosticArray(header, tuple(statuses))


_READ: dict[str, Callable[[_Order, bytes], Any]] = {
    'sensor_msgs/msg/JointState': _joint_state,
    'nav_msgs/msg/Odometry': _odometry,
    'nav_msgs/msg/Path': _path,
    'geometry_msgs/msg/Twist': _plain_twist,
    'geometry_msgs/msg/TwistStamped': _twist_stamped,
    'geometry_msgs/msg/AccelStamped': _accel_stamped,
    'trajectory_msgs/msg/MultiDOFJointTrajectory': _trajectory,
    'sensor_msgs/msg/TimeReference': _time_reference,
    'geometry_msgs/msg/Vector3Stamped': _vector_stamped,
    'geometry_msgs/msg/WrenchStamped': _wrench_stamped,
    'diagnostic_msgs/msg/DiagnosticArray': _diagnostic_array,
    'std_msgs/msg/String': _string,
    'geometry_msgs/msg/PoseStamped': _pose_stamped,
    'geometry_msgs/msg/TransformStamped': _transform_stamped,
    'tf2_msgs/msg/TFMessage': _transforms,
}


def deserialise(kind: str, data: bytes) -> Any:
    """
    Read a message from plain CDR, of either byte order.

    Parameters
    ----------
    kind : str
        One of the loop's types, Twist, PoseStamped, TransformStamped or WrenchStamped of geometry_msgs,
        'nav_msgs/msg/Path', 'tf2_msgs/msg/TFMessage', 'diagnostic_msgs/msg/DiagnosticArray' or 'std_msgs/msg/String'.
    data : bytes
        From any source.

    Returns
    -------
    NamedTuple
        With the message's fields, without stamp and covariances; a String's text, a TFMessage's list.

    Raises
    ------
    ValueError
        If the bytes are no such message.

    """
    order = _ORDERS.get(data[:2])
    if order is None:
        raise ValueError('not plain CDR')
    try:
        return _READ[kind](order, data)
    except struct.error as error:
        raise ValueError(str(error)) from error
