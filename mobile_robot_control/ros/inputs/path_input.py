"""The subscription to `path`, for publishers that keep their last message for later subscribers and for others."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections import deque
from collections.abc import Callable
from functools import partial

from nav_msgs.msg import Path
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from mobile_robot_control.ros.services.qos import LATCHED, QUIET, SUBSCRIBED
from mobile_robot_control.ros.services.timers import create_steady_timer
from mobile_robot_control.topics import PATH_TOPIC

_MOST = 4
"""Messages of one subscription that wait for the other one."""
_LOOK = 0.2
"""[s] from one look for publishers that keep their messages to the next."""


def subscribe_to_paths(node: Node, take: Callable[[bytes], None]) -> None:
    """
    Call a function with each message on `path`, serialised.

    A subscription to kept messages connects only with publishers that keep them, and no other subscription receives
    kept messages. Hence there are two, the one to kept messages once a publisher keeps them: DDS would warn any other
    publisher of it. A message on both counts once.
    """
    only_by_one: list[deque[bytes]] = [deque(maxlen=_MOST), deque(maxlen=_MOST)]

    def receive(number: int, message: bytes) -> None:
        by_other = only_by_one[1 - number]
        if message in by_other:
            by_other.remove(message)
            return
        only_by_one[number].append(message)
        take(message)

    def subscribe(number: int, quality: QoSProfile) -> None:
        node.create_subscription(Path, PATH_TOPIC, partial(receive, number), quality, raw=True, event_callbacks=QUIET)

    def look() -> None:
        if any(offer.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in publishers()):
            timer.cancel()
            subscribe(1, LATCHED)

    subscribe(0, SUBSCRIBED)
    publishers = partial(node.get_publishers_info_by_topic, node.resolve_topic_name(PATH_TOPIC))
    timer = create_steady_timer(_LOOK, look, node)
