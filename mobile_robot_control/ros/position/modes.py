"""The two modes of the position controller: the age of odometry, and the guard of the robot."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from functools import partial
from typing import Any

from mobile_robot_control.ros.position.law_runner import LawRunner
from mobile_robot_control.ros.position.namesakes import COMMAND
from mobile_robot_control.ros.position.odometry import OdomAge, OdomConflict, WallClockOdomAge
from mobile_robot_control.ros.position.robot_guard import LockstepGuard, RobotGuard
from mobile_robot_control.ros.shared.localisation import LocalisationInput
from mobile_robot_control.ros.shared.modes import LockstepMode, WallClockMode
from mobile_robot_control.settings.shared import Shared


class LockstepPosition(LockstepMode):
    """There is no robot to guard."""

    def make_age(self, shared: Shared) -> OdomAge:
        """Return what measures the age of odometry."""
        return OdomAge(shared)

    def make_guard(self, node: object, law: LawRunner) -> LockstepGuard:
        """Return the guard between law and robot."""
        return LockstepGuard(node, law)

    def watch_corrections(self, _node: object, _guard: LockstepGuard) -> None:
        """Leave corrections to the cart."""


class WallClockPosition(WallClockMode):
    """A robot may be driven."""

    def make_age(self, shared: Shared) -> OdomAge:
        """Return what measures the age of odometry."""
        return WallClockOdomAge(shared)

    def make_guard(self, node: Any, law: LawRunner) -> RobotGuard:
        """Return the guard between law and robot."""
        conflict = partial(OdomConflict, node, node.watch, node.robot_clock, node.parameters.input_timeout)
        return RobotGuard(
            node, law, conflict, node.act, lambda event: node.events.publish(node.get_clock().now().nanoseconds, event),
            node.kind(COMMAND))

    def watch_corrections(self, node: Any, guard: RobotGuard) -> None:
        """Let corrections that jump stop the robot."""
        if node.shared.is_localised:
            LocalisationInput(node, node.shared, node.validator,
                              lambda _, correction: guard.note_correction(correction, node.parameters.limits))
