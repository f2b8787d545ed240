"""Other controllers of the same full name: two that command one robot would halve each other's commands."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import math
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from std_msgs.msg import String

from mobile_robot_control.ros.shared.qos import LATCHED, subscribe_to
from mobile_robot_control.ros.shared.timers import create_steady_timer
from mobile_robot_control.topics import STOPPED

COMMAND = 'cmd_vel'
_LOOK, _CLOSE = 0.2, 1.0
"""[s] from one look to the next; between the first commands of two nodes of which both count as the younger one."""
_SENDS, _CONNECTS = 1.0, 5.0
"""[s] for which another one counts: since its last message, and at first, as DDS may connect with it seconds later."""
_KEPT = 100
"""Messages of this node that are told from those of others."""
_LISTENS = QoSProfile(depth=_KEPT, reliability=ReliabilityPolicy.RELIABLE)


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
        self._begun, self._count, self._counts_until = 0.0, 0, -math.inf
        self._commands: Subscription[Any] | None = None
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
        if time.monotonic() > self._counts_until:
            return ''
        count, name = self._names(COMMAND).count(True), self._node.get_fully_qualified_name()
        return (f'{count} nodes named {name} send {COMMAND}; end all but one, or give each robot a namespace, then '
                'call release')

    def note_sent(self, message: bytes) -> None:
        """Note a command of this node."""
        if not self._count:
            self._begun = time.monotonic()
        self._count += 1
        self._sent.append(message)

    def _look(self) -> None:
        if self._commands is None:
            if self._names(COMMAND).count(True) < 2:
                return
            self._counts_until = time.monotonic() + _CONNECTS
            self._node.create_subscription(String, STOPPED, self._hear_stop, LATCHED)
            # the executor of events fails at a callback that takes the number of a message: this node is polled. It has
            # no services, which a policy does not allow
            self._listener = Node(
                f'{self._node.get_name()}_listener', context=self._node.context, enable_rosout=False,
                namespace=self._node.get_namespace(), start_parameter_services=False, use_global_arguments=False,
                parameter_overrides=[Parameter('start_type_description_service', value=False)])
            self._commands = subscribe_to(
                self._listener, self._node.resolve_topic_name(COMMAND), lambda _: None, _LISTENS, self._kind)
        with self._commands.handle:
            while message := self._commands.handle.take_message(self._commands.msg_type, self._commands.raw):
                self._hear(*message)

    def _hear(self, message: bytes, information: Any) -> None:
        if message in self._sent:
            return
        self._counts_until = max(self._counts_until, time.monotonic() + _SENDS)
        # not every middleware counts
        if not self.reason and self._is_younger(information.get('publication_sequence_number') or 0):
            self.reason = self.sending()
            self._node.get_logger().error(f'the robot is not driven: {self.reason}')

    def _is_younger(self, sent: int) -> bool:
        """Return whether another one has sent as many commands as this node: DDS may tell of it seconds later."""
        age = time.monotonic() - self._begun
        return self._count * (age - _CLOSE) <= sent * age

    def _hear_stop(self, message: String) -> None:
        senders = self._names(STOPPED)
        if message.data and len(senders) > 1 and all(senders):
            self._stop(message.data)
