"""The input `cmd_vel`, as TwistStamped or, where `stamped_cmd_vel` is false, as plain Twist."""

from collections.abc import Callable
from functools import partial
from typing import Any

from geometry_msgs.msg import Twist

from mobile_robot_control.messages import writing
from mobile_robot_control.messages.parsing import read_plain_twist, read_twist
from mobile_robot_control.quantities import BodyVelocity
from mobile_robot_control.ros.input_validation import InputValidator, ValidInput, make_reader
from mobile_robot_control.ros.qos import SUBSCRIBED
from mobile_robot_control.ros.stamp_policy import StampPolicy


class CommandInput:
    """
    Validates the messages of cmd_vel; a plain Twist counts as stamped when it is received.

    Parameters
    ----------
    validator : InputValidator
        Of the node.
    policy : StampPolicy
        For the stamps.
    frame : str
        Of the robot, which a stamped command may name.
    now : callable
        Returns the present stamp [ns].
    take : callable
        Takes a valid command.

    """

    def __init__(
        self, validator: InputValidator, policy: StampPolicy, frame: str, now: Callable[[], int],
        take: Callable[[ValidInput], None],
    ) -> None:
        self._validator, self._policy, self._now, self._take = validator, policy, now, take
        self._read_stamped = make_reader('cmd_vel', partial(read_twist, frame=frame))
        self._read_plain = make_reader('cmd_vel', read_plain_twist, 'geometry_msgs/msg/Twist')
        self._stamp: Callable[[int, BodyVelocity], bytes] = writing.twist_writer('')

    def subscribe(self, node: Any, stamped: bool, subscribe: Callable[[str, Callable[[bytes], None]], None]) -> None:
        """Subscribe a node; `subscribe` does so for a loop topic."""
        if stamped:
            subscribe('cmd_vel', self._on_stamped)
        else:
            node.create_subscription(Twist, 'cmd_vel', self._on_plain, SUBSCRIBED, raw=True)

    def _on_stamped(self, message: bytes) -> None:
        valid = self._validator.validate('cmd_vel', message, self._read_stamped, self._policy)
        if valid is not None:
            self._take(valid)

    def _on_plain(self, message: bytes) -> None:
        velocity = self._validator.read('cmd_vel', message, self._read_plain)
        if velocity is not None:
            self._on_stamped(self._stamp(self._now(), velocity))
