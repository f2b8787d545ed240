"""
The shape of a path: waypoints joined with continuous curvature, as a uniform cubic B-spline.

A cubic B-spline has continuous second derivatives, stays within the hull of its control points, and is straight where
they are in line. At a corner that turns by θ, two control points on its legs at a distance d keep the curve within
d sin(θ/2)/3 of the corner; closer waypoints are control points themselves.
"""

import math
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import atan2, dist, sin
from mobile_robot_control.reference.curves import CurvePoint

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

    def until(self, u: float) -> 'Span':
        """Return the span up to u."""
        return Span(*((c0, c1 * u, c2 * u * u, c3 * u * u * u) for c0, c1, c2, c3 in self))


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


def _reach(before: Point, corner: Point, after: Point, tolerance: float) -> float:
    """Return the largest distance of control points from their corner [m]; inf if the path goes straight on."""
    turn = abs(wrap_angle(atan2(after[1] - corner[1], after[0] - corner[0])
                          - atan2(corner[1] - before[1], corner[0] - before[0])))
    return 3.0 * tolerance / sin(0.5 * turn) if turn > _STRAIGHT else math.inf


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
    control = []
    for n in range(count if closed else count - 1):
        start, end = waypoints[n], waypoints[(n + 1) % count]
        length, near, far = dist(start, end), reach[n], reach[(n + 1) % count]
        control.append((start, n))
        if length <= min(near, far):
            continue
        middle = [0.5] if length <= 2.0 * min(near, far) else []
        for share in middle or sorted({near / length, 1.0 - far / length}):
            if 0.0 < share < 1.0:
                control.append(((start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])), n))
    return control if closed else [*control, (waypoints[-1], count - 1)]


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


Floats = NDArray[np.float64]
MOST_POINTS = 500_000
"""Most points of a grid."""
_INTERVALS = 800
"""Intervals of a path without bends."""
_TURN = 0.04
"""Largest turn in an interval [rad]."""
_SHARPEST = 0.3
"""Largest product of curvature and length of an interval."""
_CHANGE, _WEAK = 0.1, 2.0
"""Largest change of the curvature in an interval, as a share of the sum of its size and this one [1/m]."""
_SAMPLES = 16
_INNER, _OUTER = (math.sqrt(5.0 + sign * 2.0 * math.sqrt(10.0 / 7.0)) / 3.0 for sign in (-1.0, 1.0))
_MORE, _LESS = ((322.0 + sign * 13.0 * math.sqrt(70.0)) / 900.0 for sign in (1.0, -1.0))
_NODES = np.array([-_OUTER, -_INNER, 0.0, _INNER, _OUTER])
_WEIGHTS = np.array([_LESS, _MORE, 128.0 / 225.0, _MORE, _LESS])
"""Gauss-Legendre quadrature with five points on [-1, 1]."""


class TooSharpError(ValueError):
    """A path bends too sharply; `span` is the number of the span."""

    def __init__(self, span: int) -> None:
        super().__init__(f'span {span}')
        self.span = span


class PathGrid(NamedTuple):
    """
    A path as N intervals of its spans.

    Attributes
    ----------
    span : array of int, shape (N,)
        The span of each interval.
    u : array of float, shape (N, 2)
        Start and end of the interval in its span.
    rate : array of float, shape (N, 2)
        du / ds there [1/m].
    length : array of float, shape (N,)
        [m].
    curvature, sharpness : array of float, shape (N, 2)
        At its ends, within the interval [1/m], [1/m²].

    """

    span: NDArray[np.int64]
    u: Floats
    rate: Floats
    length: Floats
    curvature: Floats
    sharpness: Floats

    def first(self, count: int) -> 'PathGrid':
        """Return the first intervals, so many."""
        return PathGrid(self.span[:count], *(each[:count] for each in self[1:]))


def _coefficients(spans: list[Span]) -> tuple[Floats, Floats]:
    return np.array([span.x for span in spans]), np.array([span.y for span in spans])


def _points(x: Floats, y: Floats, u: Floats) -> CurvePoint:
    """Return many points of each span; coefficients of shape (n, 4), u of shape (n, k)."""
    def columns(c: Floats) -> tuple[Floats, ...]:
        return tuple(c[:, None, power] for power in range(4))

    return Span(columns(x), columns(y)).at(u)


def _sums(values: Floats) -> Floats:
    """Return the sums of rows, added in their order: that of numpy depends on the machine."""
    return reduce(np.add, values.T)


def _bends(x: Floats, y: Floats, u: Floats) -> Bend:
    return bend(_points(x, y, u), np.sqrt)


def lay_grid(spans: list[Span]) -> PathGrid:
    """
    Lay a grid on a path.

    Raises
    ------
    TooSharpError
        If a bend needs more than MOST_POINTS.

    """
    x, y = _coefficients(spans)
    with np.errstate(divide='ignore', invalid='ignore', over='ignore'):
        return _refined(x, y, _first_counts(x, y))


def _first_counts(x: Floats, y: Floats) -> NDArray[np.int64]:
    """Return the number of intervals of each span from its length and its turn."""
    u = np.tile((np.arange(_SAMPLES) + 0.5) / _SAMPLES, (len(x), 1))
    speed, curvature, _ = _bends(x, y, u)
    lengths = _sums(speed) / _SAMPLES
    turns = _sums(np.nan_to_num(np.abs(curvature) * speed, nan=0.0, posinf=1.0)) / _SAMPLES
    whole = math.fsum(lengths.tolist())
    counts: NDArray[np.int64] = np.ceil(np.maximum(lengths * _INTERVALS / whole, turns / _TURN)).astype(int)
    return np.maximum(counts, 1)


def _refined(x: Floats, y: Floats, counts: NDArray[np.int64]) -> PathGrid:
    """Return the grid with so many intervals in each span, or more at sharp bends."""
    while True:
        if counts.sum() >= MOST_POINTS:
            raise TooSharpError(int(np.argmax(counts)))
        span = np.repeat(np.arange(len(counts)), counts)
        number = np.arange(len(span)) - np.repeat(np.cumsum(counts) - counts, counts)
        u = np.stack([number / counts[span], (number + 1) / counts[span]], axis=1)
        middle, half = 0.5 * (u[:, :1] + u[:, 1:]), 0.5 * (u[:, 1:] - u[:, :1])
        between, inner, _ = _bends(x[span], y[span], middle + half * _NODES)
        length = _sums(half * (between * _WEIGHTS))
        ends: Any = _points(x[span], y[span], u)
        speed, curvature, sharpness = bend(ends, np.sqrt)
        # a path that reverses on a straight line has no curvature
        turns_back = ends.dx[:, 0] * ends.dx[:, 1] + ends.dy[:, 0] * ends.dy[:, 1] <= 0.0
        most = np.maximum(np.abs(curvature).max(axis=1), np.abs(inner).max(axis=1))
        change = np.abs(sharpness).max(axis=1) * length / (most + _WEAK)
        worst = np.zeros(len(counts))
        sharp = np.where(turns_back, np.inf, np.maximum(most * length / _SHARPEST, change / _CHANGE))
        np.maximum.at(worst, span, np.nan_to_num(sharp, nan=np.inf))
        if not (worst > 1.0).any():
            return PathGrid(span, u, 1.0 / speed, length, curvature, sharpness)
        counts = np.where(worst > 1.0, 2 * counts, counts)
