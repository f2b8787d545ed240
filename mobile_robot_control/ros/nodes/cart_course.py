"""The course of the reference cart: its curve, changed while it drives."""

from mobile_robot_control.configuration.nodes import ReferenceCartParameters, course_of
from mobile_robot_control.quantities import Pose, Reference
from mobile_robot_control.reference.cart import with_period
from mobile_robot_control.reference.course import CurveCourse, references_along

_PATH_POINTS = 400


class CartCourse:
    """
    Where the cart is at a time along its course.

    Parameters
    ----------
    cart : ReferenceCartParameters
        Checked.
    period : int
        Of the position loop [ns].

    """

    def __init__(self, cart: ReferenceCartParameters, period: int) -> None:
        self._horizon, self._period = cart.shared.reference_horizon, period
        self.begin(cart)

    def begin(self, cart: ReferenceCartParameters) -> None:
        """Begin a run on the course of parameters."""
        self._given, self._course = cart.curve, course_of(cart)

    def is_new(self, cart: ReferenceCartParameters) -> bool:
        """Return whether a run with parameters would leave this course."""
        return cart.curve != self._given

    def change_period(self, cart: ReferenceCartParameters, time: float) -> None:
        """Take the lap time of changed parameters, at a time along the curve [s]: the cart goes on where it is."""
        period, course = cart.curve.placement.period, self._course
        if isinstance(course, CurveCourse) and period != course.period:
            self._course = course._replace(placement=with_period(course.placement, period, time))
            self._given = self._given._replace(placement=self._given.placement._replace(period=period))

    def reference(self, time: float) -> Reference:
        """Return the reference at a time along the curve [s]."""
        return self._course.accelerated(time) if self._horizon else self._course.reference(time)

    def references(self, time: int) -> tuple[Reference, ...]:
        """Return the reference at a time along the curve [ns] and at the ticks of the horizon."""
        return references_along(self._course, self._horizon)(time, self._period)

    def lap(self) -> list[Pose]:
        """Return the poses of one lap, or of a whole path."""
        period = self._course.period
        return [self._course.reference(period * n / _PATH_POINTS).pose for n in range(_PATH_POINTS + 1)]
