"""The two modes of a node, of which its constructor chooses one: lockstep, or the wall clock."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile

from mobile_robot_control.ros.shared.clock import RobotClock, SteadyClock
from mobile_robot_control.ros.shared.diagnostics import OverrunCounter
from mobile_robot_control.ros.shared.lockstep import LockstepDriver
from mobile_robot_control.ros.shared.qos import SENSORS, SUBSCRIBED
from mobile_robot_control.ros.shared.stamp_policy import Input
from mobile_robot_control.ros.shared.wall_clock import FixedRateTimer, WallClockDriver
from mobile_robot_control.topics import MEASURED_TOPICS, LoopGraph


class NodeMode:
    """What both modes share."""

    def awaited(self, sources: Mapping[str, str], _others: Iterable[str]) -> list[str]:
        """Return, in words, what a node awaits of the others before its first step."""
        return [f'{topic} from {source}' for topic, source in sources.items()]


class LockstepMode(NodeMode):
    """A node answers the questions of the plant; time is that of their stamps."""

    checks_beside = False  # time waits for the check of a live change

    def make_clock(self, node: Node, _after_jump_back: Callable[[], None]) -> SteadyClock:
        """Return the clock of inputs and timers; `after_jump_back` is called after its jump back."""
        return SteadyClock(node)

    def sources(self, inputs: Mapping[str, str]) -> dict[str, str]:
        """Return the inputs whose silence is told, and the publisher of each in words."""
        return {**inputs}

    def listeners(self, loop: LoopGraph, name: str) -> Mapping[str, Any]:
        """Return the nodes that must listen to a node's outputs."""
        return loop.listeners_of(name)

    def quality(self, _topic: str) -> QoSProfile:
        """Return the quality of service of an input."""
        return SUBSCRIBED

    def make_driver(
        self, node: Any, inputs: Mapping[str, Input], rate: float, position_period: int
    ) -> tuple[Any, OverrunCounter | None]:
        """Return the driver of a node at a rate [Hz], and what counts its overruns, if anything does."""
        return LockstepDriver(node, inputs, 1.0 / rate, position_period), None


class WallClockMode(NodeMode):
    """A node steps at its own rate with its newest inputs."""

    checks_beside = True

    def make_clock(self, node: Node, after_jump_back: Callable[[], None]) -> SteadyClock:
        """Return the clock of inputs and timers; `after_jump_back` is called after its jump back."""
        return RobotClock(node, after_jump_back)

    def sources(self, inputs: Mapping[str, str]) -> dict[str, str]:
        """Return the inputs whose silence is told; the plant is mostly a robot's driver or another simulator."""
        return {topic: f'the base ({topic})' if node == 'plant' else node for topic, node in inputs.items()}

    def listeners(self, _loop: LoopGraph, _name: str) -> Mapping[str, Any]:
        """Return no node: none must listen."""
        return {}

    def quality(self, topic: str) -> QoSProfile:
        """Return the quality of service of an input; measurements come from best-effort publishers, too."""
        return SENSORS if topic in MEASURED_TOPICS else SUBSCRIBED

    def make_driver(
        self, node: Any, inputs: Mapping[str, Input], rate: float, _position_period: int
    ) -> tuple[Any, OverrunCounter | None]:
        """Return the driver of a node at a rate [Hz], and the timer that counts its overruns."""
        driver = WallClockDriver(node, inputs, rate, node.get_clock(), node.shared.stamp_tolerance, node.monitor.age)
        return driver, FixedRateTimer(node.robot_clock, rate, driver.tick)
