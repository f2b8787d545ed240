"""The reference cart's course, and its time along it: by stamps in lockstep; on the wall clock it may wait."""

import math
from collections.abc import Callable
from itertools import accumulate
from typing import TYPE_CHECKING, Protocol

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from mobile_robot_control.messages.parsing import RefusedMessageError
from mobile_robot_control.quantities import NANOSECONDS, Pose, Reference
from mobile_robot_control.reference.cart import with_period
from mobile_robot_control.reference.course import Course, CurveCourse, Standing, references_along
from mobile_robot_control.reference.curves import CURVES, PATH
from mobile_robot_control.reference.led_course import course_at, led_over
from mobile_robot_control.reference.localisation import SAME
from mobile_robot_control.reference.waiting import (
    NEAR,
    WaitingCart,
    after_a_pause,
    apart,
    begin_waiting,
    later,
    move_cart,
    slowed,
)
from mobile_robot_control.reference.waypoints import NO_WAYPOINTS
from mobile_robot_control.ros.clock import SteadyClock
from mobile_robot_control.ros.diagnostics import Condition
from mobile_robot_control.ros.inputs import InputMonitor
from mobile_robot_control.settings.nodes import (
    ReferenceCartParameters,
    awaits_path,
    course_driven,
    drawing_of,
    path_of,
    path_request,
)

if TYPE_CHECKING:
    from mobile_robot_control.ros.path_planning import PathAnswer, PathQuestion

PERIOD = 'period'
"""The parameter that changes without a jump of the cart."""
References = tuple[Reference, ...]


_PATH_POINTS = 400
_ARRIVED = 0.1
"""[m] from the end of its path: at a smaller distance the robot has arrived."""


class CartCourse:
    """
    The cart's pose at a time along its course.

    Parameters
    ----------
    cart : ReferenceCartParameters
        Checked.
    period : int
        Of the position loop [ns].

    """

    def __init__(self, cart: ReferenceCartParameters, period: int) -> None:
        self._horizon, self._period = cart.shared.reference_horizon, period
        self.begin(cart, Pose(0.0, 0.0, 0.0))

    def begin(self, cart: ReferenceCartParameters, pose: Pose, correction: Pose | None = None) -> None:
        """
        Begin a run on the course of the parameters.

        A cart that awaits its path stands at the robot's pose, and so does one that awaits its first correction.
        """
        self._cart, self._given = cart, cart.curve
        self.correction = SAME if not self.awaits_corrections else correction
        self._waypoints = NO_WAYPOINTS
        self._begin_at(Standing(pose), 0)
        self._leads_on = not awaits_path(cart)
        if self.correction is not None:
            self.place(self.correction, 0)

    @property
    def awaits_corrections(self) -> bool:
        """Whether a localisation corrects the course: none that is drawn."""
        return self._cart.shared.is_localised and not drawing_of(self._cart)

    def place(self, correction: Pose, time: int) -> None:
        """Begin the course of the parameters at a time [ns], with the first correction of a run."""
        self.correction = correction
        if not awaits_path(self._cart):
            self._waypoints = request.waypoints if (request := path_of(self._cart)) else NO_WAYPOINTS
            self._begin_at(course_driven(self._cart) if correction == SAME else course_at(
                self._given.curve, self._given.placement, request, correction), time)

    def _begin_at(self, course: Course, begins: int) -> None:
        """Start a course at a time [ns]."""
        self._course, self._begins, self._timing = course, begins, self._cart.timing

    def is_new(self, cart: ReferenceCartParameters) -> bool:
        """Return whether a run with these parameters would leave this course."""
        return cart.curve != self._given or self._begins > 0

    def change(self, cart: ReferenceCartParameters, time: float) -> None:
        """
        Apply changed parameters without moving the cart, at a time along the curve [s].

        With another lap time the cart continues from its place; other limits apply to the next path.
        """
        self._cart = cart
        period, course = cart.curve.placement.period, self._course
        if isinstance(course, CurveCourse) and period != course.period:
            self._course = course._replace(placement=with_period(course.placement, period, time))
            self._given = self._given._replace(placement=self._given.placement._replace(period=period))

    def lead_over(self, correction: Pose, time: int) -> None:
        """Lead over to a curve that a correction has moved, from a time along the course [ns] on."""
        given = CurveCourse(CURVES[self._given.curve], self._cart.curve.placement)
        self._course, _ = led_over(self._course, (), correction, (time - self._begins) / NANOSECONDS, given)
        self.correction = correction

    def question(self, message: bytes, time: int, correction: Pose | None = None) -> 'PathQuestion':
        """Make the planning question for a message on `path`, or a correction, at a time along the course [ns]."""
        from mobile_robot_control.reference.motion import Motion  # noqa: PLC0415 (needs NumPy)
        from mobile_robot_control.ros.path_planning import PathQuestion  # noqa: PLC0415 (needs NumPy)

        since = (time - self._begins) / NANOSECONDS
        return PathQuestion(
            message, self._cart.shared.path_frame_id, path_request(self._cart, self._waypoints),
            correction or self.correction or SAME, self._course.reference(since),
            self._course if isinstance(self._course, Motion) else None, since, self._cart.timing != self._timing)

    def check_takes_paths(self) -> None:
        """Raise RefusedMessageError if the cart drives a curve, or does not know where the path lies."""
        curve = self._given.curve
        if self.correction is None:
            raise RefusedMessageError('no correction', f'nothing leads from {self._cart.shared.path_frame_id} to '
                                      f'{self._cart.shared.odom_frame_id} yet; start the localisation')
        if drawing_of(self._cart):
            raise RefusedMessageError('corrections are drawn', 'a path of the topic is corrected by /tf; leave '
                                      'localisation.rate out')
        if curve != PATH:
            raise RefusedMessageError('the cart drives a curve',
                                      f"curve is '{curve}'; set curve = '{PATH}', with limits of timing")

    def take(self, answer: 'PathAnswer', begins: int) -> None:
        """Follow an answer from a time along the course [ns] on."""
        self._waypoints = answer.waypoints or NO_WAYPOINTS
        if answer.goes_on:
            return
        if answer.correction is None:
            self._leads_on = bool(answer.points)
        else:
            self.correction = answer.correction
        self._begin_at(answer.planned or Standing(self.reference(begins / NANOSECONDS).pose), begins)

    def has_ended(self, time: int) -> bool:
        """Return whether the cart stands for good at a time along the course [ns]."""
        return self._given.curve == PATH and time - self._begins >= self._course.period * NANOSECONDS

    def state(self, time: int, robot: Pose) -> str:
        """Return the cart's state in a word at a time [ns], for a pose of the robot."""
        if not self.has_ended(time):
            return 'running'
        end = self._course.reference(self._course.period).pose
        if not self._leads_on:
            return 'standing'
        return 'arrived' if math.hypot(robot.x - end.x, robot.y - end.y) <= _ARRIVED else 'running'

    def reference(self, time: float) -> Reference:
        """Return the reference at a time along the course [s]."""
        time -= self._begins / NANOSECONDS
        return self._course.accelerated(time) if self._horizon else self._course.reference(time)

    def references(self, time: int) -> tuple[Reference, ...]:
        """Return the reference at a time along the course [ns] and at the ticks of the horizon."""
        return references_along(self._course, self._horizon)(time - self._begins, self._period)

    @property
    def ignored(self) -> tuple[str, ...]:
        """Headings of the path that are not used, in words."""
        return getattr(self._course, 'ignored', ())

    def lap(self) -> list[Pose]:
        """Return the poses of one lap, or of a whole path; none if the cart awaits its path."""
        period = self._course.period
        if isinstance(self._course, Standing):
            return []
        return [self._course.reference(period * n / _PATH_POINTS).pose for n in range(_PATH_POINTS + 1)]


