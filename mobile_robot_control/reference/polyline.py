"""Polylines: the nearest point, a point after a length, and points that follow one another along it."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate, pairwise

from mobile_robot_control.elementary import dist
from mobile_robot_control.reference.path_shape import Point

_WINDOW = 0.5
"""[m] ahead on a polyline in which the nearest point is sought."""


def nearest(points: Sequence[Point], at: Sequence[float], reach: float) -> tuple[float, float]:
    """Return the length along the first part of a polyline to the point nearest to `at`, and its distance [m]."""
    left = dist(points[0], at) + reach
    travelled, best = 0.0, (0.0, dist(points[0], at))
    for start, end in pairwise(points):
        length = dist(start, end)
        along = min(_along(start, end, at, length), left - travelled)
        away = dist(_between(start, end, along / length if length else 0.0), at)
        if away < best[1]:
            best = travelled + along, away
        travelled += length
        if travelled >= left:
            break
    return best


def point_after(points: Sequence[Point], length: float) -> tuple[Point, int]:
    """Return the point of a polyline after a length [m], the last one at most, and the number of the next waypoint."""
    for n, (start, end) in enumerate(pairwise(points), start=1):
        part = dist(start, end)
        if length < part:
            return _between(start, end, length / part), n
        length -= part
    return points[-1], len(points)


def _between(start: Point, end: Point, share: float) -> Point:
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])


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
        self._lengths = list(accumulate((dist(*two) for two in pairwise(way)), initial=0.0))
        self.length = begin
        self.place = min(max(0, bisect_right(self._lengths, begin) - 1), len(way) - 2)

    def distance(self, point: Point, passed: float = 0.0) -> float:
        """Return the distance of the polyline from a point that comes after the last one, so far behind it [m]."""
        nearest, first, reach = math.inf, self.place, self.length + 1.5 * passed + _WINDOW
        for n in range(first, len(self._way) - 1):
            if self._lengths[n] > reach and n > first:
                break
            start, end = self._way[n], self._way[n + 1]
            size = self._lengths[n + 1] - self._lengths[n]
            along = _along(start, end, point, size)
            away = dist(_between(start, end, along / size if size else 0.0), point)
            if away < nearest:
                nearest, self.place, self.length = away, n, self._lengths[n] + along
        return nearest


def _along(start: Point, end: Point, at: Sequence[float], length: float) -> float:
    """Return the length along a segment to the point on it that is nearest to `at` [m]."""
    if not length:
        return 0.0
    along = ((at[0] - start[0]) * (end[0] - start[0]) + (at[1] - start[1]) * (end[1] - start[1])) / length
    return min(max(0.0, along), length)
