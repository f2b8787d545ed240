"""
A new path in mid-run, joined to the previous motion without a jump of position, heading, speed or angular speed.

The joint is a span of the B-spline. Its first three control points give it position, heading and curvature of the
reference; it leads to the new path some way ahead.
"""

import math
from collections.abc import Sequence
from itertools import pairwise, product
from typing import NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import atan2, dist, sin_cos
from mobile_robot_control.model.kinematics import turned_round
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference
from mobile_robot_control.reference.motion import Part, PathMotion, Rest, Turn, parts_of, turn
from mobile_robot_control.reference.path_parameters import PathRequest, can_turn
from mobile_robot_control.reference.path_shape import Point, Span, bend, spline
from mobile_robot_control.reference.planned_path import PlannedPath, timed
from mobile_robot_control.reference.polyline import Follower, nearest, point_after
from mobile_robot_control.reference.stopping import SLACK, moves, slackened, stop
from mobile_robot_control.reference.stretches import Route, Stretch, polyline, route_of
from mobile_robot_control.reference.ways import Way, way_of

_LENGTHS = (1.0, 2.0)
"""Lengths of the joint, in units of path.join_distance; the first feasible one is used."""
_LED = (0.5, *_LENGTHS)
"""Those of a cart whose path a correction moves, by less than a new path may lie aside."""
_BEHIND = 0.25
"""[m] behind the cart from which on its place on a path that has moved is sought."""
_FROM_REST = (0.3, 0.6, *_LENGTHS)
"""Those of a cart that stands, which may bend more."""
_STEP = 0.05
"""[m] from a point of the present path to the next one that is compared with a new path."""
_SAME_WAY = 1.02
"""Distance from a new path up to which the present one counts as the same, in tolerances: corners use up one."""
_SAME_END = 1e-3
"""[m]: two paths with a smaller distance of their ends end together."""
_SAME_HEADING = 0.02
"""[rad]: two final headings with a smaller difference are the same."""
_ASIDE = math.radians(60.0)
"""A path that leads farther aside of a standing cart's heading begins with a turn on the spot."""
_LOOK_AHEAD = 0.3
"""[m] along a path to the point in whose direction it leads."""


class _Start(NamedTuple):
    """
    The place on a new path nearest to the cart.

    Attributes
    ----------
    number : int
        Of the stretch.
    length : float
        Along the stretch [m].
    away : float
        Distance from the cart [m].

    """

    number: int
    length: float
    away: float


def _start(route: Route, ways: Sequence[Way], before: Reference, request: PathRequest) -> _Start:
    """Return where a route begins for a cart, on its first part; raise ParameterError if that is too far away."""
    at, most, near = before.pose[:2], request.path.join_distance, _SAME_WAY * request.path.rounding
    left = dist(ways[0].points[0], at) + most
    backward = math.copysign(1.0, before.velocity.linear) < 0.0
    starts = []
    for number, way in enumerate(ways):
        starts.append(_Start(number, *nearest(way.points, at, left - dist(way.points[0], at))))
        left -= way.length
        if left <= 0.0:
            break
    # of two stretches beside a cusp, that in the cart's direction
    best = min(starts, key=lambda one: (
        (0.0, route.stretches[one.number].backward != backward) if one.away <= near else (one.away, False)))
    if best.away > most:
        raise ParameterError([
            f'the path begins {best.away:.3g} m from the cart, and path.join_distance is {most:g} m; begin it near the '
            f'cart, at ({at[0]:.3g}, {at[1]:.3g}), or raise that'])
    return best


