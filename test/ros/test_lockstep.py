"""Lockstep: start order, nodes killed and restarted, the end of a run, repeated messages."""

import math
import re
import time

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistStamped
from helpers.harness import CONFIG
from helpers.watching import stamp_nanoseconds
from nav_msgs.msg import Odometry, Path
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from mobile_robot_control.ros.shared.qos import LATCHED, PUBLISHED
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import NODES

HYBRID = ('--params-file', str(CONFIG / 'hybrid_backstepping.yaml'))


def test_nodes_may_start_in_any_order(robot):
    # other tests start the plant first
    for name in reversed(NODES):
        robot.start(name, arguments=['-p', 'duration:=1.0', '-p', 'real_time_factor:=0.0'])
        robot.listen(0.5)
    robot.finish()


def test_killed_nodes_are_waited_for_and_the_run_goes_on(robot):
    # a law that starts on the path stays there: what is off it comes from the restarts
    arguments = ['-p', 'duration:=4.0', '-p', 'peer_timeout:=0.5', '-p', 'reference_horizon:=1',
                 '-p', 'feedforward.enabled:=true']
    # held, since discovery by the recorder may take longer than the run
    robot.start(arguments=[*arguments, '-p', 'hold_at:=0.9'])
    for number, name in enumerate(('reference_cart', 'position_controller', 'velocity_controller'), start=1):
        robot.spin_until(lambda: robot.time() > 0.8 * number)  # noqa: B023
        # a slow start has such a line, too
        waits = rf'waiting for {name} at t = ([\d.]+) s'
        before, known = len(re.findall(waits, robot.log('plant'))), robot.writers(name)
        robot.processes[name].kill()
        robot.set('plant', hold_at=0.9 + 0.8 * number)
        robot.spin_until(lambda: len(re.findall(waits, robot.log('plant'))) > before)  # noqa: B023
        stopped_at = pytest.approx(float(re.findall(waits, robot.log('plant'))[-1]), rel=1e-5)
        # on a busy machine the recorder is behind
        robot.spin_until(lambda: robot.time() == stopped_at)  # noqa: B023
        robot.listen(0.3)
        assert robot.time() == stopped_at
        robot.start(name, arguments=arguments)
        robot.spin_until(lambda: re.search(f'{name}.* answered: the run goes on', robot.log('plant')))  # noqa: B023
        # on a busy machine the recorder finds it seconds later than the plant, which is held meanwhile
        robot.spin_until(lambda: len(robot.writers(name) - known) >= len(known))  # noqa: B023
    robot.release()
    robot.spin_until(lambda: robot.time() == 4.0)
    samples = robot.recording().samples
    # the recorder finds a restarted node a moment later than the loop does; the last one comes back at 2.4 s
    assert samples[-1].time >= 2.4
    assert max(math.hypot(*sample.tick.error[:2]) for sample in samples) < 0.05


def test_a_restarted_plant_starts_a_new_run_that_the_others_join(robot):
    arguments = [*HYBRID, '-p', 'duration:=3.0', '-p', 'real_time_factor:=0.0']
    robot.start(*list(NODES)[1:], arguments=arguments, composed=True)
    robot.start('plant', arguments=[*arguments[:-1], 'real_time_factor:=1.0', '-p', 'paused:=true'])
    # not before the recorder has found it
    robot.resume()
    robot.spin_until(lambda: robot.time() > 1.0)
    robot.processes['plant'].kill()
    robot.listen(0.2)
    robot.start('plant', arguments=[*arguments, '-p', 'paused:=true'])
    # the recorder may find the new plant later than the nodes do
    robot.wait_at(0.0)
    robot.resume()
    robot.finish()
    assert robot.log('velocity_controller').count('a new run') == 3
    recording = robot.recording()
    assert recording.samples[0].time == 0.0
    assert recording.samples[-1].time == 3.0


