"""The path of the reference cart as a table of points, and the distance of a robot from it, near the cart."""

import math
from array import array
from collections.abc import Callable
from typing import Any, NamedTuple

from mobile_robot_control.elementary import hypot, sin_cos
from mobile_robot_control.jit import jitable, jitable_apart
from mobile_robot_control.reference.course import Course

POINTS = 512
"""Points of a lap; with cubics between them the path is exact to 1e-8 of its scale for the built-in curves."""
QUARTER = POINTS // 4
"""Points in a quarter lap."""
_BETWEEN = 1.01
"""Factor of the cart's speed between two points over that at the fastest point."""
_MOST = 16 * POINTS
"""Number of points that are kept after the cart has passed them."""
_STANDING = 1e-12
"""[m]: least speed in a step, also of a path without a known point: it divides."""
_UNKNOWN = (math.nan, math.nan, math.nan, math.nan)


class PathTable(NamedTuple):
    """
    Points of the cart's path, one for each step of time along the curve; point n is the cart's position after n steps.

    Attributes
    ----------
    x, y : sequence of float
        Position, in the odometry frame [m].
    dx, dy : sequence of float
        Its change in a step, by the exact derivatives [m].
    first : int
        Number of the first point.
    step : float
        From one point to the next [s].
    speed : float
        Upper limit of the distance driven in a step [m].
    """

    x: Any
    y: Any
    dx: Any
    dy: Any
    first: int
    step: float
    speed: float


def converted(table: PathTable, convert: Callable[[Any], object]) -> PathTable:
    """Return a table with its sequences converted, for example to arrays."""
    return table._replace(x=convert(table.x), y=convert(table.y), dx=convert(table.dx), dy=convert(table.dy))


class GrowingPath:
    """
    The table of a path, extended on demand.

    Parameters
    ----------
    course : Course
        Course of the cart.

    Notes
    -----
    A closed path has a quarter lap before its start, an open one begins there. Points at which a curve raises are nan.
    """

    def __init__(self, course: Course) -> None:
        self._course, self._step = course, course.period / POINTS
        self._start = self._first = -QUARTER if course.closed else 0
        self._rows = array('d'), array('d'), array('d'), array('d')
        self._speed = _STANDING

    def between(self, begin: float, end: float) -> PathTable:
        """Return the table from a quarter lap before one time along the curve to a quarter lap after another [s]."""
        first = max(self._start, math.floor(begin / self._step) - QUARTER - 1)
        passed, count = first - self._first, len(self._rows[0])
        elsewhere = not 0 <= passed <= count
        if elsewhere or count > _MOST:
            for column in self._rows:
                del column[:count if elsewhere else passed]
            self._first = first
        for n in range(self._first + len(self._rows[0]), math.floor(end / self._step) + QUARTER + 3):
            point = self._point(n)
            # nan is not larger, and so left out
            self._speed = max(self._speed, hypot(*point[2:]))
            for column, value in zip(self._rows, point, strict=True):
                column.append(value)
        return PathTable(*self._rows, self._first, self._step, _BETWEEN * self._speed)

    def _point(self, n: int) -> tuple[float, ...]:
        """Return position and change in a step of a point; nan if the curve has none there."""
        # before the start of a closed path lies its end
        time = n * self._step + (self._course.period if n < 0 else 0.0)
        try:
            pose, velocity, _ = self._course.reference(time)
        except Exception:  # a curve can raise anything
            return _UNKNOWN
        way, (sine, cosine) = velocity.linear * self._step, sin_cos(pose.heading)
        return pose.x, pose.y, way * cosine, way * sine


_ITERATIONS = 40
_ROOT = 1e-10
"""Of a step: with a nearest point of this accuracy the distance is exact to rounding."""


@jitable
def _from_robot(table: PathTable, i: int, u: float, x: float, y: float) -> tuple[float, float, float, float]:
    """Return the vector from (x, y) to the path at a share u of the step after its i-th point, and its derivative."""
    ax, ay = table.x[i] - x, table.y[i] - y
    px, py = table.x[i + 1] - table.x[i], table.y[i + 1] - table.y[i]
    # cubic Hermite: H = a + u m₀ + u² (3p - 2m₀ - m₁) + u³ (m₀ + m₁ - 2p)
    bx, by = 3.0 * px - 2.0 * table.dx[i] - table.dx[i + 1], 3.0 * py - 2.0 * table.dy[i] - table.dy[i + 1]
    cx, cy = table.dx[i] + table.dx[i + 1] - 2.0 * px, table.dy[i] + table.dy[i + 1] - 2.0 * py
    return (
        ax + u * (table.dx[i] + u * (bx + u * cx)),
        ay + u * (table.dy[i] + u * (by + u * cy)),
        table.dx[i] + u * (2.0 * bx + 3.0 * u * cx),
        table.dy[i] + u * (2.0 * by + 3.0 * u * cy),
    )


