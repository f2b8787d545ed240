"""
The loop's messages from their serialised form (CDR), as objects with the fields of the ROS messages, and back.

Reading is written out for five types, because that is three times as fast as a reader for every type: a bag of ten
minutes holds a million messages, and rclpy is slower still. Tests compare both ways with rosbags and rclpy.
"""

import struct
from array import array
from collections.abc import Callable
from typing import Any

from mobile_robot_control.messages.types import (
    Header,
    JointState,
    MessagePose,
    Odometry,
    PoseWithCovariance,
    Quaternion,
    Twist,
    TwistStamped,
    TwistWithCovariance,
    Vector,
    Vector3Stamped,
)

ENCAPSULATION = b'\x00\x01\x00\x00'
"""The first bytes of plain little-endian CDR."""
_START = len(ENCAPSULATION)
"""Alignment is counted from the end of the encapsulation."""
_HEADER = 12
"""Position of the header's frame_id: behind its stamp."""
_COUNT, _DOUBLE = struct.Struct('<I'), struct.Struct('<d')
_POSE_AND_TWIST = struct.Struct('<7d288x6d')  # the covariances, of 36 numbers each, are skipped
_SIX = struct.Struct('<6d')
_THREE = struct.Struct('<3d')


def _aligned(at: int, size: int) -> int:
    """Return the next position that is a multiple of a size."""
    return at + (_START - at) % size


def _count(data: bytes, at: int) -> tuple[int, int]:
    """Read an unsigned 32-bit integer; return it and the position behind it."""
    at = _aligned(at, 4)
    return int(_COUNT.unpack_from(data, at)[0]), at + 4


def _text(data: bytes, at: int) -> tuple[str, int]:
    """Read a string; return it and the position behind it."""
    length, at = _count(data, at)
    # the last byte is zero
    return data[at:at + length - 1].decode(), at + length


def _header(data: bytes) -> tuple[Header, int]:
    """Read a header; return it and the position behind it."""
    frame, at = _text(data, _HEADER)
    return Header(frame), at


def _doubles(data: bytes, at: int) -> tuple[tuple[float, ...], int]:
    """Read a sequence of doubles; return it and the position behind it."""
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
    pose = MessagePose(Vector(x, y, z), Quaternion(qx, qy, qz, qw))
    return Odometry(header, child_frame, PoseWithCovariance(pose), TwistWithCovariance(_twist(*twist)))


def _twist(vx: float, vy: float, vz: float, wx: float, wy: float, wz: float) -> Twist:
    return Twist(Vector(vx, vy, vz), Vector(wx, wy, wz))


def _plain_twist(data: bytes) -> Twist:
    return _twist(*_SIX.unpack_from(data, _START))


def _twist_stamped(data: bytes) -> TwistStamped:
    header, at = _header(data)
    return TwistStamped(header, _twist(*_SIX.unpack_from(data, _aligned(at, 8))))


def _vector_stamped(data: bytes) -> Vector3Stamped:
    header, at = _header(data)
    return Vector3Stamped(header, Vector(*_THREE.unpack_from(data, _aligned(at, 8))))


_READ: dict[str, Callable[[bytes], Any]] = {
    'sensor_msgs/msg/JointState': _joint_state,
    'nav_msgs/msg/Odometry': _odometry,
    'geometry_msgs/msg/Twist': _plain_twist,
    'geometry_msgs/msg/TwistStamped': _twist_stamped,
    'geometry_msgs/msg/Vector3Stamped': _vector_stamped,
}


def is_little_endian(data: bytes) -> bool:
    """Return whether a serialised message is little-endian CDR, as common machines write it."""
    return data[:2] == ENCAPSULATION[:2]


def deserialise(kind: str, data: bytes) -> Any:
    """
    Read a message of one of the loop's types, or a Twist, from little-endian CDR.

    Returns a NamedTuple with the message's fields, without stamp and covariances. Raises ValueError if the bytes are no
    such message.
    """
    if not is_little_endian(data):
        raise ValueError('not little-endian CDR')
    try:
        return _READ[kind](data)
    except struct.error as error:
        raise ValueError(str(error)) from error


def _put(data: bytearray, number: struct.Struct, value: float) -> None:
    """Append a number at a multiple of its size."""
    data += bytes(_aligned(len(data), number.size) - len(data))
    data += number.pack(value)


def _write(data: bytearray, value: Any) -> None:
    """Append a field of one of the types that the loop's messages have."""
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
        # rclpy's arrays of fixed length are NumPy's, and CDR stores no length for them
        if isinstance(value, list | array):
            _put(data, _COUNT, len(value))
        for element in value:
            _write(data, element)


def serialise(message: Any) -> bytearray:
    """
    Write a message of rclpy as little-endian CDR.

    It may hold texts, floats, 32-bit integers and arrays of texts and floats. rclpy's own serialisation leaves bytes
    behind the end, and uninitialised memory in the gaps.
    """
    data = bytearray(ENCAPSULATION)
    _write(data, message)
    return data
