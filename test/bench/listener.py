"""A listener in a ROS domain: takes in serialised messages in this process."""

import time
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions


class Listener:
    """
    A node in any domain, whatever other domains this process is in.

    Parameters
    ----------
    domain : int
        ROS domain.

    """

    def __init__(self, domain: int) -> None:
        self.domain = domain
        self._context = Context()
        rclpy.init(args=[], context=self._context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node('listener', context=self._context, enable_rosout=False, start_parameter_services=False)
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self.node)

    def listen_to(self, topic: str, kind: type, take: Callable[[bytes], None], quality: QoSProfile) -> Any:
        """Subscribe to serialised messages, as they are on the wire."""
        return self.node.create_subscription(kind, topic, take, quality, raw=True)

    def until(self, condition: Callable[[], bool], seconds: float, check: Callable[[], None] = lambda: None) -> None:
        """Take in messages until a condition holds; raises TimeoutError if it does not in time."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(f'the condition did not hold within {seconds} s')
            check()
            self._executor.spin_once(timeout_sec=0.02)

    def close(self) -> None:
        """Leave the domain."""
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()
