"""Quality of service of the topics, one profile a purpose."""

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

LOOP = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Loop topics: reliable, the newest message only."""

LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""What is said once and holds for who comes later."""