def join(request: PathRequest, before: Reference, rest: Rest | None = None, anew: bool = False) -> PathMotion | None:
    """
    Plan a motion that continues a reference.

    Parameters
    ----------
    request : PathRequest
        The path; a closed one is driven from its first waypoint.
    before : Reference
        Pose and motion of the cart.
    rest : Rest or None
        The present motion, from the cart on; None if it stands at its end. The new motion leaves it where the new path
        does; in a turn and backwards it stops first.
    anew : bool
        Whether the present motion keeps other limits than those of the request.

    Returns
    -------
    PathMotion or None
        None if the path leads where the present one does, or ends where the cart stands: the cart goes on. Not with
        `anew`.

    Raises
    ------
    ParameterError
        If the path begins too far away, has a cusp, or no motion along it keeps the limits.

    """
    route = _route(request, before, rest)
    ways = [way_of(stretch) for stretch in route.stretches]
    start = _start(route, ways, before, request)
    if rest is None and _ends_at(ways, before.pose) and _turns_to(route, before.pose.heading):
        return None
    if rest is not None and not anew and _is_same(rest, route, ways, before, request):
        return None
    if not moves(before):
        return PathMotion(_from_rest(route, ways, start, before, request), route.ignored)
    assert rest is not None  # noqa: S101 (for mypy: a cart that stands at its end does not move)
    present = rest.parts[0]
    if isinstance(present, PlannedPath) and not (present.backward or route.stretches[start.number].backward):
        joined = _joined(ways[start.number], start, before, present.remaining(rest.time), request,
                         route.stretches[start.number])
        return PathMotion(_continued(joined, route, start.number), route.ignored)
    stopped = stop(rest, request, before)
    stands = stopped.reference(stopped.period)
    start = _start(route, ways, stands, request)
    return PathMotion([*stopped.parts, *_from_rest(route, ways, start, stands, request)], route.ignored)


def lead_over(request: PathRequest, before: Reference, rest: Rest) -> PathMotion:
    """
    Plan the rest of a motion again, along a route that a correction has moved.

    Parameters
    ----------
    request : PathRequest
        The route, where it lies now.
    before : Reference
        Pose and motion of the cart.
    rest : Rest
        The present motion, from the cart on; in a turn and backwards the cart stops first.

    Raises
    ------
    ParameterError
        If no motion along it keeps the limits.

    """
    route = _route(request, before, rest)
    ways = [way_of(stretch) for stretch in route.stretches]
    paths = [part for part in rest.parts if isinstance(part, PlannedPath)]
    number, present = len(ways) - max(1, len(paths)), rest.parts[0]
    length = ways[number].length
    if present in paths:
        length -= math.fsum(dist(*two) for two in pairwise(polyline(present.remaining(rest.time)))) + _BEHIND
    elif paths:
        length = 0.0

    def start(at: Pose) -> _Start:
        follower = Follower(ways[number].points, max(0.0, length))
        return _Start(number, *reversed((follower.distance(at[:2]), follower.length)))

    stretch, parts = route.stretches[number], []
    if moves(before):
        if present in paths and not stretch.backward:
            joined = _joined(ways[number], start(before.pose), before, (), request, stretch, _LED)
            return PathMotion(_continued(joined, route, number), route.ignored)
        stopped = stop(rest, request, before)
        before, parts = stopped.reference(stopped.period), list(stopped.parts)
    if not paths:
        # on the spot at the end
        return PathMotion(parts + parts_of(route, len(ways), before.pose.heading), route.ignored)
    return PathMotion([*parts, *_from_rest(route, ways, start(before.pose), before, request)], route.ignored)


def _route(request: PathRequest, before: Reference, rest: Rest | None) -> Route:
    """Return the stretches of a path for a cart; one in a turn has the heading to which it turns."""
    if rest is None:
        return route_of(request, before.pose.heading)
    present = rest.parts[0]
    facing = present.reference(present.period) if isinstance(present, Turn) else before
    return route_of(request, facing.pose.heading, drives=True)


def _ends_at(ways: Sequence[Way], pose: Pose) -> bool:
    """Return whether a route ends at a pose, and is no lap from there to there."""
    first, last = ways[0].points[0], ways[-1].points[-1]
    return dist(last, pose[:2]) < _SAME_END and (
        dist(first, pose[:2]) >= _SAME_END or (len(ways) == 1 and ways[0].length < _STEP))


