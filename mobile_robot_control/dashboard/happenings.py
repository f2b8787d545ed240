"""What has changed the run, from the topic `events`; others may publish there as well, whatever they like."""

from collections import deque
from functools import partial
from typing import Any

from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, read_or_refuse, serialised_stamp
from mobile_robot_control.texts import shortened

_KIND = 'diagnostic_msgs/msg/DiagnosticArray'
_KEPT = 12


class Happenings:
    """The last changes: parameters, resets, pushes, each with the first stamp that it affects."""

    def __init__(self) -> None:
        self._kept: deque[dict[str, Any]] = deque(maxlen=_KEPT)

    def take(self, message: bytes) -> None:
        """Take in a message; one that is not readable changes nothing."""
        try:
            stamp = serialised_stamp(message)
            array = read_or_refuse(_KIND, (partial(deserialise, _KIND),), message)
        except RefusedMessageError:
            return
        for status in array.status[:_KEPT]:
            self._kept.append({'stamp': stamp / 1e9, 'node': shortened(status.name, 100),
                               'text': shortened(status.message, 200)})

    def newest_first(self) -> list[dict[str, Any]]:
        """Return them with stamp [s], node and text, as JSON has them."""
        return list(reversed(self._kept))
