"""The path of the reference cart as a table of points, with interpolation between them."""

import math
from array import array
from collections.abc import Callable
from typing import Any, NamedTuple

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


def converted(table: PathTable, convert: Callable[[Any], Any]) -> PathTable:
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
            self._speed = max(self._speed, math.hypot(*point[2:]))
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
        way = velocity.linear * self._step
        return pose.x, pose.y, way * math.cos(pose.heading), way * math.sin(pose.heading)
