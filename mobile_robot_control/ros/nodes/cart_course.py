"""The course of the reference cart: its curve or its path, with changes during the run."""

import math
from typing import TYPE_CHECKING

from mobile_robot_control.configuration.nodes import ReferenceCartParameters, awaits_path, course_of, path_request
from mobile_robot_control.messages.parsing import RefusedMessageError
from mobile_robot_control.quantities import Pose, Reference
from mobile_robot_control.reference.cart import with_period
from mobile_robot_control.reference.course import Course, CurveCourse, Standing, references_along
from mobile_robot_control.reference.curve import PATH
from mobile_robot_control.reference.waypoints import Waypoints
from mobile_robot_control.stamps import NANOSECONDS

if TYPE_CHECKING:
    from mobile_robot_control.ros.services.path_planning import PathAnswer, PathQuestion

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

    def begin(self, cart: ReferenceCartParameters, pose: Pose) -> None:
        """Begin a run on the course of the parameters; a cart that awaits its path stands at the robot's pose."""
        self._cart, self._given = cart, cart.curve
        self._begin_at(Standing(pose) if awaits_path(cart) else course_of(cart), 0)
        self._leads_on = not awaits_path(cart)

    def _begin_at(self, course: Course, begins: int) -> None:
        """Start a course at a time [ns]."""
        self._course, self._begins = course, begins

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

    def question(self, message: bytes, time: int) -> 'PathQuestion':
        """Make the planning question for a message on `path` at a time along the course [ns]."""
        from mobile_robot_control.reference.planned_path import PlannedPath  # noqa: PLC0415 (needs NumPy)
        from mobile_robot_control.ros.services.path_planning import PathQuestion  # noqa: PLC0415 (needs NumPy)

        since = (time - self._begins) / NANOSECONDS
        return PathQuestion(
            message, self._cart.shared.odom_frame_id, path_request(self._cart, Waypoints((), (), ())),
            self._course.reference(since), self._course if isinstance(self._course, PlannedPath) else None, since)

    def check_takes_paths(self) -> None:
        """Raise RefusedMessageError if the cart drives a curve."""
        curve = self._given.curve
        if curve != PATH:
            raise RefusedMessageError('the cart drives a curve',
                                      f"curve is '{curve}'; set curve = '{PATH}', with limits of timing")

    def take(self, answer: 'PathAnswer', begins: int) -> None:
        """Follow an answer that is no refusal from a time along the course [ns] on."""
        self._leads_on = bool(answer.points)
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

    def lap(self) -> list[Pose]:
        """Return the poses of one lap, or of a whole path; none if the cart awaits its path."""
        period = self._course.period
        if isinstance(self._course, Standing):
            return []
        return [self._course.reference(period * n / _PATH_POINTS).pose for n in range(_PATH_POINTS + 1)]
