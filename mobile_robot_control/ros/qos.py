"""Quality of service of the topics, one profile a purpose."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from typing import Any

from rclpy.duration import Duration
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

NEWEST = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
"""
What the nodes subscribe to loop topics with: reliable, the newest few messages. The loop wants the newest alone, but
where somebody else talks as well, one of his would push it out before it is taken.
"""

LOOP = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)
"""
What they publish loop topics with: a slow listener, such as a recorder, can ask again for what it lost. Fast DDS tells
listeners what they should have after some 200 kB; what everybody has is dropped at once.
"""

LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""What is said once and holds for who comes later."""


def flush(*publishers: Publisher[Any]) -> None:
    """
    Wait, a second at most, until every listener has what was published.

    Parameters
    ----------
    publishers : Publisher
        Of a node that is about to end.

    """
    deadline = time.monotonic() + 1.0
    for publisher in publishers:
        publisher.wait_for_all_acked(Duration(seconds=max(0.0, deadline - time.monotonic())))
