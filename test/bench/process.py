"""The spin loop of the benchmarks' own nodes: that of the package, reduced to what it must do."""

from typing import Any

import rclpy
from rclpy.signals import SignalHandlerOptions

from mobile_robot_control.ros.shared.process import Stop
from mobile_robot_control.ros.start.spin import make_executor


def spin(make: Any, *arguments: Any) -> None:
    """Make a node and spin it until a signal asks it to end, or its parent has ended."""
    stop = Stop()
    stop.follow_parent()
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = make(*arguments)
    executor = make_executor()
    executor.add_node(node)
    while not stop.requested:
        executor.spin_once(timeout_sec=0.1)
    node.destroy_node()
    rclpy.try_shutdown()
