"""Every node on its own clock: the robot tracks, stops when a node stalls, ends or falls silent, and recovers."""

import contextlib
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rclpy
from geometry_msgs.msg import AccelStamped, Twist, TwistStamped
from helpers import stand_in_base
from helpers.harness import CONFIG, Robots
from helpers.watching import Timeline, first_below, settled_below
from rclpy.duration import Duration
from sensor_msgs.msg import JointState

from mobile_robot_control.ros.shared.qos import PUBLISHED
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.topics import WHEEL_JOINTS

ARGUMENTS = ['--params-file', str(CONFIG / 'wall_clock.yaml')]
SOAK = float(os.environ.get('SOAK_SECONDS', '120'))
LAP = 16.0
BOUNDS = {'backstepping': 0.05, 'hybrid_backstepping': 0.05, 'fuzzy': 0.1}
"""RMS error [m]."""
STANDS = 0.01
"""[m/s]."""
SLACK = 0.15
"""[s]: a period or two of each node in between, and the delay due to the busy core."""


def newest(values):
    """Return the newest value of a Timeline; nan before the first."""
    return values[-1][1] if values else math.nan


def test_a_stalled_node_stops_the_robot_until_it_returns(robot):
    seen = Timeline(robot.recorder)
    robot.start(arguments=ARGUMENTS)

    def drives():
        return min(newest(seen.speeds), newest(seen.commands)) > 0.1 and min(
            newest(seen.requested), newest(seen.applied)) > 0.0

    for name, stopped in (
        ('position_controller', lambda: newest(seen.speeds) < 0.05),
        ('reference_cart', lambda: newest(seen.commands) == 0.0),
        ('velocity_controller', lambda: newest(seen.applied) == 0.0),
        ('plant', lambda: newest(seen.requested) == 0.0 and newest(seen.commands) == 0.0),
    ):
        # after a stall the quantity that fell to zero is not zero any more
        robot.spin_until(drives)
        robot.processes[name].signal(signal.SIGSTOP)
        robot.spin_until(stopped)
        robot.processes[name].signal(signal.SIGCONT)
    robot.spin_until(drives)
    robot.spin_until(lambda: newest(seen.errors) < 0.05)
    robot.spin_until(lambda: abs(time.time() - seen.speeds[-1][0]) < 1.0)
    robot.spin_until(lambda: newest(seen.requested) > 0.0)
    # one that ends asks for no torque
    robot.stop('velocity_controller')
    robot.spin_until(lambda: newest(seen.requested) == 0.0)


def test_without_new_torques_the_plant_applies_none_and_ends_in_time(robot):
    seen, node, angles = Timeline(robot.recorder), robot.recorder, []
    node.create_subscription(JointState, 'joint_states', lambda message: angles.append(message.position[0]), PUBLISHED)
    robot.start('plant', arguments=[*ARGUMENTS, '-p', 'duration:=10.0'])
    publisher = node.create_publisher(JointState, 'wheel_torques', PUBLISHED)
    message = JointState(name=list(WHEEL_JOINTS), effort=[0.1, 0.1])

    def publish():
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)

    timer = node.create_timer(0.02, publish)
    robot.spin_until(lambda: newest(seen.applied) == 0.1 and newest(seen.speeds) > 0.1)
    timer.cancel()
    # torque_timeout is 0.1 s
    robot.spin_until(lambda: newest(seen.applied) == 0.0)
    coasting = newest(seen.speeds)
    robot.finish()
    robot.spin_until(lambda: newest(seen.speeds) < 0.5 * coasting)
    assert newest(seen.speeds) > 0.0
    # a message a step, and none of its own at the end
    assert angles[-1] > angles[-2]


def test_only_the_acceleration_of_the_command_acts_and_within_a_bound(robot):
    node, torques = robot.recorder, []
    robot.start('velocity_controller', arguments=[*ARGUMENTS, '-p', 'reference_horizon:=1', '-p',
                                                  'feedforward.enabled:=true'])
    joints, commands, accelerations = (node.create_publisher(kind, topic, PUBLISHED) for kind, topic in (
        (JointState, 'joint_states'), (TwistStamped, 'cmd_vel'), (AccelStamped, 'cmd_accel')))
    node.create_subscription(
        JointState, 'wheel_torques', lambda message: torques.append(max(message.effort)), PUBLISHED)
    accel, mine = AccelStamped(), False

    def publish():
        now = node.get_clock().now()
        wheels = JointState(name=list(WHEEL_JOINTS), position=[0.0, 0.0], velocity=[0.0, 0.0])
        wheels.header.stamp = now.to_msg()
        joints.publish(wheels)
        command = TwistStamped()
        command.header.stamp = now.to_msg()
        # of a stranger, later by less than a message takes
        accel.header.stamp = now.to_msg() if mine else (now + Duration(nanoseconds=1)).to_msg()
        accelerations.publish(accel)
        commands.publish(command)

    node.create_timer(0.01, publish)
    robot.spin_until(lambda: accelerations.get_subscription_count() == 2 and torques)  # the recorder's, too
    mine, accel.accel.linear.x = False, 20.0
    begun = len(torques)
    robot.spin_until(lambda: len(torques) > begun + 100)
    mine, accel.accel.linear.x = True, 1e11
    robot.spin_until(lambda: 'acceleration too large (1e+11 m/s², 0 rad/s² are beyond 100 m/s²' in robot.log())
    assert set(torques) == {0.0}
    accel.accel.linear.x = 20.0
    robot.spin_until(lambda: torques[-1] > 0.0)


