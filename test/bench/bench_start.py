"""The start: time from a process's start to the first message of its node, against an empty rclpy node's."""

import contextlib
import statistics
import time
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from std_msgs.msg import Header

from bench import empty_node
from bench.bare_messages import MESSAGES
from bench.graph import CONFIG, Graph, new_domain
from bench.listener import Listener
from bench.progress import show
from bench.row import Row, at_most
from mobile_robot_control.ros.shared.qos import PUBLISHED, SUBSCRIBED

RUNS = 9

# the inputs that a node needs before it publishes, and the topic that it publishes first
FIRST: dict[str, tuple[tuple[str, ...], str]] = {
    'empty': ((), empty_node.TOPIC),
    'plant': ((), 'joint_states'),
    'velocity_controller': (('joint_states', 'cmd_vel'), 'wheel_torques'),
    'position_controller': (('odom', 'reference'), 'cmd_vel'),
    'reference_cart': (('odom',), 'reference'),
}


class StartTimer(Listener):
    """
    Starts one node in a domain of its own, in which its inputs are published, and times its first message.

    Parameters
    ----------
    name : str
        Of the node.
    arguments : sequence of str
        Further ones.

    """

    def __init__(self, name: str, arguments: Sequence[str] = ()) -> None:
        super().__init__(new_domain())
        self._name, self._arguments = name, arguments
        inputs, first = FIRST[name]
        kind = Header if name == 'empty' else type(MESSAGES[first])
        self._received: float | None = None
        self.listen_to(first, kind, self._take, SUBSCRIBED)
        self._inputs: list[tuple[Any, Any]] = [
            (MESSAGES[topic], self.node.create_publisher(type(MESSAGES[topic]), topic, PUBLISHED)) for topic in inputs
        ]
        self.node.create_timer(empty_node.PERIOD, self._feed, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _take(self, _message: bytes) -> None:
        self._received = self._received or time.monotonic()

    def _feed(self) -> None:
        stamp = self.node.get_clock().now().to_msg()
        for message, publisher in self._inputs:
            message.header.stamp = stamp
            publisher.publish(message)

    def time(self) -> float:
        """Start the node; give the time until its first message [s]."""
        graph = Graph(self.domain)
        with contextlib.closing(graph):
            self._received, began = None, time.monotonic()
            if self._name == 'empty':
                graph.start('empty', 'bench.empty_node')
            else:
                graph.start(self._name, 'mobile_robot_control.ros.start.executables', self._name, '--ros-args',
                            '--params-file', CONFIG / 'wall_clock.yaml',
                            '-p', 'feedforward.enabled:=false', '-p', 'reference_horizon:=0', *self._arguments)
            self.until(lambda: self._received is not None, 30.0, graph.check)
            return (self._received or began) - began


def times(
    runs: int = RUNS, nodes: Mapping[str, Sequence[str]] = MappingProxyType(dict.fromkeys(FIRST, ()))
) -> dict[str, list[float]]:
    """Start each node that many times, in turn; nodes by a name that begins with their own, with arguments."""
    found: dict[str, list[float]] = {name: [] for name in nodes}
    for run in range(runs):
        for name, seconds in found.items():
            with contextlib.closing(StartTimer(name.partition(',')[0], nodes[name])) as timer:
                seconds.append(timer.time())
            show(f'start, run {run + 1} of {runs}, {name}: {seconds[-1]:.2f} s')
    return found


def rows() -> Iterator[Row]:
    """Compare times to the first message."""
    found = times()
    empty = found.pop('empty')
    for name, ours in found.items():
        typical, least = statistics.median(ours), statistics.median(empty)
        # Jazzy's empty node starts in 0.27 s, Kilted's in 0.38 s
        yield at_most(f'start of {name}', typical / least, 2.1,
                      f'{typical:.2f} to {least:.2f} s to the first message, medians of {len(ours)}')
