"""Messages of rclpy written as CDR; `messages.cdr` reads them."""

import struct
from array import array
from typing import Any

from mobile_robot_control.messages.cdr import ENCAPSULATION, aligned

_COUNT, _DOUBLE = struct.Struct('<I'), struct.Struct('<d')


def _put(data: bytearray, number: struct.Struct, value: float) -> None:
    """Append a number at a multiple of its size."""
    data += bytes(aligned(len(data), number.size) - len(data))
    data += number.pack(value)


def _write(data: bytearray, value: Any) -> None:
    """Append a field of one of the types in the loop's messages."""
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

    Its fields may be texts, floats, 32-bit integers and arrays of texts and floats. rclpy's own serialisation adds
    bytes at the end, and leaves uninitialised memory in the gaps.
    """
    data = bytearray(ENCAPSULATION)
    _write(data, message)
    return data