def test_another_base_with_plain_commands_follows_the_cart_and_is_stopped_at_the_end(robot):
    errors, commands = Timeline(robot.recorder).errors, []
    robot.recorder.create_subscription(Twist, 'plain_cmd_vel', commands.append, 100)
    base = subprocess.Popen([sys.executable, Path(stand_in_base.__file__), '--plain'])
    try:
        robot.start('position_controller', 'reference_cart', arguments=[
            *ARGUMENTS, '-p', 'odom_frame_id:=map', '-p', 'base_frame_id:=base_footprint', '-p',
            'stamped_cmd_vel:=false', '-r', 'cmd_vel:=plain_cmd_vel'])

        def follows():
            late = [error for _, error in errors[-100:]]
            return 0.0 < math.sqrt(sum(error**2 for error in late) / len(late)) < 0.1 and commands[-1].linear.x != 0.0

        # a node without a turn for some time makes the error larger for a while
        robot.spin_until(lambda: len(errors) > 250 and commands and follows())
        robot.stop('position_controller')
        robot.spin_until(lambda: commands[-1] == Twist())
    finally:
        base.kill()
        base.wait()


def _consequences(seen):
    """List, by stalled node, the signals that fall: name, values, their limit, and the timeout that applies [s]."""
    return {
        'reference_cart': [('cmd_vel', seen.commands, 0.0, 0.5)],
        'velocity_controller': [('applied torque', seen.applied, 0.0, 0.1)],
        'plant': [('wheel_torques', seen.requested, 0.0, 0.1), ('cmd_vel', seen.commands, 0.0, 0.5)],
        # the velocity controller then brakes, for which it needs torque: the speed falls instead
        'position_controller': [('speed', seen.speeds, STANDS, 0.5 + 1.0)],
    }


def _stall(robot, seen, name, bound):
    """Suspend a node until the signals have fallen, and resume it; the robot is on the path again within a lap."""
    stopped = time.time()
    robot.processes[name].signal(signal.SIGSTOP)
    expected = _consequences(seen)[name]
    robot.spin_until(lambda: all(first_below(values, stopped, limit) for _, values, limit, _ in expected), 5.0)
    took = {what: first_below(values, stopped, limit) - stopped for what, values, limit, _ in expected}
    robot.listen(1.0)
    resumed = time.time()
    robot.processes[name].signal(signal.SIGCONT)
    robot.spin_until(lambda: first_below(seen.errors, resumed + 0.5, bound), LAP)
    robot.spin_until(lambda: settled_below(seen.errors, resumed + 0.2, bound, 2.0), LAP + 4.0)
    back = settled_below(seen.errors, resumed + 0.2, bound, 2.0) - resumed
    print(f'{name} stopped: ' + ', '.join(f'{what} at zero after {seconds:.3f} s' for what, seconds in took.items())
          + f'; on the path again {back:.1f} s after it was resumed')
    for what, _, _, timeout in expected:
        assert took[what] < timeout + SLACK, (name, what, took[what])
    assert back < LAP, name


@pytest.mark.soak
@pytest.mark.timeout(SOAK + 240)
@pytest.mark.parametrize('controller', BOUNDS)
def test_beside_a_busy_core_the_robot_tracks_and_recovers_from_each_stopped_node(domain, tmp_path, controller):
    busy = subprocess.Popen([sys.executable, '-c', 'while True: pass'])
    # not recorded, since a recorder takes a core for itself
    with contextlib.closing(Robots(tmp_path, [])) as robot:
        robot.start(arguments=[*ARGUMENTS, '-p', f'position_controller:controller_type:={controller}'])
        listener = rclpy.create_node('listener')
        robot.add(listener)
        seen = Timeline(listener)
        try:
            robot.spin_until(lambda: seen.errors)
            started = time.time()
            while time.time() < started + SOAK:
                print(f'\r{controller}: {time.time() - started:4.0f} of {SOAK:.0f} s', end='', flush=True)
                robot.listen(min(5.0, SOAK / 4))
            assert seen.errors[-1][0] > started + SOAK / 2, robot.log()
            rms = seen.rms_error(started + SOAK / 2)
            print(f'\r{controller}: RMS error {100 * rms:.2f} cm in the second half of {SOAK:.0f} s')
            assert 0.0 < rms < BOUNDS[controller], robot.log()
            for name in NODES:
                _stall(robot, seen, name, BOUNDS[controller])
            robot.stop()
        finally:
            busy.kill()
            busy.wait()
