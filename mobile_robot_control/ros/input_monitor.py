"""The monitor of a node's inputs: how old each is, and which are silent."""

import math
import time
from collections.abc import Mapping

from rclpy.node import Node

from mobile_robot_control.ros.timers import create_steady_timer


class InputMonitor:
    """
    Monitors a node's inputs: a silent one is named once in the log, and its return once.

    Parameters
    ----------
    node : Node
        Whose inputs.
    sources : mapping of str to str
        Each input topic and the node that publishes it.
    timeout : float
        Wall time of silence [s].

    Attributes
    ----------
    sources : mapping of str to str
        As given.

    """

    def __init__(self, node: Node, sources: Mapping[str, str], timeout: float) -> None:
        self.sources = sources
        self._node, self._timeout = node, timeout
        self._received_at = dict.fromkeys(sources, time.monotonic())
        self._reported: set[str] = set()
        self._received: set[str] = set()
        create_steady_timer(min(0.5, timeout), self._report_silent, node)

    def note_input(self, topic: str) -> None:
        """Note that a message of one of the topics was taken."""
        self._received_at[topic] = time.monotonic()
        self._received.add(topic)
        if topic in self._reported:
            self._reported.remove(topic)
            self._node.get_logger().info(f'{topic} is back')

    def age(self, topic: str) -> float:
        """Return the wall time since the newest message of a topic [s]; infinite before the first."""
        return time.monotonic() - self._received_at[topic] if topic in self._received else math.inf

    def missing(self) -> list[str]:
        """List the nodes whose messages never came, or not for the timeout."""
        return list(dict.fromkeys(source for topic, source in self.sources.items()
                                  if topic not in self._received or self._is_silent(topic)))

    def _is_silent(self, topic: str) -> bool:
        return time.monotonic() - self._received_at[topic] > self._timeout

    def _report_silent(self) -> None:
        for topic, source in self.sources.items():
            if topic not in self._reported and self._is_silent(topic):
                self._reported.add(topic)
                self._node.get_logger().warning(
                    f'no {topic} for {self._timeout} s: is {source} running, on the same clock as this node?'
                )
