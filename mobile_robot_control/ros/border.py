"""What a node does with messages that it does not take."""

from collections import Counter

from rclpy.node import Node


class Border:
    """
    Counts refused messages by reason and warns about them, not too often.

    Parameters
    ----------
    node : Node
        Who refuses.

    Attributes
    ----------
    refused : Counter of str
        How many messages were refused, by 'topic: reason'.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.refused: Counter[str] = Counter()

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
