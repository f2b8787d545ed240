"""A recording that begins and ends while the robot drives."""

import time
from types import SimpleNamespace

import pytest
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry, Path
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from mobile_robot_control.experiment.recorder import NO_LIMIT, Recorder
from mobile_robot_control.messages.parsing import serialised_stamp
from mobile_robot_control.ros.shared.qos import LATCHED
from mobile_robot_control.ros.start.spin import make_executor
from mobile_robot_control.topics import LOOPS


@pytest.fixture
def executor(domain):
    rclpy.init(args=[])
    yield make_executor()
    rclpy.shutdown()


def spin_until(executor, condition):
    """Spin until a condition holds; fail if it does not in time."""
    deadline = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < deadline
        executor.spin_once(timeout_sec=0.05)


def test_every_topic_of_the_loop_begins_and_ends_at_the_same_stamp(executor):
    recorded = []
    recorder = Recorder('/', lambda topic, kind, received, message, latched: recorded.append(
        (topic, serialised_stamp(message))), lambda kind: True, LOOPS['torque'])
    talker = rclpy.create_node('talker')
    publishers = {topic: talker.create_publisher(JointState, topic, 10) for topic in ('joint_states', 'wheel_torques')}
    executor.add_node(recorder)
    executor.add_node(talker)

    def publish(topic, *stamps):
        spin_until(executor, lambda: publishers[topic].get_subscription_count() > 0)
        for stamp in stamps:
            publishers[topic].publish(JointState(header=Header(stamp=Time(nanosec=stamp))))
        spin_until(executor, lambda: recorder.newest.get(topic) == stamps[-1])

    recorder.first = NO_LIMIT
    publish('joint_states', 0)
    publish('wheel_torques', 0)
    recorder.first = 1
    publish('joint_states', 1, 2, 3)
    publish('wheel_torques', 1)
    recorder.last = max(recorder.newest.values())
    publish('joint_states', 4)
    assert not recorder.is_complete()
    publish('wheel_torques', 2, 3)
    assert recorder.is_complete()
    publish('wheel_torques', 4)
    talker.destroy_node()
    loop = [each for each in recorded if each[0] in ('/joint_states', '/wheel_torques')]
    assert sorted(loop) == [(topic, stamp) for topic in ('/joint_states', '/wheel_torques') for stamp in (1, 2, 3)]


def test_odometry_of_a_driver_without_repetitions_is_recorded(executor):
    recorded = []
    recorder = Recorder('/', lambda topic, *_: recorded.append(topic), lambda kind: True, LOOPS['velocity'])
    talker = rclpy.create_node('talker')
    publisher = talker.create_publisher(Odometry, 'odom', qos_profile_sensor_data)
    executor.add_node(recorder)
    executor.add_node(talker)

    def is_recorded():
        publisher.publish(Odometry())
        return '/odom' in recorded

    spin_until(executor, is_recorded)
    talker.destroy_node()


def test_a_run_may_begin_once_the_latched_path_of_the_cart_is_recorded(executor):
    loop, recorded = LOOPS['velocity'], []
    recorder = Recorder('/', lambda topic, *_: recorded.append(topic), lambda kind: True, loop)
    recorder.newest.update(dict.fromkeys(loop.topics, 0))
    talker = rclpy.create_node('talker')
    executor.add_node(recorder)
    diagnostics = [talker.create_publisher(DiagnosticArray, '/diagnostics', 10) for _ in loop.nodes]
    spin_until(executor, lambda: recorder.count_publishers('/diagnostics') == len(diagnostics))
    assert not recorder.has_every_node()
    talker.create_publisher(Path, 'reference_path', LATCHED).publish(Path())
    spin_until(executor, recorder.has_every_node)
    assert '/reference_path' in recorded
    talker.destroy_node()


def test_what_waits_is_recorded_although_the_process_did_not_run_for_a_while():
    recorder, waiting, turns = SimpleNamespace(received=0), [3, 2, 1], []

    def turn():
        turns.append(waiting)
        if len(turns) == 1:  # the time is up before it has looked
            time.sleep(0.2)
        elif waiting:
            recorder.received = waiting.pop()

    Recorder.drain(recorder, turn, 0.1, 60.0)
    assert not waiting
