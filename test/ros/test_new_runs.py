"""A reset begins a new run that equals a fresh one to the last bit; a held run is stepped by hand."""

import contextlib
import math

import pytest
from helpers.harness import CONFIG, PERIOD, Robots
from nav_msgs.msg import Odometry
from rcl_interfaces.srv import GetParameters

from mobile_robot_control.ros.shared.qos import PUBLISHED
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.topics import LOOPS

HYBRID = CONFIG / 'hybrid_backstepping.yaml'
IMPERFECT = ['-p', 'noise.pose:=[0.01, 0.02, 0.005]', '-p', 'delay.velocity_steps:=2', '-p',
             'initial_pose:=[0.8, 0.1, 0.0]']
QUICK = ['--params-file', str(HYBRID), '-p', 'real_time_factor:=0.0', '-p', 'paused:=true']
"""As fast as it goes, and paused at first."""


def test_a_run_after_a_reset_equals_a_fresh_one_to_the_last_bit(robot):
    robot.start(arguments=[*QUICK, '-p', 'duration:=0.6', *IMPERFECT], composed=True)
    robot.spin_until(robot.recorder.has_every_topic)
    # at stamp 0 a reset waits: the run goes on to the first position tick, and holds at the start of the new one
    assert robot.trigger('plant/reset') == (True, 'a new run from [0.8, 0.1, 0.0] begins after t = 0.01 s')
    robot.spin_until(lambda: robot.log().count('a new run begins') == 4)
    robot.wait_at(0.0)
    # twice at the same stamp, in the middle of what backstepping and PI law remember
    for _ in range(2):
        assert all(result.successful for result in robot.set('plant', hold_at=0.4, paused=False))
        robot.wait_at(0.4)
        assert robot.trigger('plant/reset')[0]
    robot.release()
    assert robot.log().count('a new run begins') == 3 * len(NODES)
    assert 'refused' not in robot.log()
    # four runs, and every stamp has one message of each topic, repeated
    found = robot.messages()
    assert len(found['wheel_torques']) == 301
    assert len(found['cmd_vel']) == 61
    assert all(len(messages) == 1 for stamps in found.values() for messages in stamps.values())


def test_a_new_initial_pose_acts_at_the_next_reset(robot):
    robot.start(arguments=[*QUICK, '-p', 'duration:=0.3', '-p', 'hold_at:=0.104'], composed=True)
    robot.spin_until(robot.recorder.has_every_topic)
    robot.set('plant', paused=False)
    robot.spin_until(lambda: robot.time() == 0.104)
    assert robot.log().count('a run begins') == 4
    result, = robot.set('plant', initial_pose=[0.5, -0.5, 1.0])
    assert result.successful, result.reason
    # between position ticks the run goes on to the next one
    assert robot.trigger('plant/reset') == (True, 'a new run from [0.5, -0.5, 1.0] begins after t = 0.11 s')
    # it holds again where it did
    robot.wait_at(0.104, 'joint_states', 'wheel_torques')
    robot.release()
    recording = robot.recording()
    assert recording.problems == ('1 earlier runs left out; the last one is taken',)
    first, last = recording.samples[0], recording.samples[-1]
    assert tuple(first.tick.pose) == pytest.approx((0.5, -0.5, 1.0))
    assert (first.time, last.time, len(recording.samples)) == (0.0, 0.3, 151)


def test_a_held_run_is_stepped_by_position_ticks_and_a_running_one_is_not(robot):
    robot.start(arguments=QUICK, composed=True)
    robot.spin_until(robot.recorder.has_every_topic)
    for tick in (1, 2):
        assert robot.trigger('plant/step') == (True, f'time goes on to t = {0.01 * tick:g} s')
        robot.wait_at(0.01 * tick)
    robot.set('plant', paused=False, hold_at=0.104)
    robot.spin_until(lambda: robot.time() == 0.104)
    assert robot.trigger('plant/step') == (True, 'time goes on to t = 0.11 s')
    robot.wait_at(0.11)
    robot.set('plant', hold_at=0.0)
    success, message = robot.trigger('plant/step')
    assert not success
    assert 'set the parameter paused to true first' in message
    # after a reset the plant is held no farther ahead of what is recorded
    robot.resume()
    robot.spin_until(lambda: robot.time() > 1.5)
    robot.set('plant', paused=True)
    assert robot.trigger('plant/reset')[0]
    robot.wait_at(0.0)
    client = robot.recorder.create_client(GetParameters, 'plant/get_parameters')
    robot.spin_until(client.service_is_ready)
    robot.spin_until(lambda: robot.call(lambda: client.call_async(GetParameters.Request(
        names=['hold_at']))).values[0].double_value == 500 * PERIOD / 1e9)


def test_a_base_that_takes_velocities_is_reset_and_stepped_as_well(domain, tmp_path):
    with contextlib.closing(Robots(tmp_path, loop=LOOPS['velocity'])) as robot:
        robot.start(arguments=[*QUICK[2:], '-p', 'drive:=velocity', '-p', 'duration:=0.2'], composed=True)
        robot.spin_until(robot.recorder.has_every_topic)
        assert robot.trigger('plant/step')[0]
        robot.spin_until(lambda: robot.recorder.newest['cmd_vel'] == 10_000_000)
        assert robot.trigger('plant/reset') == (True, 'a new run from [1.0, 0.0, 1.5708] begins after t = 0.01 s')
        robot.wait_at(0.0)
        robot.set('plant', paused=False)
        robot.finish()
        assert robot.log().count('a new run begins') == 3
        found = robot.messages()
    assert len(found['cmd_vel']) == 21
    assert all(len(messages) == 1 for stamps in found.values() for messages in stamps.values())


def test_on_the_wall_clock_a_reset_moves_the_robot_alone(robot):
    robot.start(arguments=['--params-file', str(CONFIG / 'wall_clock.yaml'), '-p',
                           'reference_cart:wait:=true'], composed=True)
    robot.spin_until(robot.recorder.has_every_topic)
    success, message = robot.trigger('plant/step')
    assert not success
    assert 'in lockstep' in message
    poses = []
    robot.recorder.create_subscription(Odometry, 'odom', lambda message: poses.append(message.pose.pose.position),
                                       PUBLISHED)
    result, = robot.set('plant', initial_pose=[-2.0, 3.0, 0.0])
    assert result.successful, result.reason
    robot.spin_until(lambda: poses)
    # it still drives on the path
    assert math.hypot(poses[-1].x, poses[-1].y) < 1.5
    assert robot.trigger('plant/reset') == (
        True, 'the robot stands at [-2.0, 3.0, 0.0]; on the wall clock the other nodes go on as they are')
    # it drives away from there, while this process may have no turn
    robot.spin_until(lambda: any(abs(pose.x + 2.0) < 0.3 and abs(pose.y - 3.0) < 0.3 for pose in poses))
