"""Quality of service of the topics, and the loop's publishers and subscriptions."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import importlib
import time
from collections.abc import Callable
from typing import Any

from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from mobile_robot_control.messages.writing import message_class
from mobile_robot_control.topics import ALL_LOOP_TOPICS

SUBSCRIBED = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
"""
Of subscriptions to loop topics: reliable, the newest few messages. The loop needs only the newest; but with a depth of
one, a message from another publisher would replace it before it is read.
"""

SENSORS = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Of subscriptions to measurements of a robot, on the wall clock: most drivers publish them as best effort."""

PUBLISHED = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)
"""
Of publishers on loop topics: a slow subscriber, such as a recorder, can request lost messages again. Fast DDS announces
messages to subscribers after some 200 kB; it drops those that all of them have at once.
"""

LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Of topics with one message that also holds for later subscribers."""

QUIET = SubscriptionEventCallbacks(use_default_callbacks=False)
"""Events of subscriptions that log no warning of a publisher with another quality of service."""


def action_class(kind: str) -> Any:
    """Return the rclpy class of an action type such as 'nav2_msgs/action/FollowPath'; None if it is not installed."""
    package, _, name = kind.split('/')
    try:
        return getattr(importlib.import_module(f'{package}.action'), name)
    except ModuleNotFoundError:
        return None


def publish_on(node: Node, topic: str, kind: str, **options: object) -> Publisher[Any]:
    """Make a node's publisher on a topic of the loop, with messages of a type."""
    return node.create_publisher(message_class(kind), topic, PUBLISHED, **options)


def subscribe_to(
    node: Node, topic: str, take: Callable[[bytes], None], quality: QoSProfile = SUBSCRIBED, kind: str = '',
    **options: object,
) -> Subscription[Any]:
    """Make a node's subscription to a loop topic; its type may be omitted, and messages are passed as bytes."""
    known = kind or ALL_LOOP_TOPICS[topic].kind
    return node.create_subscription(message_class(known), topic, take, quality, raw=True, **options)


def flush(*publishers: Publisher[Any], seconds: float = 1.0) -> None:
    """Wait, for a limited wall time, until every subscriber has all messages of a node that is about to end."""
    deadline = time.monotonic() + seconds
    for publisher in publishers:
        publisher.wait_for_all_acked(Duration(seconds=max(0.0, deadline - time.monotonic())))
