"""The smallest position controller of somebody else: backstepping, Eq. (25), without a state."""

import math
from contextlib import suppress

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

P, Q, F, G = 1.646, 0.243115, 1.26767, 10.1146  # config/backstepping.yaml, where alpha is 1


def pose(odometry):
    """Return x, y [m] and heading [rad]."""
    position, q = odometry.pose.pose.position, odometry.pose.pose.orientation
    return position.x, position.y, 2.0 * math.atan2(q.z, q.w)


class PositionController(Node):
    """Answers `odom` and `reference` by `cmd_vel`."""

    def __init__(self):
        super().__init__('position_controller')
        self.odom = self.reference = None
        self.publisher = self.create_publisher(TwistStamped, 'cmd_vel', 2000)
        self.create_subscription(Odometry, 'odom', self.take_odom, 10)
        self.create_subscription(Odometry, 'reference', self.take_reference, 10)

    def take_odom(self, odom):
        """Keep the question; one that comes again is answered again."""
        self.odom = odom
        self.answer()

    def take_reference(self, reference):
        """Keep the reference; one that comes again is not answered: its question comes again, too."""
        comes_again = self.reference is not None and reference == self.reference
        self.reference = reference
        if not comes_again:
            self.answer()

    def answer(self):
        """Answer once both messages of a stamp are there, with this stamp."""
        if self.odom is None or self.reference is None or self.odom.header.stamp != self.reference.header.stamp:
            return
        (x, y, heading), (x_r, y_r, heading_r) = pose(self.odom), pose(self.reference)
        cos, sin = math.cos(heading), math.sin(heading)
        e1, e2 = cos * (x_r - x) + sin * (y_r - y), -sin * (x_r - x) + cos * (y_r - y)
        e3 = heading_r - heading
        v_r, omega_r = self.reference.twist.twist.linear.x, self.reference.twist.twist.angular.z
        command = TwistStamped()
        command.header.stamp, command.header.frame_id = self.odom.header.stamp, 'base_link'
        command.twist.linear.x = v_r * math.cos(e3) + P * F * e1
        command.twist.angular.z = omega_r + 2.0 * P / Q * v_r * e2 + Q * G * math.sin(e3)
        self.publisher.publish(command)


if __name__ == '__main__':
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(PositionController())
