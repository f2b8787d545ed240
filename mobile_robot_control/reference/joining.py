"""
A new path in mid-run, joined to the previous motion without a jump of position, heading, speed or angular speed.

The joint is a span of the B-spline. Its first three control points give it position, heading and curvature of the
reference; it leads to the new path some way ahead.
"""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import accumulate, pairwise, product
from typing import NamedTuple

import numpy as np

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Pose, Reference
from mobile_robot_control.reference.path_fit import is_dense
from mobile_robot_control.reference.path_parameters import PathRequest, Timing
from mobile_robot_control.reference.path_shape import Point, Span, bend, control_points, lay_grid, spans_of, spline
from mobile_robot_control.reference.planned_path import (
    CORNERS,
    ImpossibleError,
    PlannedPath,
    control_of,
    plan_grid,
    timed,
)

_LENGTHS = (1.0, 2.0)
"""Lengths of the joint, in units of path.join_distance; the first feasible one is used."""
_FROM_REST = (0.3, 0.6, *_LENGTHS)
"""Those of a cart that stands, which may bend more."""
_PARTS, _STEP = 4, 0.05
"""Segments of a polyline for each span of a fitted path; and their length along the present one [m]."""
_WINDOW = 0.5
"""[m] ahead on a path in which the nearest point is sought."""
_SAME_WAY = 1.02
"""Distance from a new path up to which the present one counts as the same, in tolerances: corners use up one."""
_SAME_END = 1e-3
"""[m]: two paths with a smaller distance of their ends end together."""
_SLACK = (1.0, 1.01)
"""Shares of the limits; the previous motion may exceed them by this much between two points of its grid."""


class _Route(NamedTuple):
    """
    A new path before it is joined.

    Attributes
    ----------
    way : list of (float, float)
        A polyline along it [m].
    numbers : list of int
        The waypoint whose speed limit holds at each point of the polyline.
    after : callable
        Returns the control points from a length [m] along the polyline on, each with the number of its waypoint.

    """

    way: list[Point]
    numbers: list[int]
    after: Callable[[float], list[tuple[Point, int]]]


def _route(request: PathRequest) -> _Route:
    """Return the route of a request; a closed one is driven from its first waypoint."""
    path, waypoints = request.path, request.waypoints.points
    if path.tolerance and is_dense(waypoints):
        return _fitted_route(request)
    points, numbers = list(waypoints), list(range(len(waypoints)))
    if path.closed:
        points, numbers = path.laps * points + points[:1], path.laps * numbers + [0]

    def after(length: float) -> list[tuple[Point, int]]:
        first, rest = _from(points, length)
        if rest == len(points):
            return [(first, numbers[rest - 1])]
        control = control_points([first, *points[rest:]], False, path.tolerance or CORNERS)
        return [(point, numbers[max(0, number + rest - 1)]) for point, number in control]

    return _Route(points, numbers, after)


