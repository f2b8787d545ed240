"""Quality of service of the topics, one profile a purpose."""

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""What the nodes subscribe to loop topics with: reliable, the newest message only."""

LOOP = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
"""What they publish loop topics with: a slow listener, such as a recorder, can ask again for what it lost."""

LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""What is said once and holds for who comes later."""
