"""The stand-in base of stand_in_model as a node on the wall clock; `ground_truth` is its true pose."""

import argparse
import math
import time

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from stand_in_model import STEP, Base, StandIn


class LateBase(Node):
    """Moves the model as wall time passes."""

    def __init__(self, base, pose):
        super().__init__('late_base')
        self._robot, self._began = StandIn(base, pose), time.time()
        self._sent = self._told = -1.0
        self._odom = self.create_publisher(Odometry, 'odom', qos_profile_sensor_data)
        self._truth = self.create_publisher(Odometry, 'ground_truth', 10)
        self.create_subscription(TwistStamped, 'cmd_vel', self._take, 1)
        self.create_timer(0.002, self._advance)

    def _take(self, message):
        self._robot.commanded = message.twist.linear.x, message.twist.angular.z

    def _advance(self):
        now = time.time() - self._began
        while self._robot.k * STEP < now:
            self._robot.sample()
            sampled, pose, twist = self._robot.odometry[0]
            if sampled > self._sent:
                self._sent = sampled
                self._odom.publish(self._message(sampled, pose, twist))
            if self._robot.k * STEP >= self._told + 0.02:
                self._told = self._robot.k * STEP
                self._truth.publish(self._message(self._told, self._robot.pose, (0.0, 0.0)))
            self._robot.move()

    def _message(self, at, pose, twist):
        message = Odometry(child_frame_id='base_link')
        message.header.frame_id = 'odom'
        stamp = round((self._began + at) * 1e9)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
        message.pose.pose.position.x, message.pose.pose.position.y, heading = pose
        message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(heading / 2), math.cos(heading / 2)
        message.twist.twist.linear.x, message.twist.twist.angular.z = twist
        return message


def main():
    """Run until killed."""
    options = argparse.ArgumentParser()
    options.add_argument('--lag', type=float, required=True)
    options.add_argument('--pose', type=float, nargs=3, required=True)
    given = options.parse_args()
    rclpy.init(args=[])
    rclpy.spin(LateBase(Base(lag=given.lag), given.pose))


if __name__ == '__main__':
    main()
