"""The time of the reference cart along its course: by stamps in lockstep; on the wall clock it may wait."""

from collections.abc import Callable
from itertools import accumulate
from typing import Protocol

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from mobile_robot_control.quantities import Pose, Reference
from mobile_robot_control.reference.waiting import (
    ALIGNED,
    NEAR,
    WaitingCart,
    after_a_pause,
    apart,
    begin_waiting,
    later,
    move_cart,
    slowed,
    turned,
)
from mobile_robot_control.ros.cart.cart_course import CartCourse
from mobile_robot_control.ros.shared.clock import SteadyClock
from mobile_robot_control.ros.shared.diagnostics import Condition
from mobile_robot_control.ros.shared.inputs import InputMonitor

PERIOD = 'period'
"""The parameter that changes without a jump of the cart."""
References = tuple[Reference, ...]


class CartTime(Protocol):
    """The cart's time along its course."""

    def now(self) -> float:
        """Return the time along the curve [s]."""

    def references(self, stamp: int) -> References:
        """Return the references of a step at a stamp [ns]."""

    def may_jump(self) -> bool:
        """Return whether the cart may switch to another curve."""

    def note_pose(self, pose: Pose) -> None:
        """Receive the robot's pose."""

    def take_rate(self) -> float:
        """Return the rate of the time along the course, which is 1 from now on: the course slows down itself."""

    def begin_curve(self) -> None:
        """Start again at the start of another curve."""

    def forget_run(self) -> None:
        """Start again with the next odometry."""

    def condition(self) -> Condition | None:
        """Return the report of a waiting cart."""


class LockstepTime:
    """
    The time is that of the stamps, whatever else happens.

    Parameters
    ----------
    course : CartCourse
        Of the cart.
    accepted : callable
        Returns the stamp of the last step [ns], None before the first.

    """

    def __init__(self, course: CartCourse, accepted: Callable[[], int | None]) -> None:
        self._course, self._accepted = course, accepted

    def now(self) -> float:
        """Return the time along the curve [s]."""
        return (self._accepted() or 0) / 1e9

    def references(self, stamp: int) -> References:
        """Return the references of a step at a stamp [ns]."""
        return self._course.references(stamp)

    def may_jump(self) -> bool:
        """Return True: a new run begins on another curve."""
        return True

    def note_pose(self, pose: Pose) -> None:
        """Leave the time as it is."""

    def take_rate(self) -> float:
        """Return 1."""
        return 1.0

    def begin_curve(self) -> None:
        """Leave the time as it is."""

    def forget_run(self) -> None:
        """Leave the time as it is."""

    def condition(self) -> None:
        """Return None: the cart never waits."""


class WallClockTime:
    """
    The time is that of the clock, from the first odometry on.

    Parameters
    ----------
    course : CartCourse
        Of the cart.
    clock : callable
        Returns the robot's time [s].

    """

    def __init__(self, course: CartCourse, clock: Callable[[], float]) -> None:
        self._course, self._clock = course, clock
        self._began: float | None = None

    def now(self) -> float:
        """Return the time along the curve [s]."""
        return 0.0 if self._began is None else self._clock() - self._began

    def references(self, _stamp: int) -> References:
        """Return the references of now."""
        return self._course.references(round(self.now() * 1e9))

    def may_jump(self) -> bool:
        """Return whether the cart still stands at its start."""
        return self._began is None

    def note_pose(self, _pose: Pose) -> None:
        """Start with the first odometry."""
        if self._began is None:
            self._began = self._clock()

    def take_rate(self) -> float:
        """Return 1."""
        return 1.0

    def begin_curve(self) -> None:
        """Leave the time as it is: the cart stands at its start."""

    def forget_run(self) -> None:
        """Start again with the next odometry."""
        self._began = None

    def condition(self) -> None:
        """Return None: the cart never waits."""


