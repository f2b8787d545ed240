"""The two modes of the plant: it asks and time follows its steps, or it steps by the wall clock."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Iterable, Mapping
from typing import Any

from mobile_robot_control.quantities import period_nanoseconds
from mobile_robot_control.ros.plant.disturbance_input import GridStamps, Now
from mobile_robot_control.ros.plant.questions import LockstepRunControl, QuestionDriver, RunControl
from mobile_robot_control.ros.shared.modes import LockstepMode, WallClockMode
from mobile_robot_control.ros.shared.peers import StallDetector
from mobile_robot_control.ros.shared.stamp_policy import Input


class LockstepPlant(LockstepMode):
    """Each step answers a question of the plant."""

    run_control = LockstepRunControl

    def sources(self, _inputs: Mapping[str, str]) -> dict[str, str]:
        """Return no input: the stall detector names the missing node."""
        return {}

    def awaited(self, _sources: Mapping[str, str], others: Iterable[str]) -> list[str]:
        """Return the other nodes, of which the first step needs an answer each."""
        return [*others]

    def make_driver(
        self, node: Any, inputs: Mapping[str, Input], _rate: float, _position_period: int
    ) -> tuple[QuestionDriver, Any]:
        """Return the driver, and the pace of its questions."""
        (command,) = inputs.values()
        stalls = StallDetector(node, node.shared.peer_timeout, node.loop)
        driver = QuestionDriver(node, node, command.period, node.control, stalls, node.parameters.real_time_factor)
        return driver, driver.pace

    def disturbance_policy(self, node: Any) -> GridStamps:
        """Return the policy for the stamps of pushes."""
        return GridStamps(period_nanoseconds(node.shared.velocity_rate))

    def start_driver(self, driver: QuestionDriver) -> None:
        """Ask the first question."""
        driver.ask()

    def stamp(self, node: Any) -> int:
        """Return the present stamp of messages [ns]."""
        return int(node.now)


class WallClockPlant(WallClockMode):
    """The plant is a simulator beside a clock that goes on by itself."""

    run_control = RunControl

    def disturbance_policy(self, node: Any) -> Now:
        """Return the policy for the stamps of pushes."""
        return Now(node.get_clock(), node.shared.stamp_tolerance)

    def start_driver(self, driver: object) -> None:
        """Wait for the first tick."""

    def stamp(self, node: Any) -> int:
        """Return the present stamp of messages [ns]."""
        return int(node.get_clock().now().nanoseconds)
