"""A robot in MuJoCo in the place of the plant: python plant.py differential|skid_steer [--ros-args ...]."""

import math
import sys
from contextlib import suppress

import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import SetParametersResult
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from robots import BUILDS, Robot
from sensor_msgs.msg import JointState

SECOND = 10**9
_PARAMETERS = {
    'drive': 'torque', 'lockstep': True, 'velocity_rate': 500.0, 'position_rate': 100.0,
    'robot.wheel_radius': 0.075, 'robot.wheel_separation': 0.3, 'initial_pose': [1.0, 0.0, math.pi / 2.0],
    'paused': False, 'hold_at': 0.0}
_TIMEOUT = 0.2
"""Without a command, after which the robot stops on the wall clock [s]."""
_CATCH_UP = 20
"""Periods that a late timer of the wall clock makes up for at most."""


class Plant(Node):
    """
    Asks by `odom` and `joint_states`, and steps with the answer to both.

    With `lockstep: false` it steps by the wall clock, with the newest command.
    """

    def __init__(self, robot):
        super().__init__('plant')
        values = {name: self.declare_parameter(name, value).value for name, value in _PARAMETERS.items()}
        self.robot = Robot(robot, values['drive'], values['initial_pose'], values['robot.wheel_radius'],
                           values['robot.wheel_separation'])
        self.advance = self.robot.push if values['drive'] == 'torque' else self.robot.follow
        self.lockstep, self.paused, self.hold_at = values['lockstep'], values['paused'], values['hold_at']
        self.period, self.ticks = round(SECOND / values['velocity_rate']), 0
        # velocity ticks of a position tick, and of an answer
        self.every = round(values['velocity_rate'] / values['position_rate'])
        self.stride = 1 if values['drive'] == 'torque' else self.every
        self.torques, self.command, self.heard = (0.0, 0.0), (0.0, 0.0), 0
        self.odom, self.truth = self.create_publisher(Odometry, 'odom', 2000), self.create_publisher(
            Odometry, 'ground_truth', 2000)
        self.joint_states = self.create_publisher(JointState, 'joint_states', 2000)
        if values['drive'] == 'torque':
            self.create_subscription(JointState, 'wheel_torques', self.take_torques, 10)
        else:
            self.create_subscription(TwistStamped, 'cmd_vel', self.take_command, 10)
        self.add_on_set_parameters_callback(self.change)
        self.began = self.get_clock().now().nanoseconds
        self.timer = self.create_timer(0.1 if self.lockstep else self.period / SECOND,
                                       self.ask if self.lockstep else self.follow_clock)
        self.measure()

    def take_torques(self, message):
        """Take the torques of the right and the left wheels."""
        efforts = dict(zip(message.name, message.effort, strict=True))
        self.torques = efforts['wheel_right_joint'], efforts['wheel_left_joint']
        self.take(message.header.stamp, self.torques)

    def take_command(self, message):
        """Take the velocities ahead and around."""
        self.take(message.header.stamp, (message.twist.linear.x, message.twist.angular.z))

    def take(self, stamp, command):
        """Step with the first answer to the present question; an earlier one comes again and does nothing."""
        if not self.lockstep:
            self.command, self.heard = command, self.get_clock().now().nanoseconds
        elif stamp.sec * SECOND + stamp.nanosec == self.stamp() and not self.is_held():
            for _ in range(self.stride):
                self.step(command)

    def is_held(self):
        """Return whether time stands still: the recorder waits for the disk."""
        return self.paused or 0.0 < self.hold_at <= self.stamp() / SECOND

    def change(self, parameters):
        """Follow `paused` and `hold_at`, and ask at once where the robot may go on."""
        held = self.is_held()
        for parameter in parameters:
            setattr(self, parameter.name, parameter.value)
        if self.lockstep and held and not self.is_held():
            self.ask()
        return SetParametersResult(successful=True)

    def follow_clock(self):
        """Step up to the present time, without a command to a stop."""
        now = self.get_clock().now().nanoseconds
        late = (now - self.began) // self.period - self.ticks
        # after a long wait time goes on from here
        self.began += max(0, late - _CATCH_UP) * self.period
        for _ in range(min(late, _CATCH_UP)):
            self.step(self.command if now - self.heard < _TIMEOUT * SECOND else (0.0, 0.0))

    def step(self, command):
        """Advance the robot by a period."""
        self.advance(*command, self.period / SECOND)
        self.ticks += 1
        self.measure()

    def stamp(self):
        """Return the present time [ns]: from the start in lockstep, else of the wall clock."""
        return self.ticks * self.period + (0 if self.lockstep else self.began)

    def measure(self):
        """Publish what the robot measures, and the truth."""
        stamp = Time(sec=self.stamp() // SECOND, nanosec=self.stamp() % SECOND)
        if self.ticks % self.every == 0:
            self.asked = _odometry(stamp, self.robot.odometry, self.robot.of_wheels(*self.robot.speeds))
            self.truth.publish(_odometry(stamp, self.robot.pose, self.robot.velocity))
            self.odom.publish(self.asked)
        self.state = JointState(name=['wheel_right_joint', 'wheel_left_joint'], position=self.robot.angles,
                                velocity=self.robot.speeds,
                                effort=self.torques if self.stride < self.every else ())
        self.state.header.stamp = stamp
        self.joint_states.publish(self.state)
        if self.lockstep:
            self.timer.reset()

    def ask(self):
        """Repeat a question that nobody has answered, byte by byte."""
        self.odom.publish(self.asked)
        self.joint_states.publish(self.state)


def _odometry(stamp, pose, velocity):
    message = Odometry(child_frame_id='base_link')
    message.header.stamp, message.header.frame_id = stamp, 'odom'
    message.pose.pose.position.x, message.pose.pose.position.y = pose[:2]
    message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(pose[2] / 2.0), math.cos(pose[2] / 2.0)
    message.twist.twist.linear.x, message.twist.twist.angular.z = velocity
    return message


if __name__ == '__main__':
    if len(sys.argv) < 2 or sys.argv[1] not in BUILDS:
        sys.exit(f'name a robot: python plant.py {"|".join(BUILDS)} [--ros-args ...]')
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(Plant(sys.argv[1]))
