"""Other publishers on the topics of a robot: counted and named, contradictions refused, and no run stuck for good."""

import contextlib
import math
import subprocess
import sys
from pathlib import Path

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped
from helpers import stand_in_base
from helpers.harness import CONFIG, Robots
from helpers.watching import Timeline
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from mobile_robot_control.experiment.node_processes import NodeProcess, stop_processes
from mobile_robot_control.ros.shared.qos import PUBLISHED, SUBSCRIBED

BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
WALL_CLOCK = ['--params-file', str(CONFIG / 'wall_clock.yaml')]


class Stranger(Node):
    """A node of this process that publishes beside those of a robot."""

    def __init__(self, robot, name='stranger'):
        super().__init__(name)
        robot.add(self)

    def odometry(self, x):
        """Return odometry of a robot elsewhere."""
        message = Odometry(child_frame_id='base_link')
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = 'odom'
        message.pose.pose.position.x, message.pose.pose.orientation.w = x, 1.0
        return message


@pytest.fixture
def said(robot):
    """Diagnostics by node: the newest status, its values as a mapping."""
    found = {}

    def take(array):
        for status in array.status:
            found[status.name] = (status.level, status.message, {one.key: one.value for one in status.values})

    robot.recorder.create_subscription(DiagnosticArray, '/diagnostics', take, 10)
    return found


def test_a_stranger_that_answers_with_other_numbers_is_counted_and_named(robot, said):
    stranger = Stranger(robot)
    other = stranger.create_publisher(TwistStamped, 'cmd_vel', PUBLISHED)

    def answer_too(message):
        if message.twist.angular.z != 9.0:
            message.twist.angular.z = 9.0
            other.publish(message)

    stranger.create_subscription(TwistStamped, 'cmd_vel', answer_too, SUBSCRIBED)
    # without an end: how often the stranger's answer comes in time depends on the machine
    robot.start(arguments=['-p', 'paused:=true'], composed=True)
    robot.resume()
    reason = 'refused cmd_vel: other numbers for a stamp'
    robot.spin_until(lambda: int(said.get('velocity_controller', (0, '', {}))[2].get(reason, 0)) > 10)
    # the names are discovered after the publishers
    names = 'cmd_vel has several publishers (/position_controller and /stranger)'
    robot.spin_until(lambda: names in said['velocity_controller'][1])
    level, _, values = said['velocity_controller']
    assert level == b'\x01'
    assert values['publishers of cmd_vel'] == '/position_controller and /stranger'
    robot.spin_until(lambda: 'publishers of cmd_vel' in said.get('position_controller', (0, '', {}))[2])
    robot.stop()
    # the first answer counted every time
    assert max(abs(sample.wheels.right) for sample in robot.recording().samples) < 60.0
    assert 'cmd_vel has several publishers: /position_controller and /stranger; stop all but one' in robot.log()


def test_a_second_plant_that_comes_and_goes_does_not_hold_the_run_up(robot, tmp_path):
    robot.start(arguments=['-p', 'duration:=1.0', '-p', 'hold_at:=0.5', '-p', 'peer_timeout:=0.5'], composed=True)
    robot.spin_until(lambda: robot.time() == 0.5)
    second = NodeProcess(['plant'], ['--ros-args', '-p', 'peer_timeout:=0.5'], tmp_path / 'second.log')
    # its question at t = 0 begins a run of its own for the others
    robot.spin_until(lambda: robot.log().count('a new run begins') >= 2)
    stop_processes([second])
    robot.release()
    assert 'joined a run under way at t = ' in robot.log()