def test_a_plant_killed_at_zero_and_started_again_elsewhere_begins_a_new_run(robot):
    torques = {}
    robot.recorder.create_subscription(JointState, 'wheel_torques', lambda message: torques.update(
        {stamp_nanoseconds(message.header.stamp): tuple(message.effort)}), PUBLISHED)
    arguments = ['-p', 'duration:=0.1', '-p', 'real_time_factor:=0.0', '-p']
    robot.start(*list(NODES)[1:], composed=True)
    robot.start('plant', arguments=[*arguments, 'paused:=true'])
    robot.spin_until(lambda: robot.recorder.has_every_topic() and 0 in torques)
    robot.processes['plant'].kill()
    # the wheels stand at both: only odometry, and the command that answers it, tell the runs apart
    pose = 'initial_pose:=[0.3, -0.2, 0.5]'
    robot.start('plant', arguments=[*arguments, 'paused:=false', '-p', pose])
    robot.finish()
    robot.spin_until(lambda: 100_000_000 in torques)
    simulated = {round(one.time * 1e9): one.torque for one in rollout(configure(load([], [f'plant.{pose}'])), 0.1)}
    assert sorted(torques) == list(simulated)
    for stamp, torque in simulated.items():
        assert torques[stamp] == pytest.approx(torque, rel=1e-9)
    assert robot.log('velocity_controller').count('a new run begins') == 3


def test_a_plant_that_does_not_repeat_its_question_is_named(robot):
    robot.start('reference_cart')
    odom = robot.recorder.create_publisher(Odometry, 'odom', PUBLISHED)
    message = Odometry(child_frame_id='base_link')
    message.header.frame_id, message.pose.pose.orientation.w = 'odom', 1.0

    def named():
        message.pose.pose.position.x += 0.01
        odom.publish(message)
        robot.listen(0.1)
        return 'published by /recorder: ' in robot.log('reference_cart')

    robot.spin_until(named)
    assert 'stamp 0.0 s, which was taken before' in robot.log('reference_cart')


def test_time_stands_still_while_paused_goes_on_in_its_pace_and_up_to_where_it_is_held(robot):
    robot.start(arguments=['-p', 'paused:=true', '-p', 'hold_at:=0.5', '-p', 'real_time_factor:=0.5', '-p',
                           'duration:=1.0'], composed=True)
    robot.spin_until(robot.recorder.has_every_topic)

    def stands_at(stamp):
        """No node publishes another stamp for a while, and the plant misses no answer: slow starts were waited for."""
        waited = robot.log('plant').count('no answer for')
        robot.listen(0.5)
        return (set(robot.recorder.newest.values()), robot.log('plant').count('no answer for')) == ({stamp}, waited)

    assert stands_at(0)
    started = time.monotonic()
    # not by the recorder, which holds the plant itself
    assert all(result.successful for result in robot.set('plant', paused=False))
    robot.wait_at(0.5)
    # a slow machine may fall behind
    assert time.monotonic() - started > 0.7
    assert stands_at(500_000_000)
    # a time in the past holds too, and does not set the run back
    assert all(result.successful for result in robot.set('plant', hold_at=0.25, real_time_factor=0.0))
    robot.listen(0.3)
    assert robot.time() == 0.5
    robot.release()
    assert robot.recording().samples[-1].time == 1.0


def test_a_repeated_stamp_gets_the_same_answer_and_no_step(robot):
    robot.start('velocity_controller', arguments=['-p', 'gains.ti1:=0.05'])
    node, answers = robot.recorder, []
    node.create_subscription(JointState, 'wheel_torques', answers.append, PUBLISHED)
    wheels = node.create_publisher(JointState, 'joint_states', PUBLISHED)
    command = node.create_publisher(TwistStamped, 'cmd_vel', PUBLISHED)
    robot.spin_until(lambda: wheels.get_subscription_count() > 1 and command.get_subscription_count() > 1)

    def answers_to(stamp):
        return [list(answer.effort) for answer in answers if answer.header.stamp.nanosec == stamp]

    def ask(stamp):
        message = JointState(name=['wheel_left_joint', 'wheel_right_joint'], velocity=[0.0, 0.0])
        message.header.stamp = Time(nanosec=stamp)
        count, due = len(answers_to(stamp)), time.monotonic()

        def answered():
            nonlocal due
            # the other side may discover a publisher later, and misses what came before
            if time.monotonic() >= due:
                due += 1.0
                command.publish(order)
                wheels.publish(message)
            return len(answers_to(stamp)) > count

        robot.spin_until(answered)
        return answers_to(stamp)[-1]

    order = TwistStamped()
    order.twist.linear.x = 0.1
    first = ask(0)
    assert first[0] > 0.0
    assert ask(0) == first
    assert ask(0) == first
    # the integral has grown by one step, not by three
    assert ask(2_000_000)[0] - first[0] == pytest.approx(first[0] * 0.002 / 0.05, rel=1e-9)
    # a stamp that is not the next one is refused: no answer
    late = JointState(name=['wheel_right_joint', 'wheel_left_joint'], velocity=[0.0, 0.0])
    late.header.stamp = Time(nanosec=8_000_000)
    wheels.publish(late)
    robot.spin_until(lambda: 'not the next stamp' in robot.log('velocity_controller'))
    # nor to bytes that are no message, after which the run goes on; warnings are two seconds apart
    robot.spin_until(lambda: wheels.publish(b'\0\1\0\0' + bytes(12))
                     or 'joint_states: not readable' in robot.log('velocity_controller'))
    assert ask(4_000_000)[0] > first[0]
    assert {answer.header.stamp.nanosec for answer in answers} == {0, 2_000_000, 4_000_000}


