"""
The shape of a path: waypoints joined with continuous curvature, as a uniform cubic B-spline.

A cubic B-spline has continuous second derivatives, stays within the hull of its control points, and is straight where
they are in line. At a corner that turns by θ, two control points on its legs at a distance d keep the curve within
d sin(θ/2)/3 of the corner; closer waypoints are control points themselves.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.reference.curve import CurvePoint

Point = tuple[float, float]
_STRAIGHT = 1e-9
"""[rad]: a smaller turn counts as none."""


class Span(NamedTuple):
    """
    A cubic between two knots, for u in [0, 1].

    Attributes
    ----------
    x, y : tuple of float
        Coefficients of 1, u, u² and u³ [m]; for many spans, arrays.

    """

    x: tuple[Any, ...]
    y: tuple[Any, ...]

    def at(self, u: Any) -> CurvePoint:
        """Return the point at u, with its derivatives by u [m]."""
        x0, x1, x2, x3 = self.x
        y0, y1, y2, y3 = self.y
        return CurvePoint(
            x0 + u * (x1 + u * (x2 + u * x3)), y0 + u * (y1 + u * (y2 + u * y3)),
            x1 + u * (2.0 * x2 + 3.0 * u * x3), y1 + u * (2.0 * y2 + 3.0 * u * y3),
            2.0 * x2 + 6.0 * u * x3, 2.0 * y2 + 6.0 * u * y3,
            6.0 * x3, 6.0 * y3,
        )

    def after(self, u: float) -> 'Span':
        """Return the rest of the span, from u on."""
        return Span(*(_rest(cubic, u) for cubic in self))


def _rest(c: tuple[float, ...], u: float) -> tuple[float, ...]:
    """Return the coefficients of a cubic of u + (1 - u) w by w."""
    left = 1.0 - u
    return (c[0] + u * (c[1] + u * (c[2] + u * c[3])), left * (c[1] + u * (2.0 * c[2] + 3.0 * u * c[3])),
            left * left * (c[2] + 3.0 * u * c[3]), left * left * left * c[3])


class Bend(NamedTuple):
    """
    The bend of a curve at a point.

    Attributes
    ----------
    speed : float or array
        Length of the path per u [m].
    curvature : float or array
        Turn of the heading per length of the path [1/m].
    sharpness : float or array
        Change of the curvature per length of the path [1/m²].

    """

    speed: Any
    curvature: Any
    sharpness: Any


def bend(point: Any, root: Callable[[Any], Any] = math.sqrt) -> Bend:
    """Return the bend at a CurvePoint with third derivatives; for arrays, pass NumPy's square root."""
    square = point.dx * point.dx + point.dy * point.dy
    speed = root(square)
    cube = square * speed
    # κ = (x' y'' - y' x'')/|r'|³, and dκ/ds = dκ/du / |r'|
    curvature = (point.dx * point.ddy - point.dy * point.ddx) / cube
    along = (point.dx * point.ddx + point.dy * point.ddy) / square
    turn = (point.dx * point.dddy - point.dy * point.dddx) / cube
    return Bend(speed, curvature, (turn - 3.0 * curvature * along) / speed)


def _apart(one: Point, other: Point) -> float:
    return math.hypot(other[0] - one[0], other[1] - one[1])


def _reach(before: Point, corner: Point, after: Point, tolerance: float) -> float:
    """Return the largest distance of control points from their corner [m]; inf if the path goes straight on."""
    turn = abs(wrap_angle(math.atan2(after[1] - corner[1], after[0] - corner[0])
                          - math.atan2(corner[1] - before[1], corner[0] - before[0])))
    return 3.0 * tolerance / math.sin(0.5 * turn) if turn > _STRAIGHT else math.inf


def control_points(waypoints: Sequence[Point], closed: bool, tolerance: float) -> list[tuple[Point, int]]:
    """
    Return the control points of a path, each with the number of the waypoint that it is or follows.

    Parameters
    ----------
    waypoints : sequence of (float, float)
        Positions [m]; no two neighbours are equal.
    closed : bool
        Whether the last waypoint leads to the first.
    tolerance : float
        Largest distance of the path from a waypoint [m].

    """
    count = len(waypoints)
    reach = [math.inf if not closed and n in (0, count - 1)
             else _reach(waypoints[n - 1], waypoints[n], waypoints[(n + 1) % count], tolerance) for n in range(count)]
    found = []
    for n in range(count if closed else count - 1):
        start, end = waypoints[n], waypoints[(n + 1) % count]
        length, near, far = _apart(start, end), reach[n], reach[(n + 1) % count]
        found.append((start, n))
        if length <= min(near, far):
            continue
        middle = [0.5] if length <= 2.0 * min(near, far) else []
        for share in middle or sorted({near / length, 1.0 - far / length}):
            if 0.0 < share < 1.0:
                found.append(((start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])), n))
    return found if closed else [*found, (waypoints[-1], count - 1)]


def spans_of(points: Sequence[Point], closed: bool) -> list[Span]:
    """
    Return the spans of the uniform cubic B-spline of control points.

    An open path begins at its first point and ends at its last; a closed one begins beside its first.
    """
    if closed:
        around = [points[-1], *points, points[0], points[1 % len(points)]]
    else:
        first, last = points[0], points[-1]
        around = [(2.0 * first[0] - points[1][0], 2.0 * first[1] - points[1][1]), *points,
                  (2.0 * last[0] - points[-2][0], 2.0 * last[1] - points[-2][1])]
    return spline(around)


def spline(points: Sequence[Point]) -> list[Span]:
    """Return the spans of the uniform cubic B-spline of control points, four to a span."""
    return [Span(*map(_cubic, zip(*points[n:n + 4], strict=True))) for n in range(len(points) - 3)]


def _cubic(p: tuple[float, ...]) -> tuple[float, float, float, float]:
    """Return the coefficients of a span of the B-spline of four control points."""
    return ((p[0] + 4.0 * p[1] + p[2]) / 6.0, 0.5 * (p[2] - p[0]), 0.5 * (p[0] - 2.0 * p[1] + p[2]),
            (p[3] - p[0] + 3.0 * (p[1] - p[2])) / 6.0)
