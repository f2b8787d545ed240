"""The monitor of a node's inputs: their ages, and silent ones."""

import math
import time
from collections import deque
from collections.abc import Mapping

from rclpy.node import Node

from mobile_robot_control.ros.services.robot_clock import SteadyClock
from mobile_robot_control.ros.services.timers import create_steady_timer

_AHEAD, _LATE = 0.01, 0.1
"""[s]: stamps further ahead, or older, show that clocks differ."""
_SECONDS = 3
"""[s] for which even the smallest age must be beyond."""


class InputMonitor:
    """
    Monitors a node's inputs: a silent one is logged once, and its return once.

    Parameters
    ----------
    node : Node
        Node with the inputs.
    sources : mapping of str to str
        Each input topic and its publisher.
    timeout : float
        Wall time of silence [s].
    clock : SteadyClock
        Of the node, for the ages of inputs.

    Attributes
    ----------
    sources : mapping of str to str
        As given.
    latencies : dict of str to float
        Configured latency of inputs that are older than their stamps show [s].

    """

    def __init__(self, node: Node, sources: Mapping[str, str], timeout: float, clock: SteadyClock) -> None:
        self.sources = sources
        self._clock, self._taken_at = clock, dict.fromkeys(sources, -math.inf)
        self._node, self._timeout = node, timeout
        self._received_at = dict.fromkeys(sources, time.monotonic())
        self._reported: set[str] = set()
        self._received: set[str] = set()
        self.latencies: dict[str, float] = {}
        self._stamp_ages: dict[str, float] = dict.fromkeys(sources, 0.0)
        self._least: deque[dict[str, float]] = deque([{}], maxlen=_SECONDS + 1)
        self._ill_timed: dict[str, str] = {}
        create_steady_timer(min(0.5, timeout), self._report_silent, node)

    def note_input(self, topic: str, stamp_age: float) -> None:
        """Note an accepted message on a topic, and the age of its stamp [s]."""
        self._stamp_ages[topic] = stamp_age
        self._least[-1][topic] = min(stamp_age, self._least[-1].get(topic, math.inf))
        self._received_at[topic], self._taken_at[topic] = time.monotonic(), self._clock.now()
        self._received.add(topic)
        if topic in self._reported:
            self._reported.remove(topic)
            self._node.get_logger().info(f'{topic} is back')

    def age(self, topic: str) -> float:
        """Return the robot's time since the newest message of a topic [s]; infinite before the first of a run."""
        return self._clock.now() - self._taken_at.get(topic, -math.inf)

    def stamp_age(self, topic: str) -> float:
        """Return the age of the newest stamp of a topic [s]."""
        return self.age(topic) + self._stamp_ages[topic]

    def note_second(self) -> None:
        """Begin another second, and find stamps that none of the last messages explains."""
        if len(self._least) > _SECONDS:
            self._find_ill_timed()
        self._least.append({})

    def _find_ill_timed(self) -> None:
        found: dict[str, str] = {}
        for topic in self.sources:
            least = min((one[topic] for one in self._least if topic in one), default=0.0)
            latency = self.latencies.get(topic, 0.0)
            if least < -_AHEAD and not self._clock.is_simulated:
                found[topic] = (f'{topic} is stamped {-least:.2f} s in the future: the clocks of two computers differ, '
                                'or its publisher stamps ahead; let chrony or NTP set both clocks')
            elif least > latency + _LATE:
                found[topic] = (f'{topic} is {least:.2f} s old or more when it comes, and {latency:g} s are '
                                'configured: the clocks of two computers differ, or its transport takes so long; let '
                                'chrony or NTP set both clocks, or find the cause of the delay')
        for topic, text in found.items():
            if topic not in self._ill_timed:
                self._node.get_logger().warning(text)
        self._ill_timed = found

    def problems(self) -> list[str]:
        """List problems of time and stamps, in words."""
        return [*self._clock.problems(), *self._ill_timed.values()]

    def forget(self) -> None:
        """Forget the inputs of the previous run."""
        self._taken_at = dict.fromkeys(self.sources, -math.inf)

    def missing(self) -> list[str]:
        """List the nodes without any message, or without one for the timeout."""
        return list(dict.fromkeys(source for topic, source in self.sources.items()
                                  if topic not in self._received or self._is_silent(topic)))

    def _is_silent(self, topic: str) -> bool:
        return time.monotonic() - self._received_at[topic] > self._timeout

    def _report_silent(self) -> None:
        for topic, source in self.sources.items():
            if topic not in self._reported and self._is_silent(topic):
                self._reported.add(topic)
                self._node.get_logger().warning(
                    f'no {topic} for {self._timeout} s: is {source} running, on the same clock as this node?'
                )
