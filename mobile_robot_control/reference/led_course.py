"""A course in the frame of a localisation: corrections move it, and the cart leads over to where it lies then."""

from bisect import bisect_right
from contextlib import suppress
from functools import lru_cache
from typing import NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import atan2, hypot, sin_cos
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import (
    NANOSECONDS,
    NO_ACCELERATION,
    BodyAcceleration,
    BodyVelocity,
    Pose,
    Reference,
)
from mobile_robot_control.reference.cart import Placement
from mobile_robot_control.reference.course import Course, CurveCourse, FileRequest, make_course
from mobile_robot_control.reference.localisation import (
    SAME,
    Corrections,
    CorrectionSchedule,
    RandomCorrections,
    composed,
    inverse,
)
from mobile_robot_control.reference.path_parameters import PathRequest
from mobile_robot_control.reference.trajectory_parameters import TrajectoryRequest
from mobile_robot_control.reference.waypoints import Waypoints

_BLEND = 1.5
"""[s] in which the cart leads over to a curve that has moved."""
_DT = 1e-4
"""[s] of the difference of accelerations."""


def waypoints_in_odometry(waypoints: Waypoints, correction: Pose) -> Waypoints:
    """Return waypoints of the frame of the path in that of odometry."""
    if correction == SAME:
        return waypoints
    back = inverse(correction)
    return waypoints._replace(
        points=tuple(composed(back, Pose(x, y, 0.0))[:2] for x, y in waypoints.points),
        headings=tuple(None if one is None else wrap_angle(one + back.heading) for one in waypoints.headings))


def placement_in_odometry(placement: Placement, correction: Pose) -> Placement:
    """Return the placement of a curve in the frame of the path in that of odometry."""
    if correction == SAME:
        return placement
    at = composed(inverse(correction), Pose(placement.center[0], placement.center[1], placement.rotation))
    return placement._replace(center=(at.x, at.y), rotation=at.heading)


