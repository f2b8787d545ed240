"""The subscription to `path`, for publishers that keep their last message for later subscribers and for others."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections import deque
from collections.abc import Callable
from functools import partial

from nav_msgs.msg import Path
from rclpy.node import Node

from mobile_robot_control.ros.services.qos import LATCHED, QUIET, SUBSCRIBED
from mobile_robot_control.topics import PATH_TOPIC

_MOST = 4
"""Messages of one subscription that wait for the other one."""


def subscribe_to_paths(node: Node, take: Callable[[bytes], None]) -> None:
    """
    Call a function with each message on `path`, serialised.

    A subscription to kept messages connects only with publishers that keep them, and no other subscription receives
    kept messages. Hence there are two; a message on both counts once.
    """
    only_by_one: list[deque[bytes]] = [deque(maxlen=_MOST), deque(maxlen=_MOST)]

    def receive(number: int, message: bytes) -> None:
        by_other = only_by_one[1 - number]
        if message in by_other:
            by_other.remove(message)
            return
        only_by_one[number].append(message)
        take(message)

    for number, quality in enumerate((LATCHED, SUBSCRIBED)):
        node.create_subscription(
            Path, PATH_TOPIC, partial(receive, number), quality, raw=True, event_callbacks=QUIET)
