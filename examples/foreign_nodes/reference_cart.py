"""The smallest reference cart of somebody else: a circle of 1 m in 16 s around the origin."""

import math
from contextlib import suppress

import rclpy
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

RADIUS, OMEGA = 1.0, 2.0 * math.pi / 16.0  # [m], [rad/s]


class ReferenceCart(Node):
    """Answers `odom` by `reference`."""

    def __init__(self):
        super().__init__('reference_cart')
        self.publisher = self.create_publisher(Odometry, 'reference', 2000)
        self.create_subscription(Odometry, 'odom', self.answer, 10)

    def answer(self, odom):
        """Answer every question with the reference of its time, and with its stamp."""
        stamp = odom.header.stamp
        angle = OMEGA * (stamp.sec * 10**9 + stamp.nanosec) / 1e9
        heading = angle + math.pi / 2.0
        reference = Odometry(header=odom.header, child_frame_id='reference_cart')
        reference.pose.pose.position.x = RADIUS * math.cos(angle)
        reference.pose.pose.position.y = RADIUS * math.sin(angle)
        reference.pose.pose.orientation.z = math.sin(heading / 2.0)
        reference.pose.pose.orientation.w = math.cos(heading / 2.0)
        reference.twist.twist.linear.x, reference.twist.twist.angular.z = RADIUS * OMEGA, OMEGA
        self.publisher.publish(reference)


if __name__ == '__main__':
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(ReferenceCart())