_HELD_UP = 0.5
"""[s], and at least three periods, between two steps: the node was delayed, and the cart has stood meanwhile."""


class CartWait:
    """
    Moves the cart by the robot's time while the robot follows.

    Parameters
    ----------
    node : Node
        For the log.
    clock : SteadyClock
        Of the node.
    monitor : InputMonitor
        Provides the age of odometry.
    wait_distance : float
        [m].
    period : float
        Of the cart's steps [s].
    reference_at : callable
        Returns the reference at a time along the curve [s].
    horizon : int
        Number of steps ahead with a reference.
    hold : callable
        Returns another reason to wait; '' for none.

    """

    def __init__(
        self, node: Node, clock: SteadyClock, monitor: InputMonitor, wait_distance: float, period: float,
        reference_at: Callable[[float], Reference], horizon: int = 0, hold: Callable[[], str] = lambda: '',
    ) -> None:
        self._node, self._clock, self._monitor = node, clock.now, monitor
        self._longest = max(_HELD_UP, 3.0 * period)
        self._period, self._horizon, self._hold = period, horizon, hold
        self._wait_distance, self._reference_at = wait_distance, reference_at
        self._cart: WaitingCart | None = None
        self._pose = self._at = reference_at(0.0).pose

    def now(self) -> float:
        """Return the time along the curve [s]."""
        return 0.0 if self._cart is None else self._cart.time

    def take_rate(self) -> float:
        """Return the rate of a cart that waits, or continues after it; from now on it is 1."""
        if self._cart is None:
            return 0.0
        rate, self._cart = self._cart.rate, self._cart._replace(rate=1.0)
        return rate

    def begin_curve(self) -> None:
        """Place the cart at the start of another curve, where it waits for the robot."""
        self._at = self._reference_at(0.0).pose
        if self._cart is not None:
            self._cart = begin_waiting(self._clock(), self._pose)
            self._log_wait(self._cart)

    def _log_wait(self, cart: WaitingCart) -> None:
        self._node.get_logger().warning(f'the cart waits: {self._words(cart)}')

    def note_pose(self, pose: Pose) -> None:
        """Receive the robot's pose; the first one places the cart at its start."""
        self._pose = pose
        if self._cart is None:
            self._cart = begin_waiting(self._clock(), pose)

    def may_jump(self) -> bool:
        """Return True: the cart waits at the start of another curve."""
        return True

    def forget_run(self) -> None:
        """Wait at the start for the robot of another run."""
        self.begin_curve()

    def references(self, _stamp: int = 0) -> tuple[Reference, ...]:
        """Return the present reference, and those of the steps ahead."""
        now = self._clock()
        before = self._cart or begin_waiting(now, self._pose)
        if now - before.now > self._longest:
            before = after_a_pause(before, now)
        self._cart = move_cart(before, now, self._monitor.age('odom'), self._pose, self._at, self._wait_distance,
                               self._hold())
        if self._cart.why and not before.why:
            self._log_wait(self._cart)
        elif before.why and not self._cart.why:
            self._node.get_logger().info('the cart drives')
        carts = accumulate(range(self._horizon), lambda cart, _: later(cart, self._period), initial=self._cart)
        references = tuple(slowed(self._reference_at(cart.time), cart.rate, bool(cart.why)) for cart in carts)
        self._at = references[0].pose
        return references

    def condition(self) -> Condition | None:
        """Return the report of a waiting cart; None while it drives."""
        if self._cart is None or not self._cart.why:
            return None
        return Condition(DiagnosticStatus.WARN, 'waiting', self._monitor.missing_inputs(), self._words(self._cart))

    def _words(self, cart: WaitingCart) -> str:
        """Describe why the cart waits, and what ends the wait."""
        robot, at = self._pose, self._at
        return (f'{cart.why}: {apart(robot, at):.2f} m and {turned(robot, at):.2f} rad lie between robot and cart, '
                f'which goes on within {NEAR} m and {ALIGNED} rad')
