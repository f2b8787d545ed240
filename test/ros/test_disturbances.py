"""Pushes on the topic `disturbance` act in the step of their stamp, as in one process; others are refused."""

import contextlib

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import WrenchStamped
from helpers.harness import CONFIG, Robots
from rclpy.node import Node

from mobile_robot_control.quantities import Push
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.topics import LOOPS

FILE = CONFIG / 'backstepping.yaml'
CONSTANT = ['disturbance.time:=0.05', 'disturbance.impulse:=[0.002, -0.001]', 'disturbance.step:=[0.05, 0.02]']


def push(force=0.0, torque=0.0, stamp=0, frame='base_link', **others):
    message = WrenchStamped()
    message.header.frame_id, message.header.stamp = frame, Time(sec=stamp // 10**9, nanosec=stamp % 10**9)
    message.wrench.force.x, message.wrench.torque.z = force, torque
    for name, value in others.items():
        part, axis = name.split('_')
        setattr(getattr(message.wrench, part), axis, value)
    return message


@pytest.fixture
def publisher(robot):
    """Publishes on `disturbance`; the plant that is started next discovers it."""
    return robot.recorder.create_publisher(WrenchStamped, 'disturbance', 10)


def _refused(robot, publisher, message, reason):
    """Publish a message again and again, until the plant has discovered the publisher and refuses it."""
    def refused():
        publisher.publish(message)
        return f'refused a message on disturbance: {reason}' in robot.log()

    robot.spin_until(refused)


@pytest.mark.parametrize('overrides', [CONSTANT, ['friction.coulomb:=0.02']], ids=['ideal motors', 'friction'])
def test_pushes_act_as_in_one_process(robot, publisher, overrides):
    robot.start(composed=True, arguments=['--params-file', FILE, *(word for one in (
        *overrides, 'real_time_factor:=0.0', 'paused:=true', 'duration:=0.4') for word in ('-p', one))])
    robot.spin_until(robot.recorder.has_every_topic)
    _refused(robot, publisher, push(force_y=1.0), 'force.y is not zero')
    robot.set('plant', hold_at=0.1, paused=False)
    robot.spin_until(lambda: robot.time() == 0.1)
    # in the step that comes, with two of stamps that are past; in a later one; and in one that the run does not reach
    for one in (push(3.0), push(1.0, -0.5, 20_000_000), push(0.0, 0.25, 100_000_000), push(-40.0, 2.0, 202_000_000),
                push(9.0, 9.0, 800_000_000)):
        publisher.publish(one)
    publisher.wait_for_all_acked()
    robot.release()
    recording = robot.recording()
    pushes = {50: Push(4.0, -0.25), 101: Push(-40.0, 2.0)}
    configuration = configure(load([FILE], [f'plant.{override}' for override in overrides]))
    simulated, undisturbed = list(rollout(configuration, 0.4, pushes)), list(rollout(configuration, 0.4))
    assert len(recording.samples) == len(simulated)
    for ours, theirs in zip(recording.samples, simulated, strict=True):
        assert ours.torque == pytest.approx(theirs.torque, rel=1e-9, abs=1e-9)
        assert ours.wheels == pytest.approx(theirs.wheels, rel=1e-9, abs=1e-9)
    off = [n for n, (one, other) in enumerate(zip(simulated, undisturbed, strict=True)) if one.wheels != other.wheels]
    # the wheels turn faster from the end of the step on
    assert off[0] == 51


def test_what_cannot_act_is_refused_with_the_reason(robot, publisher):
    robot.start('plant')
    for message, reason in ((push(force_y=1.0), 'force.y is not zero'), (push(torque_x=-1.0), 'torque.x is not zero'),
                            (push(float('nan')), 'wrench not finite'), (push(1e13), 'wrench too large'),
                            (push(1.0, frame='map'), 'frame_id is not base_link'),
                            (push(1.0, stamp=3_000_000), 'stamp not on the grid'),
                            (b'\0\1\0\0' + bytes(20), 'not readable')):
        _refused(robot, publisher, message, reason)
    # of two publishers neither is taken, since their order is not certain
    other = Node('other')
    robot.add(other)
    other.create_publisher(WrenchStamped, 'disturbance', 10)
    _refused(robot, publisher, push(1.0), 'several publishers (2 of them')


def test_a_base_takes_no_pushes(domain, tmp_path):
    with contextlib.closing(Robots(tmp_path, loop=LOOPS['velocity'])) as robot:
        publisher = robot.recorder.create_publisher(WrenchStamped, 'disturbance', 10)
        robot.start('plant', arguments=['-p', 'drive:=velocity'])
        _refused(robot, publisher, push(1.0), 'a base has no forces')
