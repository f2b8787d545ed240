"""Timers by the steady clock, which nobody sets."""

import inspect
from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.timer import Timer


class _Callback:
    """Tells its signature at once: rclpy asks for it at every call, and to find it takes as long as a step."""

    __signature__ = inspect.Signature()

    def __init__(self, function: Callable[[], Any]) -> None:
        self._function = function

    def __call__(self) -> None:
        self._function()


def every(seconds: float, function: Callable[[], Any], node: Node) -> Timer:
    """
    Call a function again and again.

    Parameters
    ----------
    seconds : float
        Period [s].
    function : callable
        Takes nothing.
    node : Node
        In whose turns.

    Returns
    -------
    Timer
        Of the node.

    """
    return node.create_timer(seconds, _Callback(function), clock=Clock(clock_type=ClockType.STEADY_TIME))
