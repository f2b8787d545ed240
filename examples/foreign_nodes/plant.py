"""The smallest plant of somebody else: an ideal unicycle that follows `cmd_vel`, in lockstep at 100 Hz."""

import math
from contextlib import suppress

import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

PERIOD = 10_000_000  # [ns]: position_rate is 100 Hz
START = (1.0, 0.0, math.pi / 2.0)  # x, y [m], heading [rad]


class Plant(Node):
    """Asks by `odom`, and steps with the answer."""

    def __init__(self):
        super().__init__('plant')
        self.stamp, self.pose, self.velocity = 0, START, (0.0, 0.0)
        self.publisher = self.create_publisher(Odometry, 'odom', 2000)
        self.create_subscription(TwistStamped, 'cmd_vel', self.take_command, 10)
        self.timer = self.create_timer(0.1, self.ask)
        self.ask()

    def ask(self):
        """Ask by `odom`; a question that is not answered is repeated every 0.1 s, byte by byte."""
        odom = Odometry(child_frame_id='base_link')
        odom.header.frame_id = 'odom'
        odom.header.stamp = Time(sec=self.stamp // 10**9, nanosec=self.stamp % 10**9)
        odom.pose.pose.position.x, odom.pose.pose.position.y = self.pose[:2]
        odom.pose.pose.orientation.z = math.sin(self.pose[2] / 2.0)
        odom.pose.pose.orientation.w = math.cos(self.pose[2] / 2.0)
        odom.twist.twist.linear.x, odom.twist.twist.angular.z = self.velocity
        self.publisher.publish(odom)
        self.timer.reset()

    def take_command(self, command):
        """Step with the first answer to the present question; an earlier one comes again and does nothing."""
        stamp = command.header.stamp
        if stamp.sec * 10**9 + stamp.nanosec != self.stamp:
            return
        x, y, heading = self.pose
        v, omega = self.velocity = command.twist.linear.x, command.twist.angular.z
        half = omega * PERIOD / 1e9 / 2.0
        # the chord of the arc
        way = v * PERIOD / 1e9 * (math.sin(half) / half if half else 1.0)
        self.pose = x + way * math.cos(heading + half), y + way * math.sin(heading + half), heading + 2.0 * half
        self.stamp += PERIOD
        self.ask()


if __name__ == '__main__':
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(Plant())
