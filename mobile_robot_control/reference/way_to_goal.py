"""A way to a goal: two arcs, or a straight line with turns on the spot. It knows no obstacle."""

import math
from collections.abc import Iterator

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import atan2, dist, sin, sin_cos
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Pose, Reference
from mobile_robot_control.reference.joining import join
from mobile_robot_control.reference.led_course import waypoints_in_odometry
from mobile_robot_control.reference.localisation import composed
from mobile_robot_control.reference.motion import Part, PathMotion, Rest, turn
from mobile_robot_control.reference.path_parameters import PathRequest
from mobile_robot_control.reference.stopping import moves, stop
from mobile_robot_control.reference.waypoints import LONGEST, checked_waypoints

_SPACING = 0.05
"""[m] from a point of the arcs to the next one."""
_WIDEST = math.radians(150.0)
"""Largest turn of one arc."""
_STRAIGHT = 1e-6
_ALIGNED = 0.02
"""[rad] from the heading of the goal at the end of the arcs, whose smallest ones the tolerance of a path rounds off."""


def arcs_to(start: Pose, goal: Pose) -> list[Pose]:
    """
    Return poses along two arcs of equal tangent lengths from one pose to another, forwards; [] where there are none.

    The biarc of Bolton, "Biarc curves", Computer-Aided Design 7 (2), 1975.
    """
    vx, vy = goal.x - start.x, goal.y - start.y
    (ay, ax), (by, bx) = (sin_cos(one.heading) for one in (start, goal))
    along, unlike = vx * (ax + bx) + vy * (ay + by), 2.0 * (1.0 - ax * bx - ay * by)
    square = vx * vx + vy * vy
    if unlike > _STRAIGHT:
        tangent = (-along + math.sqrt(along * along + unlike * square)) / unlike
    elif along > _STRAIGHT:
        tangent = square / (2.0 * along)
    else:
        return []
    middle = (0.5 * (start.x + goal.x + tangent * (ax - bx)), 0.5 * (start.y + goal.y + tangent * (ay - by)))
    first = _turn(start.heading, start, middle)
    joined = Pose(*middle, wrap_angle(start.heading + first))
    second = _turn(joined.heading, joined, goal)
    if max(abs(first), abs(second)) > _WIDEST:
        return []
    return [*_arc(start, first, middle), *_arc(joined, second, (goal.x, goal.y)), goal]


def _turn(heading: float, start: Pose, end: tuple[float, float] | Pose) -> float:
    """Return the turn of the arc from a pose through a point [rad]."""
    return 2.0 * wrap_angle(atan2(end[1] - start.y, end[0] - start.x) - heading)


def _arc(start: Pose, turn: float, end: tuple[float, float]) -> Iterator[Pose]:
    """Yield poses along an arc, without its end."""
    chord = dist(start[:2], end)
    length = chord if abs(turn) < _STRAIGHT else chord * 0.5 * turn / sin(0.5 * turn)
    count = max(1, math.ceil(length / _SPACING))
    for n in range(count):
        part = turn * n / count
        way = chord * n / count if abs(turn) < _STRAIGHT else chord * sin(0.5 * part) / sin(0.5 * turn)
        sine, cosine = sin_cos(start.heading + 0.5 * part)
        yield Pose(start.x + way * cosine, start.y + way * sine, wrap_angle(start.heading + part))


def drive_to(
    goal: Pose, request: PathRequest, before: Reference, rest: Rest | None, correction: Pose, source: str
) -> tuple[PathMotion, PathRequest]:
    """
    Plan a motion to a goal with its heading; a cart that cannot go on there stops first.

    Parameters
    ----------
    goal : Pose
        In the frame of the path.
    request : PathRequest
        With the limits.
    before : Reference
        Pose and motion of the cart, in the frame of odometry.
    rest : Rest or None
        The present motion, from the cart on; None if it stands at its end.
    correction : Pose
        Of the frame of odometry in that of the path.
    source : str
        For messages.

    Returns
    -------
    tuple of PathMotion and PathRequest
        The motion, and the path of it in the frame of the path.

    Raises
    ------
    ParameterError
        If no motion keeps the limits.

    """
    way = dist(composed(correction, before.pose)[:2], goal[:2])
    if way > LONGEST:
        raise ParameterError([f'the goal lies {way:.0f} m away, and more than {LONGEST:g} m are too far'])
    parts: list[Part] = []
    if rest is not None and moves(before):
        try:
            return _from(goal, request, before, rest, correction, source)
        except ParameterError:
            stopped = stop(rest, request, before)
            before, parts = stopped.reference(stopped.period), list(stopped.parts)
    onward, route = _from(goal, request, before, None, correction, source)
    return PathMotion([*parts, *onward.parts], onward.ignored), route


def _from(
    goal: Pose, request: PathRequest, before: Reference, rest: Rest | None, correction: Pose, source: str
) -> tuple[PathMotion, PathRequest]:
    """Plan from the cart's pose: by arcs where they are feasible, else straight, with a turn to the heading there."""
    start = composed(correction, before.pose)
    if dist(start[:2], goal[:2]) < request.path.rounding and not moves(before):
        return PathMotion([turn(before.pose, wrap_angle(goal.heading - start.heading), request)]), request
    refusal = ParameterError([])
    for poses, turns in ((arcs_to(start, goal), False), ([start, goal], True)):
        rows = [(source, {'x': one.x, 'y': one.y, 'heading': one.heading}) for one in poses]
        try:
            waypoints = checked_waypoints(rows, source)
            if not turns:
                waypoints = waypoints._replace(headings=(), turns=())
            route = request._replace(
                waypoints=waypoints, path=request.path._replace(goal_heading=turns, closed=False))
            planned = join(route._replace(waypoints=waypoints_in_odometry(waypoints, correction)), before, rest, True)
        except ParameterError as error:
            refusal = error
            continue
        if planned is not None and (turns or abs(wrap_angle(
                planned.reference(planned.period).pose.heading + correction.heading - goal.heading)) < _ALIGNED):
            return planned, route
    raise refusal
