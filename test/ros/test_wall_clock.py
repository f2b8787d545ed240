"""Every node on its own clock: the robot tracks, stops when a node stalls, and recovers."""

import math
import signal
import time

import pytest
from geometry_msgs.msg import TwistStamped, Vector3Stamped
from harness import CONFIG
from nav_msgs.msg import Odometry
from rclpy.time import Time
from sensor_msgs.msg import JointState

from mobile_robot_control.messages.parsing import WHEEL_JOINTS
from mobile_robot_control.ros.services.qos import PUBLISHED

ARGUMENTS = ['--params-file', str(CONFIG / 'wall_clock.yaml')]

# RMS error in the last seconds [m]
BOUNDS = {'backstepping': 0.05, 'hybrid_backstepping': 0.05, 'fuzzy': 0.1}


class Watch:
    """The values of the newest messages, and all position errors [m] by wall time."""

    def __init__(self, robot):
        self.errors, self.stamp = [], 0
        self.speed = self.command = self.torque = self.requested = math.nan
        node = robot.recorder
        node.create_subscription(Vector3Stamped, 'tracking_error', self._on_error, PUBLISHED)
        node.create_subscription(Odometry, 'odom', self._on_odom, PUBLISHED)
        node.create_subscription(TwistStamped, 'cmd_vel', self._on_command, PUBLISHED)
        node.create_subscription(JointState, 'joint_states', self._on_wheels, PUBLISHED)
        node.create_subscription(JointState, 'wheel_torques', self._on_torques, PUBLISHED)

    def _on_error(self, message):
        self.errors.append((time.monotonic(), math.hypot(message.vector.x, message.vector.y)))

    def _on_odom(self, message):
        self.speed = math.hypot(message.twist.twist.linear.x, message.twist.twist.angular.z)
        self.stamp = Time.from_msg(message.header.stamp).nanoseconds

    def _on_command(self, message):
        self.command = math.hypot(message.twist.linear.x, message.twist.angular.z)

    def _on_wheels(self, message):
        self.torque = max(map(abs, message.effort))

    def _on_torques(self, message):
        self.requested = max(map(abs, message.effort))

    def rms(self, seconds):
        """Return the RMS position error [m] over the last seconds."""
        late = [error for at, error in self.errors if at > time.monotonic() - seconds]
        assert late
        return math.sqrt(sum(error**2 for error in late) / len(late))


@pytest.mark.soak
@pytest.mark.parametrize('controller', BOUNDS)
def test_each_law_tracks_on_the_wall_clock(robot, controller):
    watch = Watch(robot)
    robot.start(arguments=[*ARGUMENTS, '-p', f'position_controller:controller_type:={controller}'])
    robot.spin_until(lambda: watch.errors)
    robot.listen(4.0)
    # the hybrid law seeks the cart first; within a lap each law is on the path
    robot.spin_until(lambda: 0.0 < watch.rms(2.0) < BOUNDS[controller], 16.0)
    robot.spin_until(lambda: abs(time.time_ns() - watch.stamp) < 1e9)
    robot.stop()


def test_a_stalled_node_stops_the_robot_until_it_returns(robot):
    watch = Watch(robot)
    robot.start(arguments=ARGUMENTS)
    robot.spin_until(lambda: watch.errors)
    robot.listen(2.0)
    for name, stopped in (
        ('position_controller', lambda: watch.speed < 0.05),
        ('reference_cart', lambda: watch.command == 0.0),
        ('velocity_controller', lambda: watch.torque == 0.0),
        ('plant', lambda: watch.requested == 0.0 and watch.command == 0.0),
    ):
        robot.spin_until(lambda: watch.speed > 0.1)
        robot.processes[name].signal(signal.SIGSTOP)
        robot.spin_until(stopped)
        robot.processes[name].signal(signal.SIGCONT)
        robot.spin_until(lambda: watch.speed > 0.1 and watch.command > 0.1 and watch.requested > 0.0)
        robot.listen(1.0)
    robot.spin_until(lambda: watch.errors[-1][1] < 0.05)


def test_without_new_torques_the_plant_applies_none_and_ends_in_time(robot):
    watch, node, angles = Watch(robot), robot.recorder, []
    node.create_subscription(JointState, 'joint_states', lambda message: angles.append(message.position[0]), PUBLISHED)
    robot.start('plant', arguments=[*ARGUMENTS, '-p', 'duration:=10.0'])
    publisher = node.create_publisher(JointState, 'wheel_torques', PUBLISHED)
    message = JointState(name=list(WHEEL_JOINTS), effort=[0.1, 0.1])

    def publish():
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)

    timer = node.create_timer(0.02, publish)
    robot.spin_until(lambda: watch.torque == 0.1 and watch.speed > 0.1)
    timer.cancel()
    # torque_timeout is 0.1 s
    robot.spin_until(lambda: watch.torque == 0.0)
    coasting = watch.speed
    robot.finish()
    robot.spin_until(lambda: watch.speed < 0.5 * coasting)
    assert watch.speed > 0.0
    # a message a step, and none of its own at the end
    assert angles[-1] > angles[-2]
