"""The two modes of the cart: everything by stamps, or by the wall clock, where it may wait for a robot."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from collections.abc import Mapping
from typing import Any

from std_msgs.msg import String

from mobile_robot_control.reference.waiting import SILENT
from mobile_robot_control.ros.cart.cart_paths import LockstepPaths, WallClockPaths
from mobile_robot_control.ros.cart.cart_time import PERIOD, CartTime, CartWait, LockstepTime, WallClockTime
from mobile_robot_control.ros.cart.follow_path import LOOK
from mobile_robot_control.ros.shared.modes import LockstepMode, WallClockMode
from mobile_robot_control.ros.shared.qos import LATCHED
from mobile_robot_control.ros.shared.timers import create_steady_timer
from mobile_robot_control.topics import STOPPED


class LockstepCart(LockstepMode):
    """The cart answers every odometry, and paths and corrections act at their stamps."""

    forgets_corrections = True

    def make_time(self, cart: Any) -> CartTime:
        """Return the time along the course."""
        return LockstepTime(cart.course, cart.reached)

    def make_planning(self, cart: Any) -> LockstepPaths:
        """Return what plans paths."""
        return LockstepPaths(cart.course, cart.position_period, cart.reached)

    def listen(self, cart: object) -> None:
        """Listen to nothing else: there is no robot to stop."""

    def clock(self, stamp: int) -> int:
        """Return the time of a message or a step with a stamp [ns]."""
        return stamp

    def waits_for_a_run(self, changed: Mapping[str, object]) -> bool:
        """Return whether changed parameters act from the next run on."""
        return set(changed) != {PERIOD}

    def end_stop(self, _cart: object) -> None:
        """Leave a stop to its course, whose time goes on."""

    def is_deaf(self, _cart: object) -> bool:
        """Return whether odometry is silent: a step answers one."""
        return False


class WallClockCart(WallClockMode):
    """The cart drives with the clock, stands where the robot is stopped, and plans beside its steps."""

    forgets_corrections = False

    def make_time(self, cart: Any) -> CartTime:
        """Return the time along the course."""
        waiting, shared = cart.parameters.waiting, cart.shared
        if waiting.wait:
            return CartWait(
                cart, cart.robot_clock, cart.monitor, waiting.wait_distance, 1.0 / shared.position_rate,
                cart.course.reference, shared.reference_horizon, lambda: cart.corrections.missing_correction())  # noqa: PLW0108 (made later)
        return WallClockTime(cart.course, cart.robot_clock.now)

    def make_planning(self, cart: Any) -> WallClockPaths:
        """Return what plans paths."""
        return WallClockPaths(
            cart.course, cart.time, cart, cart.validator, lambda: cart.parameters.path.planning_time)

    def listen(self, cart: Any) -> None:
        """Listen to stops of the robot; look after goals also while no odometry comes."""
        cart.create_subscription(String, STOPPED, cart.robot.note_stop, LATCHED)
        if cart.goals.are_served:
            create_steady_timer(LOOK, lambda: cart.goals.step(0), cart)

    def clock(self, _stamp: int) -> int:
        """Return the time of a message or a step, its receipt [ns]."""
        return time.monotonic_ns()

    def waits_for_a_run(self, _changed: Mapping[str, object]) -> bool:
        """Return whether changed parameters act from the next run on."""
        return False

    def end_stop(self, cart: Any) -> None:
        """End the stop of a waiting cart, whose time along the course stands still."""
        if not any(cart.reference.velocity) and cart.course.slows(cart.now):
            cart.course.stand(cart.reference.pose, cart.now)

    def is_deaf(self, cart: Any) -> bool:
        """
        Return whether odometry is silent.

        A controller that hears the robot earlier would set out for a cart that has not seen it jump.
        """
        return bool(cart.monitor.age('odom') > SILENT)
