"""
A new path in mid-run, joined to the previous motion without a jump of position, heading, speed or angular speed.

The joint is a span of the B-spline. Its first three control points give it position, heading and curvature of the
reference; it leads to the new path some way ahead.
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from itertools import pairwise, product

import numpy as np

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import Reference
from mobile_robot_control.reference.path_parameters import PathRequest, Timing
from mobile_robot_control.reference.path_shape import Point, Span, control_points, lay_grid, spline
from mobile_robot_control.reference.planned_path import ImpossibleError, PlannedPath, plan_grid, timed

_LENGTHS = (1.0, 2.0)
"""Lengths of the joint, in units of path.join_distance; the first feasible one is used."""
_SLACK = (1.0, 1.01)
"""Shares of the limits; the previous motion may exceed them by this much between two points of its grid."""


def join(request: PathRequest, before: Reference) -> PlannedPath:
    """
    Plan a path that continues a reference.

    Parameters
    ----------
    request : PathRequest
        The path; a closed one is driven from its first waypoint.
    before : Reference
        Pose and motion of the cart.

    Raises
    ------
    ParameterError
        If the path begins too far away, has a cusp, or no motion along it keeps the limits.

    """
    points, numbers = list(request.waypoints.points), list(range(len(request.waypoints.points)))
    if request.path.closed:
        points, numbers = request.path.laps * points + points[:1], request.path.laps * numbers + [0]
    most = request.path.join_distance
    begin, away = _nearest(points, before.pose[:2], most)
    if away > most:
        raise ParameterError([
            f'the path begins {away:.3g} m from the cart at ({before.pose.x:.3g}, {before.pose.y:.3g}), and '
            f'path.join_distance is {most:g} m; begin it where the robot is, or raise that'])
    refusal = ParameterError([])
    for length, slack in product(_LENGTHS, _SLACK):
        first, rest = _from(points, begin + length * most)
        control = [(first, rest - 1)]
        if rest < len(points):
            control = control_points([first, *points[rest:]], False, request.path.corner_tolerance)
            control = [(point, max(0, number + rest - 1)) for point, number in control]
        shape = [*_joint(before, first), *(point for point, _ in control)]
        spans = spline([*shape, _beyond(shape)])
        followed = [control[0][1], *(number for _, number in control)]
        try:
            return timed(_slackened(request, slack), spans, [numbers[number] for number in followed],
                         before.velocity.linear)
        except ParameterError as error:
            refusal = refusal if refusal.violations else error
    raise refusal


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
    for slack in _SLACK:
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


def _joint(before: Reference, first: Point) -> list[Point]:
    """Return the control points of a span that begins with a reference's motion and leads to a point."""
    x, y, heading = before.pose
    v, omega = before.velocity
    rate = 0.5 * math.dist((x, y), first)
    along = rate * math.cos(heading), rate * math.sin(heading)
    # r'' = κ |r'|² n
    bend = rate * (omega / v if v else 0.0)
    across = -bend * along[1], bend * along[0]
    return [(x + part * along[0] + share * across[0], y + part * along[1] + share * across[1])
            for part, share in ((-1.0, 1.0 / 3.0), (0.0, -1.0 / 6.0), (1.0, 1.0 / 3.0))]


def _beyond(points: Sequence[Point]) -> Point:
    """Return the control point that ends a spline at its last point."""
    return 2.0 * points[-1][0] - points[-2][0], 2.0 * points[-1][1] - points[-2][1]
