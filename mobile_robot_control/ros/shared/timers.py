"""Timers by the steady clock, which no one sets."""

import inspect
from collections.abc import Callable

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.timer import Timer


class _Callback:
    """Stores its signature: rclpy asks for it at every call, and computing it takes as long as a step."""

    __signature__ = inspect.Signature()

    def __init__(self, function: Callable[[], object]) -> None:
        self._function = function

    def __call__(self) -> None:
        self._function()


def create_steady_timer(seconds: float, function: Callable[[], object], node: Node) -> Timer:
    """Call a function without arguments periodically, every so many seconds, in a node's turns."""
    return node.create_timer(seconds, _Callback(function), clock=Clock(clock_type=ClockType.STEADY_TIME))
