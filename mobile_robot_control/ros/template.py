"""Messages as bytes, of which a stamp and some numbers are written anew each time."""

import itertools
import math
import struct
from array import array
from collections.abc import Callable
from typing import Any

_ENCAPSULATION = b'\x00\x01\x00\x00'  # plain CDR, little endian
_DOUBLE, _UNSIGNED, _STAMP = struct.Struct('<d'), struct.Struct('<I'), struct.Struct('<iI')
_NANOSECONDS = 1_000_000_000


def _align(data: bytearray, number: struct.Struct, value: float) -> None:
    """Write a number at a multiple of its size."""
    data += bytes(-(len(data) - len(_ENCAPSULATION)) % number.size)
    data += number.pack(value)


def _write(data: bytearray, value: Any) -> None:
    """Write a field of the types that the loop's messages have, in CDR."""
    if isinstance(value, str):
        text = value.encode() + b'\0'
        _align(data, _UNSIGNED, len(text))
        data += text
    elif isinstance(value, float):
        _align(data, _DOUBLE, value)
    elif isinstance(value, int):
        _align(data, _UNSIGNED, value)
    elif hasattr(value, 'get_fields_and_field_types'):
        for field in value.get_fields_and_field_types():
            _write(data, getattr(value, field))
    else:
        # rclpy's arrays of fixed length are NumPy's, and say no length
        if isinstance(value, list | array):
            _align(data, _UNSIGNED, len(value))
        for element in value:
            _write(data, element)


class Template:
    """
    A serialised message whose stamp and numbers can be replaced.

    rclpy takes three times as long to convert a message to C and serialise it as to publish bytes, and its
    `serialize_message` leaves bytes behind the end and whatever it finds between the numbers.

    Parameters
    ----------
    message : ROS message
        All that stays. If its first field is a header or a time, the stamp there is written anew.
    put : callable
        Writes numbers into the fields of the message that change.
    count : int
        Of the numbers.

    """

    def __init__(self, message: Any, put: Callable[..., None], count: int) -> None:
        # numbers that nothing else in a message is, to see where they lie
        marks = [math.pi * 1e200 * (n + 1) for n in range(count)]
        put(*marks)
        self._data = bytearray(_ENCAPSULATION)
        _write(self._data, message)
        self._stamped = hasattr(message, 'header') or hasattr(message, 'clock')
        places = [self._data.index(_DOUBLE.pack(mark)) for mark in marks]
        starts = [n for n in range(count) if n == 0 or places[n] != places[n - 1] + _DOUBLE.size]
        self._runs = [(struct.Struct(f'<{end - start}d').pack_into, places[start], slice(start, end))
                      for start, end in itertools.pairwise([*starts, count])]

    def fill(self, stamp: int, *numbers: float) -> bytes:
        """
        Write a stamp and numbers.

        Parameters
        ----------
        stamp : int
            [ns]; a message without a header leaves it out.
        *numbers : float
            In the order of `put`.

        Returns
        -------
        bytes
            To be published.

        """
        data = self._data
        if self._stamped:
            _STAMP.pack_into(data, len(_ENCAPSULATION), *divmod(stamp, _NANOSECONDS))
        for pack_into, place, part in self._runs:
            pack_into(data, place, *numbers[part])
        return bytes(data)
