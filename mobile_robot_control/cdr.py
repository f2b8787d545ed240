"""
The loop's messages from their serialised form (CDR), as objects with the fields of the ROS messages, and back.

Reading is written out for four types, because it is three times as fast as what works for every type: a bag of ten
minutes holds a million messages, and rclpy is slower still. Tests compare both ways with rosbags and rclpy.
"""

import struct
from array import array
from collections.abc import Callable
from typing import Any, NamedTuple

ENCAPSULATION = b'\x00\x01\x00\x00'
"""What plain little-endian CDR begins with."""
_START = len(ENCAPSULATION)
"""Alignment is counted from behind the encapsulation."""
_HEADER = 12
"""Where the header's frame stands: behind its stamp."""
_COUNT, _DOUBLE = struct.Struct('<I'), struct.Struct('<d')
_POSE_AND_TWIST = struct.Struct('<7d288x6d')  # the covariances, of 36 numbers each, are passed over
_SIX = struct.Struct('<6d')
_THREE = struct.Struct('<3d')


class Header(NamedTuple):
    """Of std_msgs, without its stamp."""

    frame_id: str


class JointState(NamedTuple):
    """Of sensor_msgs."""

    header: Header
    name: list[str]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    effort: tuple[float, ...]


class Vector(NamedTuple):
    """Point and Vector3 of geometry_msgs."""

    x: float
    y: float
    z: float


class Quaternion(NamedTuple):
    """Of geometry_msgs."""

    x: float
    y: float
    z: float
    w: float


class Pose(NamedTuple):
    """Of geometry_msgs."""

    position: Vector
    orientation: Quaternion


class Twist(NamedTuple):
    """Of geometry_msgs."""

    linear: Vector
    angular: Vector


class Posed(NamedTuple):
    """PoseWithCovariance of geometry_msgs, without its covariance."""

    pose: Pose


class Twisted(NamedTuple):
    """TwistWithCovariance of geometry_msgs, without its covariance."""

    twist: Twist


class TwistStamped(NamedTuple):
    """Of geometry_msgs."""

    header: Header
    twist: Twist


class Odometry(NamedTuple):
    """Of nav_msgs."""

    header: Header
    child_frame_id: str
    pose: Posed
    twist: Twisted


class VectorStamped(NamedTuple):
    """Vector3Stamped of geometry_msgs."""

    header: Header
    vector: Vector


def _aligned(at: int, size: int) -> int:
    return at + (_START - at) % size


def _count(data: bytes, at: int) -> tuple[int, int]:
    at = _aligned(at, 4)
    return int(_COUNT.unpack_from(data, at)[0]), at + 4


def _text(data: bytes, at: int) -> tuple[str, int]:
    length, at = _count(data, at)
    # the last byte is zero
    return data[at:at + length - 1].decode(), at + length


def _header(data: bytes) -> tuple[Header, int]:
    frame, at = _text(data, _HEADER)
    return Header(frame), at


def _doubles(data: bytes, at: int) -> tuple[tuple[float, ...], int]:
    count, at = _count(data, at)
    if count == 0:
        return (), at
    at = _aligned(at, 8)
    return struct.unpack_from(f'<{count}d', data, at), at + 8 * count


def _joint_state(data: bytes) -> JointState:
    header, at = _header(data)
    count, at = _count(data, at)
    names = []
    for _ in range(count):
        name, at = _text(data, at)
        names.append(name)
    position, at = _doubles(data, at)
    velocity, at = _doubles(data, at)
    effort, _ = _doubles(data, at)
    return JointState(header, names, position, velocity, effort)


def _odometry(data: bytes) -> Odometry:
    header, at = _header(data)
    child_frame, at = _text(data, at)
    x, y, z, qx, qy, qz, qw, *twist = _POSE_AND_TWIST.unpack_from(data, _aligned(at, 8))
    pose = Pose(Vector(x, y, z), Quaternion(qx, qy, qz, qw))
    return Odometry(header, child_frame, Posed(pose), Twisted(_twist(*twist)))


def _twist(vx: float, vy: float, vz: float, wx: float, wy: float, wz: float) -> Twist:
    return Twist(Vector(vx, vy, vz), Vector(wx, wy, wz))


def _twist_stamped(data: bytes) -> TwistStamped:
    header, at = _header(data)
    return TwistStamped(header, _twist(*_SIX.unpack_from(data, _aligned(at, 8))))


def _vector_stamped(data: bytes) -> VectorStamped:
    header, at = _header(data)
    return VectorStamped(header, Vector(*_THREE.unpack_from(data, _aligned(at, 8))))


_READ: dict[str, Callable[[bytes], Any]] = {
    'sensor_msgs/msg/JointState': _joint_state,
    'nav_msgs/msg/Odometry': _odometry,
    'geometry_msgs/msg/TwistStamped': _twist_stamped,
    'geometry_msgs/msg/Vector3Stamped': _vector_stamped,
}


def plain(data: bytes) -> bool:
    """
    Say whether a message is encoded as all are that come from a machine of our days.

    Parameters
    ----------
    data : bytes
        Serialised.

    Returns
    -------
    bool
        True for little-endian CDR.

    """
    return data[:2] == ENCAPSULATION[:2]


def deserialise(kind: str, data: bytes) -> Any:
    """
    Read a message.

    Parameters
    ----------
    kind : str
        Type, one of those of the loop's topics.
    data : bytes
        CDR, little endian.

    Returns
    -------
    NamedTuple
        With the message's fields, but for stamp and covariances.

    Raises
    ------
    ValueError
        If the bytes are no such message.

    """
    if not plain(data):
        raise ValueError('not little-endian CDR')
    try:
        return _READ[kind](data)
    except struct.error as error:
        raise ValueError(str(error)) from error


def _put(data: bytearray, number: struct.Struct, value: float) -> None:
    """Write a number at a multiple of its size."""
    data += bytes(_aligned(len(data), number.size) - len(data))
    data += number.pack(value)


def _write(data: bytearray, value: Any) -> None:
    """Write a field of the types that the loop's messages have, in CDR."""
    if isinstance(value, str):
        text = value.encode() + b'\0'
        _put(data, _COUNT, len(text))
        data += text
    elif isinstance(value, float):
        _put(data, _DOUBLE, value)
    elif isinstance(value, int):
        _put(data, _COUNT, value)
    elif hasattr(value, 'get_fields_and_field_types'):
        for field in value.get_fields_and_field_types():
            _write(data, getattr(value, field))
    else:
        # rclpy's arrays of fixed length are NumPy's, and say no length
        if isinstance(value, list | array):
            _put(data, _COUNT, len(value))
        for element in value:
            _write(data, element)


def serialise(message: Any) -> bytearray:
    """
    Write a message.

    Parameters
    ----------
    message : ROS message
        As rclpy makes it, of texts, floats, 32-bit integers and arrays of texts and floats.

    Returns
    -------
    bytearray
        CDR, little endian. rclpy's own serialisation leaves bytes behind the end, and in the gaps what it finds there.

    """
    data = bytearray(ENCAPSULATION)
    _write(data, message)
    return data
