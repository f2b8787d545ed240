"""The border of a node: what of the messages that arrive it takes, and what it refuses."""

from collections import Counter
from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy.node import Node

from mobile_robot_control.readings import Refused, nanoseconds
from mobile_robot_control.ros.lockstep import StampGate, Turn
from mobile_robot_control.ros.peers import Peers
from mobile_robot_control.ros.wall_clock import OpenGate


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
        What the message says; None where it asks again.

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

    Attributes
    ----------
    refused : Counter of str
        How many messages were refused, by 'topic: reason'.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.refused: Counter[str] = Counter()

    def admit(
        self, topic: str, message: Any, read: Callable[[Any], Any], gate: StampGate | OpenGate, peers: Peers
    ) -> Admitted | None:
        """
        Take a message or refuse it; what is refused changes nothing, no timeout either.

        Parameters
        ----------
        topic : str
            Where it came from.
        message : ROS message
            With a header.
        read : callable
            Gives what it says, or raises Refused.
        gate : StampGate or OpenGate
            Judges its stamp.
        peers : Peers
            Told of it when it is taken.

        Returns
        -------
        Admitted or None
            None where it was refused.

        """
        stamp = nanoseconds(message.header.stamp)
        turn = gate.judge(stamp)
        if turn is Turn.REFUSED:
            self.refuse(topic, 'not the next stamp')
            return None
        try:
            value = None if turn is Turn.AGAIN else read(message)
        except Refused as reason:
            self.refuse(topic, reason)
            return None
        peers.heard(topic)
        return Admitted(stamp, turn, value)

    def refuse(self, topic: str, reason: object) -> None:
        """
        Count a refused message.

        Parameters
        ----------
        topic : str
            Where it came from.
        reason : object
            Why, in few words.

        """
        self.refused[f'{topic}: {reason}'] += 1
        self._node.get_logger().warning(f'refused a message on {topic}: {reason}', throttle_duration_sec=2.0)