class CartTime(Protocol):
    """The cart's time along its course."""

    def now(self) -> float:
        """Return the time along the curve [s]."""

    def references(self, stamp: int) -> References:
        """Return the references of a step at a stamp [ns]."""

    def may_jump(self) -> bool:
        """Return whether the cart may switch to another curve."""

    def note(self, pose: Pose) -> None:
        """Receive the robot's pose."""

    def begin_anew(self) -> None:
        """Start again at the start of another curve."""

    def forget(self) -> None:
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

    def note(self, pose: Pose) -> None:
        """Leave the time as it is."""

    def begin_anew(self) -> None:
        """Leave the time as it is."""

    def forget(self) -> None:
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

    def note(self, _pose: Pose) -> None:
        """Start with the first odometry."""
        if self._began is None:
            self._began = self._clock()

    def begin_anew(self) -> None:
        """Leave the time as it is: the cart stands at its start."""

    def forget(self) -> None:
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

    def begin_anew(self) -> None:
        """Place the cart at the start of another curve, where it waits for the robot."""
        self._at = self._reference_at(0.0).pose
        if self._cart is not None:
            self._cart = begin_waiting(self._clock(), self._pose)
            self._log_wait(self._cart)

    def _log_wait(self, cart: WaitingCart) -> None:
        self._node.get_logger().warning(f'the cart waits: {self._words(cart)}')

    def note(self, pose: Pose) -> None:
        """Receive the robot's pose; the first one places the cart at its start."""
        self._pose = pose
        if self._cart is None:
            self._cart = begin_waiting(self._clock(), pose)

    def may_jump(self) -> bool:
        """Return True: the cart waits at the start of another curve."""
        return True

    def forget(self) -> None:
        """Wait at the start for the robot of another run."""
        self.begin_anew()

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
        return Condition(DiagnosticStatus.WARN, 'waiting', self._monitor.missing(), self._words(self._cart))

    def _words(self, cart: WaitingCart) -> str:
        """Describe why the cart waits, and what ends the wait."""
        return (f'{cart.why}: {apart(self._pose, self._at):.2f} m lie between robot and cart, which goes on within '
                f'{NEAR} m')
