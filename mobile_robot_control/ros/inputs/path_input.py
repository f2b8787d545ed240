"""The subscription to `path`, from publishers that keep their last message for later subscribers and from others."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable
from typing import Any

from nav_msgs.msg import Path
from rclpy.node import Node

try:
    from rclpy.event_handler import SubscriptionEventCallbacks
except ImportError:  # before iron
    from rclpy.qos_event import SubscriptionEventCallbacks

from mobile_robot_control.ros.services.qos import LATCHED, SUBSCRIBED
from mobile_robot_control.topics import PATH_TOPIC


def subscribe_to_paths(node: Node, take: Callable[[bytes], None]) -> None:
    """
    Call a function with each message on `path`, serialised.

    DDS connects a subscription that wants kept messages with publishers alone that keep them, and sends kept messages
    to no other one: there are two, and what both get counts once.
    """
    before: list[Any] = [None]

    def receive(message: bytes, info: Any) -> None:
        found = info['source_timestamp'], message
        if found != before[0]:
            before[0] = found
            take(message)

    quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
    for quality in (LATCHED, SUBSCRIBED):
        node.create_subscription(Path, PATH_TOPIC, receive, quality, raw=True, event_callbacks=quiet)
