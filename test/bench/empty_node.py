"""An empty rclpy node with one publisher: 200 messages a second, from the start."""

import os
import signal

import rclpy
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Header

PERIOD = 0.005
TOPIC = 'first'


def main() -> None:
    """Run until SIGTERM, or until the parent has ended."""
    stopped, parent = [], os.getppid()
    signal.signal(signal.SIGTERM, lambda number, _frame: stopped.append(number))
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = Node('empty')
    publisher = node.create_publisher(Header, TOPIC, 1)
    node.create_timer(PERIOD, lambda: publisher.publish(Header()), clock=Clock(clock_type=ClockType.STEADY_TIME))
    executor = EventsExecutor()
    executor.add_node(node)
    while not stopped and os.getppid() == parent:
        executor.spin_once(timeout_sec=0.1)
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
