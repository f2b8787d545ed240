"""
A node of `examples/foreign_nodes` that goes wrong: ``python faulty_node.py NAME FAULT TIME [--ros-args ...]``.

From the time [s] of its run on it does what FAULT says, once or for each message.
"""

import contextlib
import copy
import importlib.util
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import Vector3Stamped
from rclpy.qos import QoSProfile, ReliabilityPolicy

EXAMPLES = Path(__file__).parents[2] / 'examples' / 'foreign_nodes'
PERIOD = 10_000_000
FAULTS = {
    'dies': ('ended with exit code 3',), 'killed': ('was killed by SIGKILL',), 'hangs': ('gave no answer',),
    'silent': ('gave no answer',), 'deaf': ('gave no answer',), 'floods': ('flooded', 'were asked for'),
    'twice': ('and other numbers',), 'past': ('goes back',), 'future': ('is ahead',), 'nan': ('not finite',),
    'off_grid': ('off the grid',), 'wrong_type': ('is of the type',), 'best_effort': ('as best effort',),
}
"""What the end of a run says of each, one of these."""


def load(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f'{name}.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return getattr(module, ''.join(map(str.capitalize, name.split('_'))))


def shifted(message, nanoseconds):
    changed = copy.deepcopy(message)
    stamp = changed.header.stamp.sec * 10**9 + changed.header.stamp.nanosec + nanoseconds
    changed.header.stamp.sec, changed.header.stamp.nanosec = stamp // 10**9, stamp % 10**9
    return changed


def with_velocity(message, value):
    changed = copy.deepcopy(message)
    (changed.twist.twist if hasattr(changed.twist, 'twist') else changed.twist).linear.x = value
    return changed


class FaultyPublisher:
    """Publishes as another one does, but for the fault."""

    def __init__(self, publisher, fault, at):
        self._publish, self._fault, self._at = publisher.publish, fault, round(at * 1e9)

    def publish(self, message):
        stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        if stamp < self._at:
            self._publish(message)
        else:
            getattr(self, f'_{self._fault}')(message)

    def _dies(self, _):
        os._exit(3)

    def _killed(self, _):
        os.kill(os.getpid(), signal.SIGKILL)

    def _hangs(self, _):
        time.sleep(1e6)

    def _silent(self, _):
        pass

    def _deaf(self, _):
        """Hang, with a child, and take no signal."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(1000)', __file__])
        time.sleep(1e6)

    def _floods(self, message):
        while True:
            self._publish(message)

    def _twice(self, message):
        self._publish(message)
        self._publish(with_velocity(message, 0.123))

    def _past(self, message):
        self._publish(message)
        self._publish(shifted(message, -5 * PERIOD))

    def _future(self, message):
        self._publish(shifted(message, PERIOD))

    def _nan(self, message):
        self._publish(with_velocity(message, math.nan))

    def _off_grid(self, message):
        self._publish(shifted(message, 1))


def main():
    name, fault, at = sys.argv[1], sys.argv[2], float(sys.argv[3])
    rclpy.init()
    kind = load(name)
    if fault in ('wrong_type', 'best_effort'):
        create = kind.create_publisher

        def create_other(node, of, topic, depth, **options):
            if topic not in ('odom', 'cmd_vel', 'reference'):
                return create(node, of, topic, depth, **options)
            return create(node, Vector3Stamped if fault == 'wrong_type' else of, topic, QoSProfile(
                depth=depth, reliability=ReliabilityPolicy.BEST_EFFORT if fault == 'best_effort'
                else ReliabilityPolicy.RELIABLE))

        kind.create_publisher = create_other
        if fault == 'wrong_type':
            kind.answer = kind.ask = lambda *_: None
    else:
        make = kind.create_publisher
        kind.create_publisher = lambda node, of, topic, depth, **options: (
            FaultyPublisher(make(node, of, topic, depth), fault, at) if topic in ('odom', 'cmd_vel', 'reference')
            else make(node, of, topic, depth, **options))
    with contextlib.suppress(KeyboardInterrupt):
        rclpy.spin(kind())


if __name__ == '__main__':
    main()
