"""
A kinematic base that is not of this package: takes cmd_vel and publishes odometry on its own wall clock.

Run as a process: ``python stand_in_base.py [--plain] [--at X Y HEADING] [--turned]``; with ``--plain`` it takes a Twist
on plain_cmd_vel instead, with ``--turned`` its wheels are swapped: it turns the other way.
"""

import contextlib
import math
import sys

import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

PERIOD, TIMEOUT = 0.02, 0.5
"""[s]: as of most bases, the time without a command after which it stops."""


class Base(Node):
    """Follows the commanded velocity with a first-order lag: a third of the difference each period."""

    def __init__(self, plain, **options):
        super().__init__('base', **options)
        self.frame, self.turns = 'map', 1.0
        self.x, self.y, self.heading, self.v, self.omega = 1.0, 0.0, 0.5 * math.pi, 0.0, 0.0
        self.command, self.silence = Twist(), 0.0
        kind, topic = (Twist, 'plain_cmd_vel') if plain else (TwistStamped, 'cmd_vel')
        self.create_subscription(kind, topic, self.take, 1)
        self.odom = self.create_publisher(Odometry, 'odom', 1)
        self.create_timer(PERIOD, self.move)

    def take(self, message):
        self.command, self.silence = message if isinstance(message, Twist) else message.twist, 0.0

    def move(self):
        self.silence += PERIOD
        if self.silence > TIMEOUT:
            self.command = Twist()
        self.v += (self.command.linear.x - self.v) / 3.0
        self.omega += (self.turns * self.command.angular.z - self.omega) / 3.0
        self.x += PERIOD * self.v * math.cos(self.heading)
        self.y += PERIOD * self.v * math.sin(self.heading)
        self.heading += PERIOD * self.omega
        message = Odometry(child_frame_id='base_footprint')
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = self.frame
        message.pose.pose.position.x, message.pose.pose.position.y = self.x, self.y
        message.pose.pose.orientation.z = math.sin(0.5 * self.heading)
        message.pose.pose.orientation.w = math.cos(0.5 * self.heading)
        message.twist.twist.linear.x, message.twist.twist.angular.z = self.v, self.omega
        self.odom.publish(message)


if __name__ == '__main__':
    rclpy.init()
    base = Base('--plain' in sys.argv)
    if '--at' in sys.argv:
        base.x, base.y, base.heading = map(float, sys.argv[sys.argv.index('--at') + 1:][:3])
    base.turns = -1.0 if '--turned' in sys.argv else 1.0
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(base)