def _fitted_route(request: PathRequest) -> _Route:
    path, control = request.path, control_of(request)
    spans = path.laps * spans_of([point for point, _ in control], path.closed)
    control = [control[n % len(control)] for n in range(len(spans) + 1)]
    way = [span.at(part / _PARTS)[:2] for span in spans for part in range(_PARTS)] + [spans[-1].at(1.0)[:2]]
    lengths = list(accumulate((math.dist(*two) for two in pairwise(way)), initial=0.0))[::_PARTS]

    def after(length: float) -> list[tuple[Point, int]]:
        return control[min(bisect_left(lengths, length), len(control) - 1):]

    return _Route(way, [control[n // _PARTS][1] for n in range(len(way))], after)


def join(request: PathRequest, before: Reference, ahead: Sequence[Span] = ()) -> PlannedPath | None:
    """
    Plan a path that continues a reference.

    Parameters
    ----------
    request : PathRequest
        The path; a closed one is driven from its first waypoint.
    before : Reference
        Pose and motion of the cart.
    ahead : sequence of Span
        The present path, from the cart on; () if it stands. The new motion leaves it where the new path does.

    Returns
    -------
    PlannedPath or None
        None if the path leads where the present one does, or ends where the cart stands: the cart goes on.

    Raises
    ------
    ParameterError
        If the path begins too far away, has a cusp, or no motion along it keeps the limits.

    """
    route, most = _route(request), request.path.join_distance
    begin, away = _nearest(route.way, before.pose[:2], most)
    if away > most:
        x, y = before.pose[:2]
        raise ParameterError([
            f'the path begins {away:.3g} m from the cart, and path.join_distance is {most:g} m; begin it near the '
            f'cart, at ({x:.3g}, {y:.3g}), or raise that'])
    if not ahead and math.dist(before.pose[:2], route.way[-1]) < _SAME_END:
        return None
    parting = _parting(ahead, route.way, begin, _SAME_WAY * (request.path.tolerance or CORNERS))
    if parting is None:
        return None
    curvature = before.velocity.angular / before.velocity.linear if before.velocity.linear else 0.0
    places = [_Place([], [], before.pose, curvature, begin), *_places(ahead, route, begin, parting - most)]
    refusal = ParameterError([])
    # as late as the limits allow
    for place, length, slack in product(reversed(places), _LENGTHS if before.velocity.linear else _FROM_REST, _SLACK):
        control = route.after(place.length + length * most)
        shape = [*_joint(place.pose, place.curvature, control[0][0]), *(point for point, _ in control)]
        spans = [*place.spans, *spline([*shape, _beyond(shape)])]
        try:
            return timed(_slackened(request, slack), spans,
                         [*place.numbers, control[0][1], *(number for _, number in control)], before.velocity.linear)
        except ParameterError as error:
            refusal = refusal if refusal.violations else error
    raise refusal


class _Place(NamedTuple):
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


def _along(spans: Sequence[Span]) -> Iterator[tuple[int, float, Point]]:
    """Yield points of spans, some centimetres apart: the span, the place in it, and the point."""
    for n, span in enumerate(spans):
        parts = max(1, math.ceil(math.dist(span.at(0.0)[:2], span.at(1.0)[:2]) / _STEP))
        for part in range(1, parts + 1):
            yield n, part / parts, span.at(part / parts)[:2]


def _parting(ahead: Sequence[Span], way: Sequence[Point], begin: float, tolerance: float) -> float | None:
    """
    Return the length [m] along the present path from which on a new one is farther away than the tolerance.

    It is 0 for a cart that stands, and None if both end together.
    """
    travelled, follower = 0.0, Follower(way, begin)
    before: Point | None = ahead[0].at(0.0)[:2] if ahead else None
    if before is None:
        return 0.0
    for _, _, point in _along(ahead):
        travelled, before = travelled + math.dist(before, point), point
        if follower.distance(point) > tolerance:
            return max(0.0, travelled - tolerance - _STEP)
    return None if math.dist(before, way[-1]) < _SAME_END else travelled


def _places(ahead: Sequence[Span], route: _Route, begin: float, until: float) -> Iterator[_Place]:
    """Yield the place after a length [m] along the present path, if it is ahead of the cart."""
    if until <= 0.0:
        return
    travelled, follower, before = 0.0, Follower(route.way, begin), ahead[0].at(0.0)[:2]
    numbers: list[int] = []
    for n, u, point in _along(ahead):
        travelled, before = travelled + math.dist(before, point), point
        follower.distance(point)
        if len(numbers) <= n:
            numbers.append(route.numbers[follower.place])
        if travelled >= until:
            at = ahead[n].at(u)
            yield _Place([*ahead[:n], ahead[n].until(u)], numbers,
                         Pose(at.x, at.y, math.atan2(at.dy, at.dx)), bend(at).curvature, follower.length)
            return


class Follower:
    """
    Follows points along a polyline.

    Parameters
    ----------
    way : sequence of (float, float)
        The polyline [m].
    begin : float
        Length to the first point on it [m].

    Attributes
    ----------
    place : int
        Number of the segment that is nearest to the last point.
    length : float
        Along the polyline to the nearest point on it [m].

    """

    def __init__(self, way: Sequence[Point], begin: float) -> None:
        self._way = way
        self._lengths = list(accumulate((math.dist(*two) for two in pairwise(way)), initial=0.0))
        self.length = begin
        self.place = min(max(0, bisect_right(self._lengths, begin) - 1), len(way) - 2)

    def distance(self, point: Point, passed: float = 0.0) -> float:
        """Return the distance of the polyline from a point that comes after the last one, so far behind it [m]."""
        nearest, first = math.inf, self.place
        for n in range(first, len(self._way) - 1):
            if self._lengths[n] > self._lengths[first] + 1.5 * passed + _WINDOW and n > first:
                break
            start, end = self._way[n], self._way[n + 1]
            size = self._lengths[n + 1] - self._lengths[n]
            along = _share(start, end, point, size)
            away = math.dist(_between(start, end, along / size if size else 0.0), point)
            if away < nearest:
                nearest, self.place, self.length = away, n, self._lengths[n] + along
        return nearest


def _share(start: Point, end: Point, at: Point, length: float) -> float:
    """Return the length along a segment to the point on it that is nearest to `at` [m]."""
    if not length:
        return 0.0
    along = ((at[0] - start[0]) * (end[0] - start[0]) + (at[1] - start[1]) * (end[1] - start[1])) / length
    return min(max(0.0, along), length)


def _slackened(request: PathRequest, share: float) -> PathRequest:
    """Return a request with a share of its limits."""
    factor, fraction, *limits = request.timing
    return request._replace(
        timing=Timing(factor, fraction, *(share * limit for limit in limits)),
        drive=request.drive._replace(stall_torque=share * request.drive.stall_torque))


def stop(rest: Sequence[Span], request: PathRequest, before: Reference) -> PlannedPath:
    """
    Plan the shortest stop along the rest of a path.

    Parameters
    ----------
    rest : sequence of Span
        Rest of the path, from the cart on.
    request : PathRequest
        With the limits.
    before : Reference
        Motion of the cart.

    """
    # rather by more than a limit than not at all
    for slack in (*_SLACK, 1.02, 1.05, 1.1, 1.2, 1.5, 2.0):
        stopped = _stop(rest, _slackened(request, slack), before.velocity.linear)
        if stopped is not None:
            return stopped
    raise ParameterError(['no stop on the rest of the path keeps the limits of timing'])


def _stop(rest: Sequence[Span], request: PathRequest, speed: float) -> PlannedPath | None:
    """Plan the shortest stop from a speed [m/s]; None if the limits do not allow one."""
    def first_part(count: int) -> PlannedPath | None:
        """Return the motion to a stop within so many intervals of the grid; None if there is none."""
        part = grid.first(count)
        with suppress(ImpossibleError):
            return plan_grid(rest, part, request.timing, request.drive, np.full(count, np.inf), speed)
        return None

    count = 1
    while True:
        grid = lay_grid(list(rest[:count]))
        longest = len(grid.length)
        stopped = first_part(longest)
        if stopped is not None:
            break
        if count >= len(rest):
            return None
        count *= 2
    shortest = 0
    while longest - shortest > 1:
        middle = (shortest + longest) // 2
        found = first_part(middle)
        if found is None:
            shortest = middle
        else:
            stopped, longest = found, middle
    return stopped


def _nearest(points: Sequence[Point], at: Sequence[float], reach: float) -> tuple[float, float]:
    """Return the length along the first part of a polyline to the point nearest to `at`, and its distance [m]."""
    left = math.dist(points[0], at) + reach
    travelled, found = 0.0, (0.0, math.dist(points[0], at))
    for start, end in pairwise(points):
        length = math.dist(start, end)
        along = ((at[0] - start[0]) * (end[0] - start[0]) + (at[1] - start[1]) * (end[1] - start[1])) / length
        along = min(max(0.0, along), length, left - travelled)
        away = math.dist(_between(start, end, along / length), at)
        if away < found[1]:
            found = travelled + along, away
        travelled += length
        if travelled >= left:
            break
    return found


def _from(points: Sequence[Point], length: float) -> tuple[Point, int]:
    """Return the point of a polyline after a length [m], the last one at most, and the number of the next waypoint."""
    for n, (start, end) in enumerate(pairwise(points), start=1):
        part = math.dist(start, end)
        if length < part:
            return _between(start, end, length / part), n
        length -= part
    return points[-1], len(points)


def _between(start: Point, end: Point, share: float) -> Point:
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])


def _joint(pose: Pose, curvature: float, first: Point) -> list[Point]:
    """Return the control points of a span that begins with a pose and a curvature [1/m] and leads to a point."""
    x, y, heading = pose
    rate = 0.5 * math.dist((x, y), first)
    along = rate * math.cos(heading), rate * math.sin(heading)
    # r'' = κ |r'|² n
    bend = rate * curvature
    across = -bend * along[1], bend * along[0]
    return [(x + part * along[0] + share * across[0], y + part * along[1] + share * across[1])
            for part, share in ((-1.0, 1.0 / 3.0), (0.0, -1.0 / 6.0), (1.0, 1.0 / 3.0))]


def _beyond(points: Sequence[Point]) -> Point:
    """Return the control point that ends a spline at its last point."""
    return 2.0 * points[-1][0] - points[-2][0], 2.0 * points[-1][1] - points[-2][1]