def test_between_position_ticks_odometry_is_repeated_too(robot):
    """A velocity controller restarted there needs the command of the last position tick again."""
    robot.start('plant')
    node, odometry, wheels = robot.recorder, [], []
    torques = node.create_publisher(JointState, 'wheel_torques', PUBLISHED)
    node.create_subscription(Odometry, 'odom', odometry.append, PUBLISHED)

    def answer_the_first(message):
        wheels.append(message.header.stamp.nanosec)
        if message.header.stamp.nanosec == 0:
            torques.publish(JointState(name=message.name, effort=[0.0, 0.0]))

    node.create_subscription(JointState, 'joint_states', answer_the_first, PUBLISHED)
    robot.spin_until(lambda: 2_000_000 in wheels)
    received = len(odometry)
    robot.spin_until(lambda: len(odometry) > received + 3)
    assert {message.header.stamp.nanosec for message in odometry} == {0}


def test_a_run_has_its_frames_a_clock_a_latched_path_and_a_line_for_each_of_its_stages(robot):
    paths, clocks, odometry, references = [], [], [], []
    for kind, topic, found in ((Clock, '/clock', clocks), (Odometry, 'odom', odometry),
                               (Odometry, 'reference', references)):
        robot.recorder.create_subscription(kind, topic, found.append, PUBLISHED)
    robot.start(arguments=['-p', 'duration:=1.0', '-p', 'real_time_factor:=0.0', '-p', 'peer_timeout:=60.0', '-p',
                           'odom_frame_id:=map', '-p', 'base_frame_id:=axle', '-p', 'reference_frame_id:=cart', '-p',
                           'paused:=true'])
    robot.spin_until(lambda: clocks and odometry and references)
    robot.resume()
    robot.finish()
    robot.spin_until(lambda: clocks[-1].clock.sec == 1)
    assert (odometry[0].header.frame_id, odometry[0].child_frame_id) == ('map', 'axle')
    assert (references[0].header.frame_id, references[0].child_frame_id) == ('map', 'cart')
    robot.recorder.create_subscription(Path, 'reference_path', paths.append, LATCHED)
    robot.spin_until(lambda: paths)
    first, last = paths[0].poses[0].pose.position, paths[0].poses[-1].pose.position
    assert math.hypot(first.x - last.x, first.y - last.y) < 1e-12
    robot.stop()
    begin_and_end = ['a run begins', 'ended at t = 1 s']
    for name, waits in (('plant', 'waiting for velocity_controller, position_controller, reference_cart'),
                        ('position_controller', 'waiting for odom from plant, reference from reference_cart'),
                        ('velocity_controller', None), ('reference_cart', None)):
        told = [line.partition(f'[{name}]: ')[2] for line in robot.log(name).splitlines()]
        assert told[1:] == begin_and_end
        assert told[0] == waits or not waits


def test_a_start_far_from_the_cart_is_a_warning(robot):
    robot.start(arguments=['-p', 'plant:initial_pose:=[3.0, 0.0, 0.0]', '-p', 'paused:=true'], composed=True)
    robot.spin_until(lambda: 'set plant.initial_pose' in robot.log())
    where = 'the robot is at (3.00, 0.00) m, the cart at (1.00, 0.00) m'
    assert f'the run starts 2.00 m from the cart: {where}' in robot.log()