class Blend(NamedTuple):
    """
    A curve that has moved: the cart leads over from its former place, by a polynomial of fifth degree in time.

    Attributes
    ----------
    before : Course
        Of the cart so far.
    after : CurveCourse
        Where the curve lies now.
    begin : float
        Time along both from which on it leads over [s].

    """

    before: Course
    after: CurveCourse
    begin: float

    @property
    def period(self) -> float:
        """Time for one lap [s]."""
        return self.after.period

    @property
    def size(self) -> float:
        """The curve's scale [m]."""
        return self.after.size

    @property
    def closed(self) -> bool:
        """Whether a lap ends where it begins."""
        return self.after.closed

    def reference(self, time: float) -> Reference:
        """Return the reference at a time [s], without its acceleration."""
        share = (time - self.begin) / _BLEND
        if share <= 0.0:
            return self.before.reference(time)
        if share >= 1.0:
            return self.after.reference(time)
        # s = 10 u³ - 15 u⁴ + 6 u⁵, its rate, and the rate of that
        left = share * (1.0 - share)
        s = share * share * share * (10.0 - share * (15.0 - 6.0 * share))
        rate = 30.0 * left * left / _BLEND
        growth = 60.0 * left * (1.0 - 2.0 * share) / (_BLEND * _BLEND)
        (x, y), (vx, vy), (ax, ay) = _plane(self.before.accelerated(time))
        (xn, yn), (vxn, vyn), (axn, ayn) = _plane(self.after.accelerated(time))
        dx, dy, dvx, dvy = xn - x, yn - y, vxn - vx, vyn - vy
        vx, vy = vx + s * dvx + rate * dx, vy + s * dvy + rate * dy
        ax = ax + s * (axn - ax) + 2.0 * rate * dvx + growth * dx
        ay = ay + s * (ayn - ay) + 2.0 * rate * dvy + growth * dy
        return Reference(
            Pose(x + s * dx, y + s * dy, atan2(vy, vx)),
            BodyVelocity(hypot(vx, vy), (vx * ay - vy * ax) / (vx * vx + vy * vy)), NO_ACCELERATION)

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time [s], with its acceleration; while it leads over, by a symmetric difference."""
        if not 0.0 < time - self.begin < _BLEND:
            return (self.before if time <= self.begin else self.after).accelerated(time)
        before, after = (self.reference(time + sign * _DT).velocity for sign in (-1.0, 1.0))
        return self.reference(time)._replace(acceleration=BodyAcceleration(
            *((late - early) / (2.0 * _DT) for early, late in zip(before, after, strict=True))))


def _plane(reference: Reference) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """Return position, velocity and acceleration of the cart in the plane."""
    (x, y, heading), (v, omega), (a, _) = reference
    sin, cos = sin_cos(heading)
    return (x, y), (v * cos, v * sin), (a * cos - v * omega * sin, a * sin + v * omega * cos)


def led_over(
    course: Course, request: PathRequest | tuple[()], correction: Pose, time: float, own: Course
) -> tuple[Course, bool]:
    """
    Lead a cart over to where a correction has moved its path or its curve.

    Parameters
    ----------
    course : Course
        Of the cart so far, which has not ended.
    request : PathRequest or tuple
        The path, in its own frame; () for a curve.
    correction : Pose
        Of the frame of odometry in the frame of the path.
    time : float
        Along the course [s].
    own : Course
        The curve, in its own frame.

    Returns
    -------
    tuple of Course and bool
        The next course, and whether its time begins now.

    Raises
    ------
    ParameterError
        If no motion keeps the limits.

    """
    if isinstance(own, CurveCourse):
        moved = own._replace(placement=placement_in_odometry(own.placement, correction))
        if isinstance(course, Blend) and time - course.begin >= _BLEND:
            course = course.after
        return Blend(course, moved, time), False
    from mobile_robot_control.reference.joining import lead_over  # noqa: PLC0415 (nodes without a path need no NumPy)
    from mobile_robot_control.reference.motion import PathMotion  # noqa: PLC0415 (as above)

    assert request  # noqa: S101 (for mypy: a path where there is no curve)
    assert isinstance(course, PathMotion)  # noqa: S101 (for mypy: of a path)
    route = request._replace(waypoints=waypoints_in_odometry(request.waypoints, correction))
    return lead_over(route, course.accelerated(time), course.rest(time)), True


def course_at(curve: str, placement: Placement, path: FileRequest | tuple[()], correction: Pose) -> Course:
    """Return the course of `make_course` where a correction has placed it, in the frame of odometry."""
    assert not isinstance(path, TrajectoryRequest)  # noqa: S101 (for mypy: a trajectory is in the frame of odometry)
    moved = path and path._replace(waypoints=waypoints_in_odometry(path.waypoints, correction))
    return make_course(curve, placement_in_odometry(placement, correction), moved)


def driven_course(
    curve: str, placement: Placement, path: FileRequest | tuple[()], schedule: CorrectionSchedule | tuple[()]
) -> Course:
    """Return the course of `make_course`, led by the drawn corrections, if there are any."""
    return _led(curve, placement, path, schedule) if schedule else make_course(curve, placement, path)


@lru_cache(maxsize=32)
def _led(curve: str, placement: Placement, path: FileRequest | tuple[()], schedule: CorrectionSchedule) -> Course:
    # one for all trials that have it, since it plans as it goes
    return LedCourse(make_course(curve, placement, path), path, schedule)


class LedCourse:
    """
    The course of a simulated run with drawn corrections, as the nodes drive it in lockstep.

    Parameters
    ----------
    course : Course
        Without corrections.
    request : PathRequest or tuple
        Its path; () for a curve.
    schedule : CorrectionSchedule
        Of the corrections.

    """

    def __init__(self, course: Course, request: FileRequest | tuple[()], schedule: CorrectionSchedule) -> None:
        self._given, self._request = course, request
        self.period, self.size, self.closed = course.period, course.size, course.closed
        self._drawn, self._corrections = RandomCorrections(schedule.localisation), Corrections()
        self._corrections.used = SAME
        self._tick, self._ahead, self._next = schedule.tick, schedule.tick * schedule.horizon, 0
        # from each time on [ns]: a course, and the time of its own start [ns]
        self._times, self._courses = [0], [(course, 0)]

    def _advance(self, until: int) -> None:
        """Decide at all ticks up to a time [ns]."""
        while self._next <= until:
            now, self._next = self._next, self._next + self._tick
            course, begins = self._courses[-1]
            then = now + self._ahead
            time = (then - begins) / NANOSECONDS
            at = course.reference(time).pose
            for stamp, drawn in self._drawn.until(now, at):
                self._corrections.note_correction(stamp, drawn, at)
            correction = self._corrections.due(now, at)
            if correction is None or (self._request and time >= course.period):
                continue
            with suppress(ParameterError):
                assert not isinstance(self._request, TrajectoryRequest)  # noqa: S101 (as above)
                following, is_new = led_over(course, self._request, correction, time, self._given)
                self._corrections.used = correction
                self._times.append(then)
                self._courses.append((following, then if is_new else begins))

    def _at(self, time: float) -> tuple[Course, float]:
        """Return the course at a time [s], and the time along it [s]."""
        now = max(0, round(time * NANOSECONDS))
        self._advance(now - self._ahead)
        course, begins = self._courses[bisect_right(self._times, now) - 1]
        return course, time - begins / NANOSECONDS

    def reference(self, time: float) -> Reference:
        """Return the reference at a time [s], without its acceleration."""
        course, time = self._at(time)
        return course.reference(time)

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time [s], with its acceleration."""
        course, time = self._at(time)
        return course.accelerated(time)
