"""
A bare rclpy exchange of the lockstep loop's messages: each node answers a stamp and computes nothing.

`python -m bench.bare_lockstep NAME` runs one of them at 500 and 100 Hz, as fast as it goes.
"""

import sys
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.clock import Clock as SteadyClock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from bench.bare_messages import CMD_VEL, JOINT_STATES, ODOM, REFERENCE, TRACKING_ERROR, WHEEL_TORQUES
from bench.process import spin
from mobile_robot_control.ros.shared.qos import PUBLISHED, SUBSCRIBED

PERIOD = 2_000_000
TICKS = 5
"""Cycles from one position tick to the next."""


class Plant(Node):
    """Publishes joint states stamp after stamp, and odometry every fifth time; repeats them after 0.1 s."""

    def __init__(self) -> None:
        super().__init__('plant')
        self._cycle = 0
        self._odom = self.create_publisher(Odometry, 'odom', PUBLISHED)
        self._joint_states = self.create_publisher(JointState, 'joint_states', PUBLISHED)
        self._clock_topic = self.create_publisher(Clock, '/clock', PUBLISHED)
        self.create_subscription(JointState, 'wheel_torques', self._on_wheel_torques, SUBSCRIBED)
        self._asked = -1
        self.create_timer(0.1, self._look, clock=SteadyClock(clock_type=ClockType.STEADY_TIME))
        self._ask(with_odometry=True)

    def _ask(self, with_odometry: bool) -> None:
        nanoseconds = self._cycle * PERIOD
        self._stamp = Time(sec=nanoseconds // 1_000_000_000, nanosec=nanoseconds % 1_000_000_000)
        if with_odometry:
            ODOM.header.stamp = self._stamp
            self._odom.publish(ODOM)
            self._clock_topic.publish(Clock(clock=self._stamp))
        JOINT_STATES.header.stamp = self._stamp
        self._joint_states.publish(JOINT_STATES)

    def _on_wheel_torques(self, message: JointState) -> None:
        if message.header.stamp == self._stamp:
            self._cycle += 1
            self._ask(with_odometry=self._cycle % TICKS == 0)

    def _look(self) -> None:
        if self._asked == self._cycle:
            self._odom.publish(ODOM)
            self._joint_states.publish(JOINT_STATES)
        self._asked = self._cycle


class ReferenceCart(Node):
    """Answers odometry with a reference."""

    def __init__(self) -> None:
        super().__init__('reference_cart')
        self._reference = self.create_publisher(Odometry, 'reference', PUBLISHED)
        self.create_subscription(Odometry, 'odom', self._on_odom, SUBSCRIBED)

    def _on_odom(self, message: Odometry) -> None:
        REFERENCE.header.stamp = message.header.stamp
        self._reference.publish(REFERENCE)


class PositionController(Node):
    """Answers odometry and reference of one stamp with a command and a tracking error."""

    def __init__(self) -> None:
        super().__init__('position_controller')
        self._cmd_vel = self.create_publisher(TwistStamped, 'cmd_vel', PUBLISHED)
        self._tracking_error = self.create_publisher(Vector3Stamped, 'tracking_error', PUBLISHED)
        self.create_subscription(Odometry, 'odom', self._on_odom, SUBSCRIBED)
        self.create_subscription(Odometry, 'reference', self._on_reference, SUBSCRIBED)
        self._odom: Any = None
        self._reference: Any = None

    def _on_odom(self, message: Odometry) -> None:
        self._odom = message.header.stamp
        self._answer()

    def _on_reference(self, message: Odometry) -> None:
        self._reference = message.header.stamp
        self._answer()

    def _answer(self) -> None:
        if self._odom == self._reference:
            CMD_VEL.header.stamp = TRACKING_ERROR.header.stamp = self._odom
            self._cmd_vel.publish(CMD_VEL)
            self._tracking_error.publish(TRACKING_ERROR)


class VelocityController(Node):
    """Answers joint states with torques, at position ticks together with the command."""

    def __init__(self) -> None:
        super().__init__('velocity_controller')
        self._wheel_torques = self.create_publisher(JointState, 'wheel_torques', PUBLISHED)
        self.create_subscription(JointState, 'joint_states', self._on_joint_states, SUBSCRIBED)
        self.create_subscription(TwistStamped, 'cmd_vel', self._on_cmd_vel, SUBSCRIBED)
        self._wheels: Any = None
        self._command: Any = None

    def _on_joint_states(self, message: JointState) -> None:
        self._wheels = message.header.stamp
        if self._wheels.nanosec % (TICKS * PERIOD) or self._wheels == self._command:
            self._answer()

    def _on_cmd_vel(self, message: TwistStamped) -> None:
        self._command = message.header.stamp
        if self._wheels == self._command:
            self._answer()

    def _answer(self) -> None:
        WHEEL_TORQUES.header.stamp = self._wheels
        self._wheel_torques.publish(WHEEL_TORQUES)


NODES = {'plant': Plant, 'velocity_controller': VelocityController, 'position_controller': PositionController,
         'reference_cart': ReferenceCart}


if __name__ == '__main__':
    spin(NODES[sys.argv[1]])