@jitable
def distance_to_place(table: PathTable, x: float, y: float, place: float) -> float:
    """Return the distance of a position from the path's point at a place in steps of the table [m]."""
    n = int(math.floor(place))  # noqa: RUF046 (a float on a GPU)
    hx, hy, _, _ = _from_robot(table, n - table.first, place - n, x, y)
    return math.sqrt(hx * hx + hy * hy)


@jitable_apart
def _nearest_within_step(
    table: PathTable, i: int, begin: float, end: float, x: float, y: float
) -> tuple[float, float]:
    """Return the least distance of (x, y) from the path within a part of a step [m], and the share of the step."""
    hx, hy, tx, ty = _from_robot(table, i, begin, x, y)
    rise, u, least = hx * tx + hy * ty, begin, hx * hx + hy * hy
    hx, hy, tx, ty = _from_robot(table, i, end, x, y)
    if hx * hx + hy * hy < least:
        u, least = end, hx * hx + hy * hy
    if rise < 0.0 and hx * tx + hy * ty > 0.0:
        # false position with halving: half the squared distance has the derivative H · H', which rises from below 0
        low, high, below, above = begin, end, rise, hx * tx + hy * ty
        for n in range(_ITERATIONS):
            u = 0.5 * (low + high) if n % 3 == 2 else low - below * (high - low) / (above - below)
            hx, hy, tx, ty = _from_robot(table, i, u, x, y)
            rise = hx * tx + hy * ty
            if rise < 0.0:
                low, below = u, rise
            else:
                high, above = u, rise
            if high - low < _ROOT or abs(rise) < _ROOT * (above - below):
                break
        least = hx * hx + hy * hy
    return math.sqrt(least), u


@jitable_apart
def nearest_on_path(
    table: PathTable, x: float, y: float, begin: float, end: float, bound: float
) -> tuple[float, float]:
    """
    Find the point nearest to a position on a part of the path.

    Parameters
    ----------
    table : PathTable
        Of the path; it includes the points before `begin` and after `end`.
    x, y : float
        Position [m].
    begin, end : float
        Start and end of the part, in steps of the table.
    bound : float
        Only nearer points are searched [m].

    Returns
    -------
    tuple of float
        The distance [m], and the place in steps of the table; the bound and nan if no point is nearer.

    Notes
    -----
    No point of the part is missed: from a point at a distance D, the path cannot come nearer than B within (D - B) /
    speed steps, which are skipped; every other step is searched.
    """
    nearest, place = bound, math.nan
    n = int(math.floor(begin))  # noqa: RUF046 (a float on a GPU)
    while n <= end:
        i = n - table.first
        ax, ay = table.x[i] - x, table.y[i] - y
        away = math.sqrt(ax * ax + ay * ay)
        skipped = (away - nearest) / table.speed
        if skipped >= 1.0:
            n += int(min(skipped, 4.0 * QUARTER))
            continue
        # within a whole step there is a nearest point if the distance falls at its begin and rises at its end
        if n < begin or n + 1 > end or (
            ax * table.dx[i] + ay * table.dy[i] < 0.0
            < (table.x[i + 1] - x) * table.dx[i + 1] + (table.y[i + 1] - y) * table.dy[i + 1]
        ):
            away, u = _nearest_within_step(table, i, max(0.0, begin - n), min(1.0, end - n), x, y)
        else:
            u = 0.0
        if away < nearest:
            nearest, place = away, n + u
        n += 1
    return nearest, place


@jitable
def cross_track(table: PathTable, x: float, y: float, time: float, bound: float) -> float:
    """
    Return the distance of a position from the path within a quarter lap before and after the cart [m].

    Where a path crosses itself, the other branch is farther along it and does not count. The part before the start of
    an open path does not count either.

    Parameters
    ----------
    table : PathTable
        Of the path, at least to a quarter lap after the cart.
    x, y : float
        Position [m].
    time : float
        Of the cart along the curve [s].
    bound : float
        Distance of the position from the cart, an upper limit of the result [m].
    """
    at = time / table.step
    return nearest_on_path(table, x, y, max(at - QUARTER, float(table.first)), at + QUARTER, bound)[0]
