"""
A new path in mid-run, joined to the previous motion without a jump of position, heading, speed or angular speed.

The joint is a span of the B-spline. Its first three control points give it position, heading and curvature of the
reference; it leads to the new path some way ahead.
"""

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import accumulate, pairwise, product
from typing import NamedTuple

import numpy as np

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Pose, Reference
from mobile_robot_control.reference.path_parameters import PathRequest, Timing
from mobile_robot_control.reference.path_shape import Point, Span, bend, control_points, lay_grid, spans_of, spline
from mobile_robot_control.reference.planned_path import (
    ImpossibleError,
    PlannedPath,
    control_of,
    is_fitted,
    plan_grid,
    points_of,
    timed,
)
from mobile_robot_control.reference.polyline import Follower, nearest, point_after

_LENGTHS = (1.0, 2.0)
"""Lengths of the joint, in units of path.join_distance; the first feasible one is used."""
_FROM_REST = (0.3, 0.6, *_LENGTHS)
"""Those of a cart that stands, which may bend more."""
_PARTS, _STEP = 4, 0.05
"""Segments of a polyline for each span of a fitted path; and their length along the present one [m]."""
STANDS = 1e-3
"""[m/s]: a slower cart counts as standing."""
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
    path, points = request.path, points_of(request)
    if is_fitted(request):
        return _fitted_route(request)
    numbers = list(range(len(points)))
    if path.closed:
        points, numbers = path.laps * points + points[:1], path.laps * numbers + [0]

    def after(length: float) -> list[tuple[Point, int]]:
        first, rest = point_after(points, length)
        if rest == len(points):
            return [(first, numbers[rest - 1])]
        control = control_points([first, *points[rest:]], False, path.rounding)
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


def join(
    request: PathRequest, before: Reference, ahead: Sequence[Span] = (), anew: bool = False
) -> PlannedPath | None:
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
    anew : bool
        Whether the present motion keeps other limits than those of the request.

    Returns
    -------
    PlannedPath or None
        None if the path leads where the present one does, or ends where the cart stands: the cart goes on. Not with
        `anew`.

    Raises
    ------
    ParameterError
        If the path begins too far away, has a cusp, or no motion along it keeps the limits.

    """
    route, most = _route(request), request.path.join_distance
    begin, away = nearest(route.way, before.pose[:2], most)
    if away > most:
        x, y = before.pose[:2]
        raise ParameterError([
            f'the path begins {away:.3g} m from the cart, and path.join_distance is {most:g} m; begin it near the '
            f'cart, at ({x:.3g}, {y:.3g}), or raise that'])
    beside, near = _beside(ahead, route, begin), _SAME_WAY * request.path.rounding
    parting = next((one.travelled - near - _STEP for one in beside if one.away > near), None)
    end = ahead[-1].at(1.0)[:2] if ahead else before.pose[:2]
    if parting is None and math.dist(end, route.way[-1]) < _SAME_END and not (anew and ahead):
        return None
    curvature = before.velocity.angular / before.velocity.linear if before.velocity.linear else 0.0
    places = [_Place([], [], before.pose, curvature, begin)]
    leaves = (beside[-1].travelled if beside else 0.0) if parting is None else parting
    if leaves > most:
        places.append(_place(ahead, beside, leaves - most))
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


def _beside(ahead: Sequence[Span], route: _Route, begin: float) -> list[_Beside]:
    """Return points of the present path, some centimetres apart, beside a route from a length [m] along it on."""
    found, travelled, follower = [], 0.0, Follower(route.way, begin)
    for n, span in enumerate(ahead):
        before = span.at(0.0)[:2]
        parts = max(1, math.ceil(math.dist(before, span.at(1.0)[:2]) / _STEP))
        for u in (part / parts for part in range(1, parts + 1)):
            point = span.at(u)[:2]
            travelled, before = travelled + math.dist(before, point), point
            away = follower.distance(point)
            found.append(_Beside(n, u, travelled, away, follower.length, route.numbers[follower.place]))
    return found


def _place(ahead: Sequence[Span], beside: Sequence[_Beside], until: float) -> _Place:
    """Return the place after a length [m] along the present path."""
    leaving = next(one for one in beside if one.travelled >= until)
    numbers = {one.span: one.number for one in reversed(beside)}
    at = ahead[leaving.span].at(leaving.u)
    return _Place([*ahead[:leaving.span], ahead[leaving.span].until(leaving.u)],
                  [numbers[n] for n in range(leaving.span + 1)],
                  Pose(at.x, at.y, math.atan2(at.dy, at.dx)), bend(at).curvature, leaving.length)


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
        Motion of the cart, faster than STANDS.

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
    if longest > 1:
        return stopped
    # within the first interval, on a grid of its own: a slow cart would take long to its end
    return _stop([rest[0].until(float(grid.u[0, 1]))], request, speed) or stopped


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
