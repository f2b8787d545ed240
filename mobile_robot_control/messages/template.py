"""Serialised messages with a replaceable stamp and numbers."""

import itertools
import math
import struct
from collections.abc import Callable
from typing import Any

from mobile_robot_control.messages.cdr import ENCAPSULATION
from mobile_robot_control.messages.serialising import serialise
from mobile_robot_control.stamps import NANOSECONDS

_DOUBLE, _STAMP = struct.Struct('<d'), struct.Struct('<iI')


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

    def __init__(self, message: Any, put: Callable[..., None], count: int) -> None:
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
        for pack_into, place, part in self._parts:
            pack_into(data, place, *numbers[part])
        return bytes(data)
