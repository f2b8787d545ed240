"""The start: time from a process's start to the first message of its node, against an empty rclpy node's."""

import contextlib
import statistics
import time
from collections.abc import Iterator
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from std_msgs.msg import Header

from bench import empty_node
from bench.bare_messages import MESSAGES
from bench.ear import Ear
from bench.graph import CONFIG, Graph, new_domain
from bench.progress import say
from bench.row import Row, at_most
from mobile_robot_control.ros.qos import PUBLISHED, SUBSCRIBED

RUNS = 9

# what a node needs before it speaks, and where it speaks first
FIRST: dict[str, tuple[tuple[str, ...], str]] = {
    'empty': ((), empty_node.TOPIC),
    'plant': ((), 'joint_states'),
    'velocity_controller': (('joint_states', 'cmd_vel'), 'wheel_torques'),
    'position_controller': (('odom', 'reference'), 'cmd_vel'),
    'reference_cart': (('odom',), 'reference'),
}


class Midwife(Ear):
    """Starts one node in a domain of its own, where its inputs are at hand."""

    def __init__(self, name: str) -> None:
        super().__init__(new_domain())
        self._name = name
        inputs, first = FIRST[name]
        kind = Header if name == 'empty' else type(MESSAGES[first])
        self._heard: float | None = None
        self.listen_to(first, kind, self._hear, SUBSCRIBED)
        self._inputs: list[tuple[Any, Any]] = [
            (MESSAGES[topic], self.node.create_publisher(type(MESSAGES[topic]), topic, PUBLISHED)) for topic in inputs
        ]
        self.node.create_timer(empty_node.PERIOD, self._feed, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _hear(self, _message: bytes) -> None:
        self._heard = self._heard or time.monotonic()

    def _feed(self) -> None:
        stamp = self.node.get_clock().now().to_msg()
        for message, publisher in self._inputs:
            message.header.stamp = stamp
            publisher.publish(message)

    def time(self) -> float:
        """Start the node; give the seconds until its first message."""
        graph = Graph(self.domain)
        with contextlib.closing(graph):
            self._heard, began = None, time.monotonic()
            if self._name == 'empty':
                graph.start('empty', 'bench.empty_node')
            else:
                graph.start(self._name, 'mobile_robot_control.ros.executables', self._name, '--ros-args',
                            '--params-file', CONFIG / 'wall_clock.yaml')
            self.until(lambda: self._heard is not None, 30.0, graph.check)
            return (self._heard or began) - began


def times(runs: int = RUNS) -> dict[str, list[float]]:
    """Start each node that many times, in turn."""
    found: dict[str, list[float]] = {name: [] for name in FIRST}
    for run in range(runs):
        for name, seconds in found.items():
            with contextlib.closing(Midwife(name)) as midwife:
                seconds.append(midwife.time())
            say(f'start, run {run + 1} of {runs}, {name}: {seconds[-1]:.2f} s')
    return found


def rows() -> Iterator[Row]:
    """Compare times to the first message."""
    found = times()
    empty = found.pop('empty')
    for name, ours in found.items():
        typical, least = statistics.median(ours), statistics.median(empty)
        yield at_most(f'start of {name}', typical / least, 1.3,
                      f'{typical:.2f} to {least:.2f} s to the first message, medians of {len(ours)}')
