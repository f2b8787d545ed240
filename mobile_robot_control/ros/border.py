"""The border of a node: what of the messages that arrive it takes, and what it refuses."""

from collections import Counter
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from rclpy.node import Node
from rclpy.serialization import deserialize_message

from mobile_robot_control.cdr import deserialise, plain
from mobile_robot_control.configuration import Shared, period_nanoseconds
from mobile_robot_control.readings import Refused, serialised_stamp
from mobile_robot_control.ros.lockstep import StampGate, Turn
from mobile_robot_control.ros.peers import Peers
from mobile_robot_control.ros.wall_clock import ClockGate


class Gate(Protocol):
    """What judges stamps: StampGate or Pace in lockstep, ClockGate on the wall clock."""

    def judge(self, stamp: int) -> Turn:
        """Say what a stamp [ns] means."""

    def objection(self, stamp: int) -> Refused:
        """Say why a stamp [ns] is refused."""


def make_gate(node: Node, shared: Shared, rate: float) -> StampGate | ClockGate:
    """
    Make what judges the stamps of a node's inputs.

    Parameters
    ----------
    node : Node
        Whose inputs.
    shared : Shared
        Says which clock there is.
    rate : float
        Of the node's grid in lockstep [Hz].

    Returns
    -------
    StampGate or ClockGate
        For :meth:`Border.admit`.

    """
    return StampGate(period_nanoseconds(rate)) if shared.lockstep else ClockGate(node, shared.stamp_tolerance)


def reader(kind: type, read: Callable[[Any], Any]) -> Callable[[bytes], Any]:
    """
    Make a function that reads a message from its bytes, without the object that rclpy would make of it.

    Parameters
    ----------
    kind : type
        One of the loop's message types.
    read : callable
        Gives what such a message says, or raises Refused.

    Returns
    -------
    callable
        Takes bytes; raises Refused where they are no such message, too.

    """
    name = f'{kind.__module__.partition(".")[0]}/msg/{kind.__name__}'

    def read_bytes(message: bytes) -> Any:
        try:
            # rclpy knows every encoding
            found = deserialise(name, message) if plain(message) else deserialize_message(message, kind)
        except Exception as error:  # rclpy raises a bare RCLError
            raise Refused('not readable', f'{error}; it is no {name}') from None
        return read(found)

    return read_bytes


class Admitted(NamedTuple):
    """
    A message that was taken.

    Attributes
    ----------
    stamp : int
        [ns].
    turn : Turn
        What the stamp means.
    value : object
        What the message says.

    """

    stamp: int
    turn: Turn
    value: Any


class Border:
    """
    Takes messages whose stamp and content are right, counts the others by reason and warns about them, not too often.

    Parameters
    ----------
    node : Node
        Whose border it is.
    peers : Peers
        Told of what is taken; what is refused changes nothing, no timeout either.

    Attributes
    ----------
    refused : Counter of str
        How many messages were refused, by 'topic: reason'.

    """

    def __init__(self, node: Node, peers: Peers) -> None:
        self._node, self._peers = node, peers
        self.refused: Counter[str] = Counter()

    def admit(self, topic: str, message: bytes, read: Callable[[bytes], Any], gate: Gate) -> Admitted | None:
        """
        Take a message or refuse it.

        Parameters
        ----------
        topic : str
            Where it came from.
        message : bytes
            Serialised, with a header.
        read : callable
            Gives what it says, or raises Refused; see :func:`reader`.
        gate : Gate
            Judges its stamp.

        Returns
        -------
        Admitted or None
            None where it was refused.

        """
        try:
            stamp = serialised_stamp(message)
            turn = gate.judge(stamp)
            if turn is Turn.REFUSED:
                raise gate.objection(stamp)
            value = read(message)
        except Refused as refusal:
            self.refused[f'{topic}: {refusal.reason}'] += 1
            self._node.get_logger().warning(f'refused a message on {topic}: {refusal}', throttle_duration_sec=2.0)
            return None
        self._peers.heard(topic)
        return Admitted(stamp, turn, value)
