"""The reference cart's course: of its parameters, of messages, and where corrections place it."""

from typing import TYPE_CHECKING

from mobile_robot_control.elementary import hypot
from mobile_robot_control.messages.parsing import RefusedMessageError
from mobile_robot_control.quantities import NANOSECONDS, Pose, Reference
from mobile_robot_control.reference.cart import with_period
from mobile_robot_control.reference.course import Course, CurveCourse, Standing, references_along
from mobile_robot_control.reference.curves import CURVES, OF_FILES, PATH
from mobile_robot_control.reference.led_course import course_at, led_over
from mobile_robot_control.reference.localisation import SAME
from mobile_robot_control.reference.path_parameters import PathRequest
from mobile_robot_control.reference.waypoints import NO_WAYPOINTS
from mobile_robot_control.settings.nodes import (
    ReferenceCartParameters,
    awaits_corrections,
    awaits_path,
    correction_schedule,
    driven_course_of,
    path_request,
    request_of,
)
from mobile_robot_control.topics import PATH_TOPIC

if TYPE_CHECKING:
    from mobile_robot_control.reference.motion import PathMotion
    from mobile_robot_control.ros.cart.path_planning import PathAnswer, PathQuestion

_PATH_POINTS = 400


class CartCourse:
    """
    The cart's pose at a time along its course.

    Parameters
    ----------
    cart : ReferenceCartParameters
        Checked.
    period : int
        Of the position loop [ns].

    Attributes
    ----------
    correction : Pose or None
        Of the frame of odometry in that of the path; None before the first.
    leads_on : bool
        Whether the cart follows what it was asked to, or has; False from a stop on.

    """

    def __init__(self, cart: ReferenceCartParameters, period: int) -> None:
        self._horizon, self._period = cart.shared.reference_horizon, period
        self.begin_course(cart, Pose(0.0, 0.0, 0.0))

    def begin_course(self, cart: ReferenceCartParameters, pose: Pose, correction: Pose | None = None) -> None:
        """
        Begin a run on the course of the parameters.

        A cart that awaits its path stands at the robot's pose, and so does one that awaits its first correction.
        """
        self._cart, self._given = cart, cart.curve
        self.correction = correction if awaits_corrections(cart) else SAME
        self._route: PathRequest | None = None
        self._begin_at(Standing(pose), 0)
        self.leads_on = not awaits_path(cart)
        if self.correction is not None:
            self.place(self.correction, 0)

    def place(self, correction: Pose, time: int) -> None:
        """Begin the course of the parameters at a time [ns], with the first correction of a run."""
        self.correction = correction
        if not awaits_path(self._cart):
            request = request_of(self._cart)
            self._route = request if isinstance(request, PathRequest) else None
            self._begin_at(driven_course_of(self._cart) if correction == SAME else course_at(
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

    def can_be_led(self, time: int) -> bool:
        """Return whether the cart is on a path at a time along the course [ns], which a correction moves."""
        return self._route is not None and bool(self._route.waypoints.points) and not self.has_ended(time)

    def question(
        self, message: bytes, time: int, correction: Pose | None = None, topic: str = PATH_TOPIC
    ) -> 'PathQuestion':
        """Make the planning question for a message of a topic, or a correction, at a time along the course [ns]."""
        from mobile_robot_control.ros.cart.path_planning import PathQuestion  # noqa: PLC0415 (needs NumPy)

        since, request = (time - self._begins) / NANOSECONDS, path_request(self._cart, NO_WAYPOINTS)
        motion, place = self._motion(since)
        if not message and self._route is not None:
            request = request._replace(waypoints=self._route.waypoints, path=self._route.path)
        return PathQuestion(
            message=message, frame=self._cart.shared.path_frame_id, request=request,
            correction=correction or self.correction or SAME, at=self._course.reference(since), course=motion,
            time=place, anew=self._cart.timing != self._timing or motion is not self._course, topic=topic)

    def _motion(self, since: float) -> 'tuple[PathMotion | None, float]':
        """Return the planned motion at a time since the start of the course, and the time along it [s]."""
        from mobile_robot_control.reference.motion import PathMotion  # noqa: PLC0415 (needs NumPy)
        from mobile_robot_control.reference.slowing import Slowed  # noqa: PLC0415 (needs NumPy)

        course = self._course
        if isinstance(course, Slowed) and since < course.period:
            return course.motion, course.place(since)
        return course if isinstance(course, PathMotion) else None, since

    def slow_down(self, time: int, rate: float) -> None:
        """Stop along the present motion, whose time runs at a rate, from a time along the course [ns] on."""
        from mobile_robot_control.reference.slowing import Slowed  # noqa: PLC0415 (needs NumPy)

        self._route, self.leads_on = None, False
        motion, place = self._motion((time - self._begins) / NANOSECONDS)
        if motion is None:
            self.stand(self.reference(time / NANOSECONDS).pose, time)
        elif motion is self._course:
            self._begin_at(Slowed(motion, place, path_request(self._cart, NO_WAYPOINTS), rate), time)

    def slows(self, time: int) -> bool:
        """Return whether the cart slows down to a stop at a time along the course [ns]."""
        motion, _ = self._motion((time - self._begins) / NANOSECONDS)
        return motion is not None and motion is not self._course

    def stand(self, pose: Pose, time: int) -> None:
        """End the course at a pose, at a time along it [ns]."""
        self._route, self.leads_on = None, False
        self._begin_at(Standing(pose), time)

    def check_takes_paths(self) -> None:
        """Raise RefusedMessageError if the cart drives a curve, or does not know where the path lies."""
        curve = self._given.curve
        if self.correction is None and not self._cart.shared.lockstep:
            raise RefusedMessageError('no correction', f'nothing leads from {self._cart.shared.path_frame_id} to '
                                      f'{self._cart.shared.odom_frame_id} yet; start the localisation')
        if correction_schedule(self._cart):
            raise RefusedMessageError('corrections are drawn', 'a path of the topic is corrected by /tf; leave '
                                      'localisation.rate out')
        if curve != PATH:
            raise RefusedMessageError('the cart drives a curve',
                                      f"curve is '{curve}'; set curve = '{PATH}', with limits of timing")

    def take_answer(self, answer: 'PathAnswer', begins: int) -> None:
        """Follow an answer from a time along the course [ns] on."""
        if answer.goes_on and answer.refusal:
            return
        self._route = answer.route
        if answer.goes_on:
            return
        if answer.correction is None:
            self.leads_on = bool(answer.points)
        else:
            self.correction = answer.correction
        self._begin_at(answer.planned or Standing(self.reference(begins / NANOSECONDS).pose), begins)

    def has_ended(self, time: int) -> bool:
        """Return whether the cart stands for good at a time along the course [ns]."""
        return self._given.curve in OF_FILES and time - self._begins >= self._course.period * NANOSECONDS

    def state(self, time: int, robot: Pose) -> str:
        """Return the cart's state in a word at a time [ns], for a pose of the robot."""
        if not self.has_ended(time):
            return 'running'
        end = self._course.reference(self._course.period).pose
        if not self.leads_on:
            return 'standing'
        near = hypot(robot.x - end.x, robot.y - end.y) <= self._cart.goal.position_tolerance
        return 'arrived' if near else 'running'

    def left(self, time: int) -> tuple[Pose | None, float]:
        """Return the end of the path, None before it is reached, and the way to it [m] at a time [ns]."""
        if self.has_ended(time):
            return self._course.reference(self._course.period).pose, 0.0
        motion, place = self._motion((time - self._begins) / NANOSECONDS)
        return None, motion.left(place) if motion else 0.0

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