def _turns_to(route: Route, heading: float) -> bool:
    """Return whether a route ends with a heading [rad], or with any."""
    return route.heading is None or abs(wrap_angle(route.heading - heading)) < _SAME_HEADING


def _is_same(
    rest: Rest, route: Route, ways: Sequence[Way], before: Reference, request: PathRequest
) -> bool:
    """Return whether a route leads where the rest of the present motion does."""
    near, last = _SAME_WAY * request.path.rounding, rest.parts[-1]
    if not _turns_to(route, last.reference(last.period).pose.heading) or (
            isinstance(last, Turn) and route.heading is None):
        return False
    paths = [part for part in rest.parts if isinstance(part, PlannedPath)]
    if len(paths) > len(ways):
        return False
    if not paths:
        return dist(before.pose[:2], ways[-1].points[-1]) < near
    spans = [path.remaining(rest.time) if path is rest.parts[0] else path.remaining(0.0) for path in paths]
    begin = nearest(ways[-len(paths)].points, before.pose[:2], request.path.join_distance)[0]
    return dist(paths[-1].reference(paths[-1].period).pose[:2], ways[-1].points[-1]) < _SAME_END and all(
        path.backward == stretch.backward and all(one.away <= near for one in _beside(ahead, way, start))
        for path, ahead, stretch, way, start in zip(
            paths, spans, route.stretches[-len(paths):], ways[-len(paths):], [begin] + [0.0] * (len(paths) - 1),
            strict=True))


def _continued(joined: PlannedPath, route: Route, number: int) -> list[Part]:
    """Return the parts after a joint to a stretch."""
    heading = joined.reference(joined.period).pose.heading
    return [joined, *parts_of(route, number + 1, heading)]


def _from_rest(
    route: Route, ways: Sequence[Way], start: _Start, before: Reference, request: PathRequest
) -> list[Part]:
    """Return the parts from a cart at rest on; where the path leads far aside, it turns on the spot first."""
    stretch, way = route.stretches[start.number], ways[start.number]
    seen = turned_round(before) if stretch.backward else before
    (x, y), (ahead, left) = (point_after(way.points, start.length + more)[0] for more in (0.0, _LOOK_AHEAD))
    angle = wrap_angle(atan2(left - y, ahead - x) - seen.pose.heading) if (x, y) != (ahead, left) else 0.0
    able = can_turn(request.timing, request.drive.stall_torque)
    refusal = ParameterError([])
    for turns in (False, True):
        if (turns and not able) or (not turns and able and abs(angle) > _ASIDE):
            continue
        parts: list[Part] = []
        pose = seen.pose
        if turns:
            parts.append(turn(before.pose, angle, request))
            pose = pose._replace(heading=wrap_angle(pose.heading + angle))
        try:
            return parts + _continued(_joined(
                way, start, Reference(pose, BodyVelocity(0.0, 0.0)), (), request, stretch), route, start.number)
        except ParameterError as error:
            refusal = refusal if refusal.violations else error
    raise refusal


def _joined(
    way: Way, start: _Start, before: Reference, ahead: Sequence[Span], request: PathRequest, stretch: Stretch,
    lengths: Sequence[float] = _LENGTHS,
) -> PlannedPath:
    """Return the motion along a stretch, from a cart on whose present path the spans lie ahead."""
    most, near = request.path.join_distance, _SAME_WAY * request.path.rounding
    beside = _beside(ahead, way, start.length)
    parting = next((one.travelled - near - _STEP for one in beside if one.away > near), None)
    curvature = before.velocity.angular / before.velocity.linear if before.velocity.linear else 0.0
    places = [_Departure([], [], before.pose, curvature, start.length)]
    leaves = (beside[-1].travelled if beside else 0.0) if parting is None else parting
    if leaves > most:
        places.append(_place(ahead, beside, leaves - most))
    refusal = ParameterError([])
    # as late as the limits allow
    for place, length, slack in product(reversed(places), lengths if before.velocity.linear else _FROM_REST, SLACK):
        control = way.after(place.length + length * most)
        shape = [*_joint(place.pose, place.curvature, control[0][0]), *(point for point, _ in control)]
        spans = [*place.spans, *spline([*shape, _beyond(shape)])]
        try:
            return timed(slackened(stretch.request, slack), spans,
                         [*place.numbers, control[0][1], *(number for _, number in control)], before.velocity.linear,
                         stretch.backward)
        except ParameterError as error:
            refusal = refusal if refusal.violations else error
    raise refusal


