"""What a bag holds, whoever reads it: messages, and the changes of runs among them."""

import json
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, read_or_refuse, serialised_stamp
from mobile_robot_control.messages.types import DiagnosticArray
from mobile_robot_control.topics import RUN_KEY

ProgressCallback = Callable[[int, int], None]
"""Takes the amount read, and the total."""
RESET = 'reset'
"""Key of a change that ends a run, and begins another one."""


class BagError(ValueError):
    """A path that is no bag; the text names it, and what to name instead."""


class Message(NamedTuple):
    """
    A recorded message.

    Attributes
    ----------
    topic : str
        Absolute name.
    kind : str
        Type, such as 'nav_msgs/msg/Odometry'.
    received : int
        Wall time of receipt [ns].
    data : bytes
        CDR.

    """

    topic: str
    kind: str
    received: int
    data: bytes


class Change(NamedTuple):
    """
    Changes that a node applied together.

    Attributes
    ----------
    stamp : int
        The first affected stamp [ns].
    node : str
        Its name, without a namespace.
    run : int
        Run of the node, counted from 0.
    values : dict of str to object
        By key.

    """

    stamp: int
    node: str
    run: int
    values: dict[str, Any]


def read_change(message: Message) -> Change:
    """Return the change in a message on `events`; raise BagError if it is none."""
    try:
        return Change(serialised_stamp(message.data), *read_or_refuse(
            message.kind, (partial(deserialise, message.kind), _read_statuses), message.data))
    except RefusedMessageError as refusal:
        raise BagError(f'a message on {message.topic} is no change of a run: {refusal}; it is of another publisher, or '
                       'of another version of this package') from None


def _read_statuses(array: DiagnosticArray) -> tuple[str, int, dict[str, Any]]:
    """Return node, run and changes."""
    (node, run), = {(status.name.rpartition('/')[2], int(dict(status.values)[RUN_KEY])) for status in array.status}
    return node, run, {status.values[0].key: json.loads(status.values[0].value) for status in array.status}
