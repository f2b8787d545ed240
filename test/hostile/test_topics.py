"""Any bytes, on any topic that an experiment subscribes to, end neither the recorder nor a node."""

import contextlib
import itertools
import json
import subprocess
import sys

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from helpers.harness import CONFIG, Robots
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from mobile_robot_control.experiment import recorder
from mobile_robot_control.messages.writing import message_class
from mobile_robot_control.ros.shared.diagnostics import SUBSCRIBERS_KEY
from mobile_robot_control.ros.shared.qos import PUBLISHED
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.topics import LOOP_TOPICS

KINDS = {'/diagnostics': 'diagnostic_msgs/msg/DiagnosticArray', '/clock': 'rosgraph_msgs/msg/Clock',
         '/rosout': 'rcl_interfaces/msg/Log', '/parameter_events': 'rcl_interfaces/msg/ParameterEvent',
         **{f'/{name}': topic.kind for name, topic in LOOP_TOPICS.items()}}


def _diagnostics(value):
    values = [KeyValue(key=SUBSCRIBERS_KEY + '/odom', value=value)]
    return serialize_message(DiagnosticArray(status=[DiagnosticStatus(values=values)]))


# none is longer than 52 bytes, as many as a Twist has: DDS takes no more for a type of fixed size
HOSTILE = [b'\0\1\0\0', b'\0\1\0\0' + b'\xff' * 40, b'\0\0\0\0' + b'\xff' * 40, b'\0\1', bytes(50)]
COUNTS = [_diagnostics(value) for value in ('9' * 5000, '-1', '²', '٣')]


def test_any_bytes_are_recorded_and_change_nothing(robot):
    for topic, kind in KINDS.items():
        publisher = robot.recorder.create_publisher(message_class(kind), topic, 100)
        robot.spin_until(lambda publisher=publisher: publisher.get_subscription_count() > 0)
        for message in HOSTILE if topic != '/clock' else HOSTILE[:1]:
            publisher.publish(message)
        for message in COUNTS if topic == '/diagnostics' else ():
            publisher.publish(message)
    # the last message of all, so that the others have been taken in
    taken = []
    robot.recorder.create_subscription(String, '/end', taken.append, 10)
    robot.spin_until(lambda: robot.recorder.count_subscribers('/end'))
    robot.recorder.create_publisher(String, '/end', 10).publish(String())
    robot.spin_until(lambda: taken)
    assert not robot.recorder.all_discovered()


def test_a_topic_whose_package_is_not_installed_is_left_out_with_a_warning(robot, monkeypatch, capfd):
    def missing(kind):
        raise ModuleNotFoundError(f"No module named '{kind.partition('/')[0]}'")

    monkeypatch.setattr(recorder, 'message_class', missing)
    publisher = robot.recorder.create_publisher(String, '/odd', 10)
    printed = []
    robot.spin_until(lambda: 'odd is not recorded' in (printed.append(capfd.readouterr().err) or ''.join(printed)))
    assert "/odd is not recorded: No module named 'std_msgs'" in ''.join(printed)
    assert publisher.get_subscription_count() == 0


def test_any_bytes_as_a_plain_twist_and_beside_an_experiment_end_neither(domain, tmp_path):
    # without a recorder, which takes another kind on cmd_vel
    with contextlib.closing(Robots(tmp_path, ())) as robots:
        node, heard = rclpy.create_node('hostile'), 0
        robots.add(node)
        publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 100)
        run = subprocess.Popen([sys.executable, '-m', 'mobile_robot_control.experiment.command', '--output',
                                tmp_path / 'run', '--duration', '1', '--composed', '--no-report'],
                               stderr=subprocess.PIPE, text=True)
        while run.poll() is None:
            heard = max(heard, publisher.get_subscription_count())
            for message in HOSTILE + COUNTS:
                publisher.publish(message)
            robots.listen(0.05)
        _, errors = run.communicate(timeout=120)
        # after the experiment, which refuses another publisher there: Fast DDS may deadlock where one is deleted
        robots.start('velocity_controller', arguments=['-p', 'stamped_cmd_vel:=false', '-p', 'lockstep:=false'])
        publisher = node.create_publisher(Twist, '/cmd_vel', 10)
        robots.spin_until(lambda: publisher.get_subscription_count() > 0)
        for message in HOSTILE:
            publisher.publish(message)
        robots.spin_until(lambda: 'refused a message on cmd_vel: not readable' in robots.log())
        robots.stop('velocity_controller')
        assert 'Traceback' not in robots.log()
    assert heard
    assert run.returncode == 0, errors
    assert 'Traceback' not in errors
    assert json.loads((tmp_path / 'run' / 'metrics.json').read_text())['outcome'] == 'completed'


@pytest.mark.parametrize(('nodes', 'arguments'), [
    ([*NODES], ['-p', 'publish_clock:=false', '-p', 'hold_at:=0.1']),
    ([*NODES][1:], ['--params-file', CONFIG / 'wall_clock.yaml'])], ids=['lockstep', 'wall clock'])
def test_a_negative_time_on_clock_ends_no_node_and_is_counted(robot, nodes, arguments):
    told = {}
    robot.recorder.create_subscription(DiagnosticArray, '/diagnostics', lambda array: told.update(
        (status.name, {pair.key: pair.value for pair in status.values}) for status in array.status), 100)
    clock = robot.recorder.create_publisher(Clock, '/clock', PUBLISHED)
    robot.start(*nodes, arguments=[*arguments, '-p', 'use_sim_time:=true'], composed=True)
    robot.spin_until(lambda: clock.get_subscription_count() >= len(nodes))
    times = itertools.cycle([100, -1, -2**31, 101])

    def all_counted():
        message = Clock()
        message.clock.sec, message.clock.nanosec = next(times), 2**32 - 1
        clock.publish(message)
        return all(int(told.get(name, {}).get('refused /clock: negative time', 0)) > 1 for name in nodes)

    robot.spin_until(all_counted)
    robot.stop()