class _Departure(NamedTuple):
    """
    A place at which the new motion leaves the present path.

    Attributes
    ----------
    spans : list of Span
        The present path up to there.
    numbers : list of int
        The waypoint of the new path whose speed limit holds in each.
    pose : Pose
        There.
    curvature : float
        There [1/m].
    length : float
        Length along the new path of its nearest point [m].

    """

    spans: list[Span]
    numbers: list[int]
    pose: Pose
    curvature: float
    length: float


class _Beside(NamedTuple):
    """
    A point of the present path, and the nearest one of the new path.

    Attributes
    ----------
    span, u : int, float
        Its span and its place there.
    travelled : float
        Length from the cart [m].
    away : float
        Distance of the new path [m].
    length : float
        Length along the new path [m].
    number : int
        Waypoint of the new path whose speed limit holds there.

    """

    span: int
    u: float
    travelled: float
    away: float
    length: float
    number: int


def _beside(ahead: Sequence[Span], way: Way, begin: float) -> list[_Beside]:
    """Return points of the present path, some centimetres apart, beside a new one from a length [m] along it on."""
    points_beside, travelled, follower = [], 0.0, Follower(way.points, begin)
    for n, span in enumerate(ahead):
        before = span.at(0.0)[:2]
        parts = max(1, math.ceil(dist(before, span.at(1.0)[:2]) / _STEP))
        for u in (part / parts for part in range(1, parts + 1)):
            point = span.at(u)[:2]
            travelled, before = travelled + dist(before, point), point
            away = follower.distance(point)
            points_beside.append(_Beside(n, u, travelled, away, follower.length, way.numbers[follower.place]))
    return points_beside


def _place(ahead: Sequence[Span], beside: Sequence[_Beside], until: float) -> _Departure:
    """Return the place after a length [m] along the present path."""
    leaving = next(one for one in beside if one.travelled >= until)
    numbers = {one.span: one.number for one in reversed(beside)}
    at = ahead[leaving.span].at(leaving.u)
    return _Departure([*ahead[:leaving.span], ahead[leaving.span].until(leaving.u)],
                      [numbers[n] for n in range(leaving.span + 1)],
                      Pose(at.x, at.y, atan2(at.dy, at.dx)), bend(at).curvature, leaving.length)


def _joint(pose: Pose, curvature: float, first: Point) -> list[Point]:
    """Return the control points of a span that begins with a pose and a curvature [1/m] and leads to a point."""
    x, y, heading = pose
    rate = 0.5 * dist((x, y), first)
    sine, cosine = sin_cos(heading)
    along = rate * cosine, rate * sine
    # r'' = κ |r'|² n
    bend = rate * curvature
    across = -bend * along[1], bend * along[0]
    return [(x + part * along[0] + share * across[0], y + part * along[1] + share * across[1])
            for part, share in ((-1.0, 1.0 / 3.0), (0.0, -1.0 / 6.0), (1.0, 1.0 / 3.0))]


def _beyond(points: Sequence[Point]) -> Point:
    """Return the control point that ends a spline at its last point."""
    return 2.0 * points[-1][0] - points[-2][0], 2.0 * points[-1][1] - points[-2][1]
