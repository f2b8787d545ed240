"""Other controllers of the same full name: two that command one robot would halve each other's commands."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import math
import time
from collections import deque
from collections.abc import Callable

from rclpy.node import Node
from std_msgs.msg import String

from mobile_robot_control.ros.shared.qos import LATCHED, SUBSCRIBED, subscribe_to
from mobile_robot_control.ros.shared.timers import create_steady_timer
from mobile_robot_control.topics import STOPPED

COMMAND = 'cmd_vel'
_LOOK, _FIRST = 0.2, 1.0
"""[s] from one look to the next; after the first command, in which another one may be found that sends already."""
_SENDS = 1.0
"""[s] since its last message for which another one counts."""
_KEPT = 100
"""Messages of this node that are told from those of others."""


class Namesakes:
    """
    Looks for publishers of the command whose node has the same full name, and listens whether they send.

    Teleoperation and multiplexers have other names; a killed node is discovered for some time, and is silent.

    Parameters
    ----------
    node : Node
        The position controller.
    kind : str
        Type of the command.
    stop : callable
        Stops the robot for the reason of another one, unless it is stopped.

    Attributes
    ----------
    reason : str
        Why this node must not drive, and sends nothing, until a release; '' if it may.

    """

    def __init__(self, node: Node, kind: str, stop: Callable[[str], object]) -> None:
        self._node, self._kind, self._stop = node, kind, stop
        self._begun, self._heard, self._listens, self._is_new = math.inf, -math.inf, False, False
        self._sent: deque[bytes] = deque(maxlen=_KEPT)
        self.reason = ''
        create_steady_timer(_LOOK, self._look, node)

    def _names(self, topic: str) -> list[bool]:
        """Return for each publisher of a topic whether its node has this name."""
        name = self._node.get_name(), self._node.get_namespace()
        return [(one.node_name, one.node_namespace) == name
                for one in self._node.get_publishers_info_by_topic(self._node.resolve_topic_name(topic))]

    def sending(self) -> str:
        """Say that several nodes of this name send commands; '' if no other one does."""
        if time.monotonic() - self._heard > _SENDS:
            return ''
        count, name = self._names(COMMAND).count(True), self._node.get_fully_qualified_name()
        return (f'{count} nodes named {name} send {COMMAND}; end all but one, or give each robot a namespace, then '
                'call release')

    def note_sent(self, message: bytes) -> None:
        """Note a command of this node."""
        self._begun = min(self._begun, time.monotonic())
        if self._listens:
            self._sent.append(message)

    def _look(self) -> None:
        if self._listens or self._names(COMMAND).count(True) < 2:
            return
        self._listens, self._is_new = True, time.monotonic() - self._begun <= _FIRST
        subscribe_to(self._node, COMMAND, self._hear, SUBSCRIBED, self._kind)
        self._node.create_subscription(String, STOPPED, self._hear_stop, LATCHED)

    def _hear(self, message: bytes) -> None:
        if message in self._sent:
            return
        self._heard = time.monotonic()
        if self._is_new and not self.reason:
            self._is_new = False
            self.reason = self.sending()
            self._node.get_logger().error(f'the robot is not driven: {self.reason}')

    def _hear_stop(self, message: String) -> None:
        senders = self._names(STOPPED)
        if message.data and len(senders) > 1 and all(senders):
            self._stop(message.data)
