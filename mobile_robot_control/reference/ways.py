"""The way of each stretch of a new path before it is joined: a polyline, and the control points ahead on it."""

import math
from bisect import bisect_left
from collections.abc import Callable
from itertools import accumulate, pairwise
from typing import NamedTuple

from mobile_robot_control.elementary import dist
from mobile_robot_control.reference.path_shape import Point, control_points
from mobile_robot_control.reference.polyline import point_after
from mobile_robot_control.reference.stretches import PARTS, Stretch, is_fitted, points_of, polyline


class Way(NamedTuple):
    """
    A stretch of a new path before it is joined.

    Attributes
    ----------
    points : list of (float, float)
        A polyline along it [m].
    numbers : list of int
        The waypoint whose speed limit holds at each point of the polyline.
    after : callable
        Returns the control points from a length [m] along the polyline on, each with the number of its waypoint.

    """

    points: list[Point]
    numbers: list[int]
    after: Callable[[float], list[tuple[Point, int]]]

    @property
    def length(self) -> float:
        """Of the polyline [m]."""
        return math.fsum(dist(*two) for two in pairwise(self.points))


def way_of(stretch: Stretch) -> Way:
    """Return the way of a stretch; a closed one is driven from its first waypoint."""
    request = stretch.request
    path, points = request.path, points_of(request)
    if is_fitted(request):
        return _fitted_way(stretch)
    numbers = list(range(len(points)))
    if path.closed:
        points, numbers = path.laps * points + points[:1], path.laps * numbers + [0]

    def after(length: float) -> list[tuple[Point, int]]:
        first, rest = point_after(points, length)
        if rest == len(points):
            return [(first, numbers[rest - 1])]
        control = control_points([first, *points[rest:]], False, path.rounding)
        return [(point, numbers[max(0, number + rest - 1)]) for point, number in control]

    return Way(points, numbers, after)


def _fitted_way(stretch: Stretch) -> Way:
    control = [stretch.control[n % len(stretch.control)] for n in range(len(stretch.spans) + 1)]
    points = polyline(stretch.spans)
    lengths = list(accumulate((dist(*two) for two in pairwise(points)), initial=0.0))[::PARTS]

    def after(length: float) -> list[tuple[Point, int]]:
        return control[min(bisect_left(lengths, length), len(control) - 1):]

    return Way(points, [control[n // PARTS][1] for n in range(len(points))], after)
