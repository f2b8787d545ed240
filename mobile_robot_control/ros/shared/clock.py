"""The time of a robot on the wall clock: the steady clock's or, with use_sim_time, that of /clock."""

import time
from collections.abc import Callable

from rclpy.clock import JumpThreshold, TimeJump
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time_source import CLOCK_TOPIC
from rosgraph_msgs.msg import Clock

from mobile_robot_control.messages.parsing import RefusedMessageError
from mobile_robot_control.ros.shared.timers import create_steady_timer

_PATIENCE = 2.0
"""[s] of wall time without a message on /clock."""
_STANDS = '/clock stands still or is not published: with use_sim_time nothing moves until it advances'


class SteadyClock:
    """
    Tells the time of the steady clock; also in lockstep, where stamps are the time and `use_sim_time` has no effect.

    Parameters
    ----------
    node : Node
        Node with the timed ticks.

    """

    is_simulated = False

    def __init__(self, node: Node) -> None:
        self._node = node

    def now(self) -> float:
        """Return the time [s]."""
        return time.monotonic()

    def call_every(self, period: float, tick: Callable[[], None]) -> None:
        """Call a function once a period [s]."""
        create_steady_timer(period, tick, self._node)

    def problems(self) -> list[str]:
        """List problems of the clock, in words."""
        return []


class RobotClock(SteadyClock):
    """
    Tells the time of a node's ticks, timeouts and waits; the steady clock times peers and processes.

    Parameters
    ----------
    node : Node
        Node with the parameter `use_sim_time`.
    after_jump_back : callable
        Called after a jump back of simulated time.

    Attributes
    ----------
    is_simulated : bool
        Whether it follows /clock.

    """

    def __init__(self, node: Node, after_jump_back: Callable[[], None]) -> None:
        super().__init__(node)
        self._after_jump_back = after_jump_back
        self._tick: Callable[[], None] | None = None
        self._stands = False
        self.is_simulated = bool(node.get_parameter('use_sim_time').value)
        if self.is_simulated:
            every = JumpThreshold(min_forward=Duration(nanoseconds=1), min_backward=Duration(nanoseconds=-1),
                                  on_clock_change=False)
            self._jumps = node.get_clock().create_jump_callback(every, post_callback=self._on_clock)
            self._heard = time.monotonic()
            create_steady_timer(_PATIENCE / 2.0, self._listen, node)

    def now(self) -> float:
        """Return the time [s]; 0 before the first message on /clock."""
        return int(self._node.get_clock().now().nanoseconds) / 1e9 if self.is_simulated else super().now()

    def call_every(self, period: float, tick: Callable[[], None]) -> None:
        """Call a function once a period [s] of the steady clock, or whenever /clock advances."""
        if self.is_simulated:
            self._tick = tick
        else:
            super().call_every(period, tick)

    def problems(self) -> list[str]:
        """List problems of the clock, in words."""
        return [_STANDS] if self._stands else []

    def _listen(self) -> None:
        """Log the silence of /clock once, and its return once."""
        stands = time.monotonic() - self._heard > _PATIENCE
        if stands and not self._stands:
            self._node.get_logger().warning(_STANDS)
        elif self._stands and not stands:
            self._node.get_logger().info('/clock goes on')
        self._stands = stands

    def _on_clock(self, jump: TimeJump) -> None:
        self._heard = time.monotonic()
        if jump.delta.nanoseconds < 0:
            self._after_jump_back()
        if self._tick is not None:
            self._tick()


def refuse_negative_time(node: Node, note_refusal: Callable[[str, RefusedMessageError], None]) -> None:
    """Keep messages with negative time, at which rclpy raises in a callback of its own, from a node's time source."""
    for subscription in node.subscriptions:
        if subscription.topic_name == CLOCK_TOPIC:
            subscription.callback = _only_valid(subscription.callback, note_refusal)


def _only_valid(
    take: Callable[..., None], note_refusal: Callable[[str, RefusedMessageError], None]
) -> Callable[[Clock], None]:
    def receive(message: Clock) -> None:
        if message.clock.sec < 0:
            note_refusal(CLOCK_TOPIC, RefusedMessageError('negative time', f'{message.clock.sec} s'))
        else:
            take(message)

    return receive
