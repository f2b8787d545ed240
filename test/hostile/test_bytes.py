"""Any bytes on every topic that nodes and experiments subscribe to end none of them, and refusals are counted."""

import contextlib
import json
import os
import random
import subprocess
import sys
from functools import partial

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from helpers.harness import Robots
from rclpy.serialization import deserialize_message

from hostile.contents import spoilt_bytes
from mobile_robot_control.messages.writing import message_class
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.topics import ALL_LOOP_TOPICS

KINDS = {**{topic: row.kind for topic, row in ALL_LOOP_TOPICS.items()},
         'diagnostics': 'diagnostic_msgs/msg/DiagnosticArray',
         'tf': 'tf2_msgs/msg/TFMessage', 'rosout': 'rcl_interfaces/msg/Log', 'clock': 'rosgraph_msgs/msg/Clock',
         'parameter_events': 'rcl_interfaces/msg/ParameterEvent', 'beside': 'std_msgs/msg/String'}
"""Types by topic: those of the loop, those of ROS, and one beside the loop."""
LARGEST = {'geometry_msgs/msg/Twist': 52, 'rosgraph_msgs/msg/Clock': 12}
"""Bytes that DDS takes of a type of fixed size."""
INPUTS = ('odom', 'reference', 'cmd_vel', 'joint_states', 'wheel_torques', 'reference_horizon', 'cmd_accel')
_FED = ['-p', 'reference_horizon:=1', '-p', 'feedforward.enabled:=true']
_HEADS = [b'\0\1\0\0', b'\0\0\0\0', b'\0\3\0\0', b'\0\7\0\0', b'\xff\xff\xff\xff', b'']


def hostile(draw, sound, largest=4000):
    """Draw bytes: a sound message spoilt, or random ones behind a head of CDR."""
    if sound and draw.random() < 0.5:
        return spoilt_bytes(draw, sound)[:largest]
    words = [draw.choice((b'\0\0\0\0', b'\1\0\0\0', b'\xff\xff\xff\xff', b'\0\0\xf0\x7f',
                          draw.randbytes(draw.randrange(9)))) for _ in range(draw.choice((0, 1, 10, 100)))]
    return (draw.choice(_HEADS) + b''.join(words))[:largest] or b'\0'


class Hostile:
    """A node that publishes hostile bytes on all topics, and counts what nodes report as refused."""

    def __init__(self, robots, seed):
        self._draw = random.Random(seed)  # noqa: S311 (bytes, no secrets)
        self._robots, self.refused, self._sound = robots, {}, {}
        self.node = rclpy.create_node('hostile')
        robots.add(self.node)
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._count, 100, raw=True)
        self.publishers = {}
        for topic, kind in KINDS.items():
            with contextlib.suppress(ModuleNotFoundError):  # the wheels have no tf2_msgs
                self.publishers[topic] = self.node.create_publisher(message_class(kind), f'/{topic}', 100)
        for topic in INPUTS:
            self.node.create_subscription(message_class(KINDS[topic]), f'/{topic}', partial(
                self._sound.setdefault, topic), 10, raw=True)

    def _count(self, message):
        # bytes of this very node are among them: those of the nodes begin with their names
        for name in NODES:
            if name.encode() in message and b'refused' in message:
                status, = deserialize_message(message, DiagnosticArray).status
                self.refused[name] = next(int(pair.value) for pair in status.values if pair.key == 'refused')

    def publish(self, count):
        """Publish so many messages, on all topics in turn."""
        topics = list(self.publishers)
        for n in range(count):
            topic = topics[n % len(topics)]
            self.publishers[topic].publish(
                hostile(self._draw, self._sound.get(topic), LARGEST.get(KINDS[topic], 4000)))
            if n % 20 == 0:
                self._robots.listen(0.005)


@pytest.mark.parametrize(('arguments', 'count'), [
    (['-p', 'lockstep:=true', '-p', 'real_time_factor:=0.2'], 300),
    pytest.param(['-p', 'lockstep:=true', '-p', 'real_time_factor:=0.2'], 10_000, marks=pytest.mark.soak),
    pytest.param(['-p', 'lockstep:=false', '-p', 'use_sim_time:=false'], 10_000, marks=pytest.mark.soak),
])
@pytest.mark.timeout(900)
def test_hostile_bytes_end_no_node_and_are_counted(domain, tmp_path, arguments, count):
    seed = os.environ.get('ADVERSARY_SEED', '1')
    print(f'\nADVERSARY_SEED={seed}', flush=True)
    robots = Robots(tmp_path / 'robots', ())
    try:
        robots.start(composed=True, arguments=[*arguments, *_FED, '-p', 'peer_timeout:=60.0'])
        beside = Hostile(robots, seed)
        robots.spin_until(lambda: all(beside.node.count_subscribers(f'/{topic}') >= 2 for topic in INPUTS))
        beside.publish(count)
        # on a node that has discovered a publisher later, what came before is lost
        robots.spin_until(lambda: (len(beside.refused) == len(NODES) and all(beside.refused.values()))
                          or beside.publish(len(beside.publishers)))
        print(f'{count} messages; refused: {beside.refused}')
        robots.stop()
        assert 'Traceback' not in robots.log()
    finally:
        robots.close()


@pytest.mark.soak
@pytest.mark.timeout(300)
def test_an_experiment_beside_hostile_bytes_ends_with_its_metrics(domain, tmp_path):
    robots = Robots(tmp_path / 'robots', ())
    try:
        beside = Hostile(robots, os.environ.get('ADVERSARY_SEED', '1'))
        # another publisher on a topic of the loop is refused before the run; on the others bytes may come
        for topic in ALL_LOOP_TOPICS:
            beside.node.destroy_publisher(beside.publishers.pop(topic))
        run = subprocess.Popen(
            [sys.executable, '-m', 'mobile_robot_control.experiment.command', '--output', tmp_path / 'run',
             '--duration',
             '2', '--composed', '--no-report'], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while run.poll() is None:
            beside.publish(100)
        _, errors = run.communicate(timeout=60)
    finally:
        robots.close()
    assert run.returncode == 0, errors
    assert 'Traceback' not in errors
    assert json.loads((tmp_path / 'run' / 'metrics.json').read_text())['outcome'] == 'completed'
