"""
The SROS2 policy against what running nodes create: everything is allowed, and nothing else.

The wheels of Fast DDS have no security plugin, so that nothing is enforced here: the graph is compared.
"""

import contextlib
import os
import subprocess
import sys
import time

import pytest
from geometry_msgs.msg import PoseStamped, TransformStamped, WrenchStamped
from helpers import interfaces
from helpers.harness import CONFIG, Robots
from helpers.policy_reading import allowed
from nav_msgs.msg import Path
from rclpy.node import Node, NodeNameNonExistentError
from std_msgs.msg import String

from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.settings.sros2_policy import policy

TF2 = """
from tf2_msgs.msg import TFMessage

class TransformBroadcaster:
    def __init__(self, node):
        node.create_publisher(TFMessage, '/tf', 1)

    def sendTransform(self, transform):
        pass
"""
"""Stands for tf2_ros, which the wheels do not have: its broadcaster publishes on /tf."""
SLOW = ['-p', 'real_time_factor:=0.05']
"""What is created does not depend on the pace; twelve nodes at full pace take a core."""
MODES = {
    '/lockstep': [*SLOW, '-p', 'noise.velocity:=0.01', '-p', 'odometry_stamped:=sampled', '-p', 'use_sim_time:=true'],
    '/wall_clock': ['--params-file', str(CONFIG / 'wall_clock.yaml')],
    '/base': [*SLOW, '-p', 'drive:=velocity', '-p', 'publish_clock:=false'],
}
"""Arguments by namespace."""
AT_TIMES = {'plant': {('subscribe', topic) for topic in ('reference', 'reference_horizon', 'cmd_accel')},
            'position_controller': {('subscribe', topic) for topic in ('cmd_vel', 'stopped')}}
"""What a node creates besides where a busy machine makes the run stall, or beside another one of its name."""


def created(observer, node):
    """Return what a node publishes, subscribes to, serves and calls, as far as the observer has discovered it."""
    namespace, _, name = node.rpartition('/')
    with contextlib.suppress(NodeNameNonExistentError):
        return {(verb, found) for verb, look in (
            ('publish', observer.get_publisher_names_and_types_by_node),
            ('subscribe', observer.get_subscriber_names_and_types_by_node),
            ('reply', observer.get_service_names_and_types_by_node),
            ('request', observer.get_client_names_and_types_by_node),
        ) for found, _ in look(name, namespace or '/')}
    return set()


def relative(namespace, rules):
    """Return rules with names relative to a namespace, so that robots can be compared."""
    return {(verb, name.removeprefix(f'{namespace}/')) for verb, name in rules}


def seldom(condition):
    """Return a condition that looks five times a second: to ask the graph takes longer than to receive a message."""
    due = 0.0

    def look():
        nonlocal due
        if time.monotonic() < due:
            return False
        due = time.monotonic() + 0.2
        return condition()

    return look


def test_every_node_creates_what_the_policy_allows_and_nothing_else(domain, tmp_path, monkeypatch):
    TFMessage = interfaces.need('tf2_msgs').TFMessage
    (tmp_path / 'tf2_ros.py').write_text(TF2)
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join([str(tmp_path), *filter(None, sys.path)]))
    with contextlib.closing(Robots(tmp_path / 'run', tuple(MODES))) as robots:
        # a robot in each mode, beside a node that publishes on /tf_static, pushes and leads one
        others = Node('others')
        for kind, topic in ((TFMessage, '/tf_static'), (WrenchStamped, '/lockstep/disturbance'),
                            (Path, '/lockstep/path'), (PoseStamped, '/lockstep/goal_pose'),
                            (TransformStamped, '/lockstep/correction')):
            others.create_publisher(kind, topic, 1)
        robots.add(others)
        localised = tmp_path / 'localised.yaml'
        localised.write_text('/**: {ros__parameters: {path_frame: map}}\n'
                             '/**/reference_cart: {ros__parameters: {wait: true}}\n')
        for namespace, arguments in MODES.items():
            more = ['--params-file', str(localised)] if namespace == '/wall_clock' else []
            robots.start(namespace=namespace, arguments=[*arguments, *more], composed=True)
        _compare(robots)


def _compare(robots):
    observer = robots.recorders['/lockstep']
    allowances = {namespace: allowed(policy(namespace))[f'/mobile_robot_control{namespace}/experiment']
                  for namespace in MODES}

    def used(node):
        return set().union(*(relative(namespace, created(observer, f'{namespace}/{node}')) for namespace in MODES))

    def usable(node):
        return relative('/lockstep', allowances['/lockstep'][f'/lockstep/{node}'])

    def maybe(node):
        return AT_TIMES.get(node, set())

    nodes = [*NODES, 'recorder']
    with contextlib.suppress(AssertionError):  # the comparison shows more
        robots.spin_until(seldom(lambda: all(used(node) >= usable(node) - maybe(node) for node in nodes)), 60.0)
    for node in nodes:
        assert used(node) | maybe(node) == usable(node) | maybe(node), node
        for namespace, permitted in allowances.items():
            assert created(observer, f'{namespace}/{node}') <= permitted[f'{namespace}/{node}']
    # on the wall clock there is neither a clock of the plant nor, without noise, a true pose
    assert {('publish', '/clock'), ('publish', '/lockstep/ground_truth')} <= created(observer, '/lockstep/plant')
    assert not {('publish', '/clock'), ('publish', '/wall_clock/ground_truth')} & created(observer, '/wall_clock/plant')
    # what is not in the policy is seen
    observer.create_publisher(String, 'else', 1)
    robots.spin_until(seldom(lambda: used('recorder') - usable('recorder') == {('publish', 'else')}))


@pytest.mark.parametrize('program', [['ros.start.executables', 'plant'], ['experiment.command', '--duration', '0.1']])
def test_what_cannot_be_secured_does_not_start(domain, tmp_path, program):
    security = {'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_STRATEGY': 'Enforce',
                'ROS_SECURITY_KEYSTORE': str(tmp_path), 'ROS_SECURITY_ENCLAVE_OVERRIDE': '/none'}
    output = tmp_path / 'run'
    module, *arguments = [*program, *(['--output', str(output)] if 'experiment' in program[0] else [])]
    done = subprocess.run([sys.executable, '-m', f'mobile_robot_control.{module}', *arguments], capture_output=True,
                          text=True, timeout=120, check=False, env=os.environ | security, stdin=subprocess.DEVNULL)
    assert done.returncode == 2, done.stderr
    assert 'SECURITY ERROR' in done.stderr
    assert 'Traceback' not in done.stderr
    assert not output.exists()
