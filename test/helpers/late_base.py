"""
A stand-in base of stand_in_model as a node: on the wall clock or, with a factor, as a simulator that publishes /clock.

On a machine too busy for the factor, simulated time goes more slowly. `ground_truth` is the base's true pose. SIGUSR1
stops simulated time, or lets it go on; SIGUSR2 begins it anew.
"""

import argparse
import math
import signal
import time

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock

from helpers.stand_in_model import STEP, Base, StandIn

LONGEST = 0.1
"""[s] of simulated time from one message on /clock to the next: on a busy machine it would grow and grow."""
_BEHIND, _SLOWLY = 0.1, 0.1
"""[s] that the newest command may be old in simulated time; where it is older, time goes more slowly by this factor."""


class LateBase(Node):
    """Moves the model as time passes."""

    def __init__(self, base, pose, factor):
        super().__init__('late_base')
        self._base, self._start, self._factor = base, pose, factor
        self._clock_topic = self.create_publisher(Clock, '/clock', 1) if factor else None
        self._odom = self.create_publisher(Odometry, 'odom', qos_profile_sensor_data)
        self._truth = self.create_publisher(Odometry, 'ground_truth', 10)
        self._stands = self._anew = False
        self._begin()
        self.create_subscription(TwistStamped, 'cmd_vel', self._take, 1)
        self.create_timer(0.002, self._advance)
        signal.signal(signal.SIGUSR1, self._stand_or_go_on)
        signal.signal(signal.SIGUSR2, self._begin_anew)

    def _begin(self):
        self._robot, self._began = StandIn(self._base, self._start), 0.0 if self._factor else time.time()
        self._sent = self._told = -1.0
        self._now, self._wall, self._answered = 0.0, time.monotonic(), math.inf

    def _begin_anew(self, *_):
        # a signal may come in the middle of an advance, which would go on with numbers of the former time
        self._anew = True

    def _stand_or_go_on(self, *_):
        self._stands = not self._stands

    def _take(self, message):
        self._robot.commanded = message.twist.linear.x, message.twist.angular.z
        self._answered = message.header.stamp.sec + message.header.stamp.nanosec / 1e9

    def _advance(self):
        if self._anew:
            self._anew = False
            self._begin()
        wall = time.monotonic()
        if not self._stands:
            passed = (self._factor or 1.0) * (wall - self._wall)
            if self._factor and self._now - self._answered > _BEHIND:
                passed *= _SLOWLY
            self._now += min(passed, LONGEST) if self._factor else passed
        self._wall = wall
        while self._robot.k * STEP < self._now:
            self._robot.sample()
            stamp, pose, twist = self._robot.odometry[0]
            if stamp > self._sent:
                self._sent = stamp
                self._odom.publish(self._message(stamp, pose, twist))
            if self._robot.k * STEP >= self._told + 0.02:
                self._told = self._robot.k * STEP
                self._truth.publish(self._message(self._told, self._robot.pose, (0.0, 0.0)))
            self._robot.move()
        if self._clock_topic is not None and not self._stands:
            message = Clock()
            self._stamp(message.clock, self._now)
            self._clock_topic.publish(message)

    def _stamp(self, stamp, at):
        stamp.sec, stamp.nanosec = divmod(round((self._began + at) * 1e9), 10**9)

    def _message(self, at, pose, twist):
        message = Odometry(child_frame_id='base_link')
        message.header.frame_id = 'odom'
        self._stamp(message.header.stamp, at)
        message.pose.pose.position.x, message.pose.pose.position.y, heading = pose
        message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(heading / 2), math.cos(heading / 2)
        message.twist.twist.linear.x, message.twist.twist.angular.z = twist
        return message


def main():
    """Run until killed."""
    options = argparse.ArgumentParser()
    options.add_argument('--lag', type=float, required=True)
    options.add_argument('--pose', type=float, nargs=3, required=True)
    options.add_argument('--factor', type=float, default=0.0, help='of simulated time; 0 for the wall clock')
    given = options.parse_args()
    rclpy.init(args=[])
    rclpy.spin(LateBase(Base(lag=given.lag), given.pose, given.factor))


if __name__ == '__main__':
    main()
