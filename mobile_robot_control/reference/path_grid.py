"""The grid of a path: intervals short enough for its bends, with length, curvature and sharpness at their ends."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.reference.curve import CurvePoint
from mobile_robot_control.reference.path_shape import Bend, Span, bend

Floats = NDArray[np.float64]
MOST_POINTS = 100_000
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
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)


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
    lengths = speed.mean(axis=1)
    turns = np.nan_to_num(np.abs(curvature) * speed, nan=0.0, posinf=1.0).mean(axis=1)
    counts: NDArray[np.int64] = np.ceil(np.maximum(lengths * _INTERVALS / lengths.sum(), turns / _TURN)).astype(int)
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
        length = (half * (between * _WEIGHTS)).sum(axis=1)
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