def test_contradicting_odometry_stops_the_robot_on_the_wall_clock(robot, said):
    line = Timeline(robot.recorder)
    # the robot stands for so long after the last contradiction, which this process may be late to publish
    robot.start(arguments=[*WALL_CLOCK, '-p', 'position_controller:input_timeout:=3.0'])
    robot.spin_until(lambda: len(line.speeds) > 50 and line.speeds[-1][1] > 0.2)
    stranger = Stranger(robot)
    odom = stranger.create_publisher(Odometry, 'odom', PUBLISHED)
    timer = stranger.create_timer(0.05, lambda: odom.publish(stranger.odometry(-3.0)))
    # the names are discovered after the publishers
    robot.spin_until(lambda: 'contradict' in (told := said.get('position_controller', (0, ''))[1])
                     and '/plant and /stranger' in told)
    level, message, _ = said['position_controller']
    assert level == b'\x02'
    assert message.startswith('stopped: odom has several publishers that contradict each other')
    robot.spin_until(lambda: line.commands[-1][1] == 0.0)
    begun = line.commands[-1][0]
    robot.listen(1.0)
    assert all(value == 0.0 for at, value in line.commands if at > begun)
    # who takes the risk may switch it off
    result, = robot.set('position_controller', stop_on_odom_conflict=False)
    assert result.successful
    robot.spin_until(lambda: line.commands[-1][1] > 0.0)
    result, = robot.set('position_controller', stop_on_odom_conflict=True)
    robot.spin_until(lambda: line.commands[-1][1] == 0.0)
    stranger.destroy_timer(timer)
    # where it was due already, it is called once more
    robot.listen(0.1)
    stranger.destroy_publisher(odom)
    robot.spin_until(lambda: line.commands[-1][1] > 0.1 and said['position_controller'][1] == 'running')
    robot.stop()


def test_best_effort_odometry_is_taken_on_the_wall_clock_and_what_does_not_fit_is_told(robot, said):
    line = Timeline(robot.recorder)
    base = Stranger(robot, 'base')
    odom = base.create_publisher(Odometry, 'odom', BEST_EFFORT)
    # a command that is not repeated is not taken: the velocity controller must not miss one
    base.create_publisher(TwistStamped, 'cmd_vel', BEST_EFFORT)
    base.create_timer(0.05, lambda: odom.publish(base.odometry(1.0)))
    robot.start('position_controller', 'reference_cart', 'velocity_controller', arguments=WALL_CLOCK)
    robot.spin_until(lambda: line.errors and math.isfinite(line.errors[-1][1]))
    text = 'a publisher on cmd_vel is not connected: its reliability does not fit the subscription of this node'
    robot.spin_until(lambda: text in said.get('velocity_controller', (0, '', {}))[2].get(
        'quality of service of cmd_vel', ''))
    assert text in robot.log('velocity_controller')
    robot.stop()


@pytest.mark.parametrize('stamped', [True, False])
def test_a_command_that_no_node_takes_is_told_and_so_is_a_node_that_takes_another_type(domain, tmp_path, stamped):
    with contextlib.ExitStack() as stack:
        robot = stack.enter_context(contextlib.closing(Robots(tmp_path, [])))  # no recorder listens yet
        driver, told = rclpy.create_node('driver'), {}
        robot.add(driver)
        odom = driver.create_publisher(Odometry, 'odom', PUBLISHED)
        driver.create_timer(0.05, lambda: odom.publish(Stranger.odometry(driver, 1.0)))
        driver.create_subscription(DiagnosticArray, '/diagnostics', lambda array: told.update(
            (status.name, (status.level, status.message)) for status in array.status), 10)
        robot.start('position_controller', 'reference_cart', composed=True, arguments=[
            *WALL_CLOCK, '-p', f'stamped_cmd_vel:={str(stamped).lower()}'])

        def says(text):
            level, message = told.get('position_controller', (b'', ''))
            return level == b'\x01' and text in message

        robot.spin_until(lambda: says('running: no node takes /cmd_vel: nothing moves the robot'))
        own, other = (TwistStamped, Twist) if stamped else (Twist, TwistStamped)
        base = stack.enter_context(subprocess.Popen([
            sys.executable, Path(stand_in_base.__file__), *['--plain'] * stamped, '--ros-args', '-r',
            'odom:=elsewhere', '-r', 'plain_cmd_vel:=cmd_vel']))
        stack.callback(base.kill)
        text = (f'/base takes /cmd_vel as {other.__name__}, and this node publishes {own.__name__}; set '
                f'stamped_cmd_vel to {str(not stamped).lower()} on the wall clock')
        robot.spin_until(lambda: says(text))
        # also while another node listens
        driver.create_subscription(own, 'cmd_vel', lambda _: None, 10)
        robot.spin_until(lambda: says(text) and not says('no node takes'))
        assert text in robot.log('position_controller')
