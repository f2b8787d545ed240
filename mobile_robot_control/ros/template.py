"""Messages as bytes, of which a stamp and some numbers are written anew each time."""

import itertools
import math
import struct
from collections.abc import Callable
from typing import Any

from mobile_robot_control.cdr import ENCAPSULATION, serialise

_DOUBLE, _STAMP = struct.Struct('<d'), struct.Struct('<iI')
_NANOSECONDS = 1_000_000_000


class Template:
    """
    A serialised message whose stamp and numbers can be replaced.

    To publish bytes spares rclpy the conversion to C. Its own `serialize_message` leaves bytes behind the end, and
    whatever it finds between the numbers.

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
        self._data = serialise(message)
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
            _STAMP.pack_into(data, len(ENCAPSULATION), *divmod(stamp, _NANOSECONDS))
        for pack_into, place, part in self._runs:
            pack_into(data, place, *numbers[part])
        return bytes(data)
