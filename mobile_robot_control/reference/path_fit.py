"""
A smooth path through dense points: of a grid, a recording or a planner.

The path p is the uniform cubic B-spline that minimises ∫ |p - q|² + λ |p''|² ds, where q is the polyline of the points
and s its length. λ = (w / 2π)⁴ halves waves of the length w: a staircase of a grid disappears, and a straight stays
straight. Where the path would leave the tolerance, as at a corner, λ is smaller.

The normal equations have seven diagonals. All sums are in an order of our own, without BLAS or LAPACK, so that every
machine finds the same path.
"""

import math
from collections.abc import Sequence
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.elementary import dist, hypot
from mobile_robot_control.reference.path_shape import Floats, Point, spans_of
from mobile_robot_control.reference.polyline import nearest

Whole = NDArray[np.int64]
DENSE = 0.2
"""[m]: points farther apart are not fitted; and the largest distance of two knots."""
_STIFFNESS = (2.0 / math.pi) * (2.0 / math.pi) * (2.0 / math.pi) * (2.0 / math.pi)
"""λ for lengths in knots: it halves waves of four knots."""
_KNOTS = 4.0
"""Largest distance of two knots, in tolerances."""
_SAMPLES, _CHECKED = 4, 8
"""Samples between two knots: of the polyline, at least, and of the path for its distance from given points."""
_LEAST = 4
"""Spans of a path, at least."""
_GATHERED = 0.6
"""Points nearer to each other than this share of the tolerance are replaced by their mean."""
_WITHIN = 0.98
"""Share of the tolerance to reach."""
_TRIES = 40
_FINEST = 0.05
"""Smallest distance of two knots, in tolerances."""
_AROUND = 3.0
"""[m] beside a lap of a closed path, from where nothing has influence."""
_REACH, _BACK = 0.15, -0.5 * math.sqrt(3.0)
"""[m] before and after a point, whose directions differ by 150° and more where a path turns back."""
_OVERLAP = 0.3
"""[m]: points may lead back by this much and on again, as where a planner appends a new plan to the old one."""
_MOST_BACK = 1000
"""Points before a point that an overlap may lead back to."""
_BESIDE = 16
"""Spans before and after a point in which the path passes it."""
_FINE = 32
"""Samples between two knots for the distance of a point that may be too far."""
_ROUNDED = 1e-6
"""[m]: of coordinates as of a map."""
_GAUSS = (0.5 - 0.5 / math.sqrt(3.0), 0.5 + 0.5 / math.sqrt(3.0))


class TurnsBackError(ValueError):
    """A path turns back; `number` is that of the point."""

    def __init__(self, number: int) -> None:
        super().__init__(f'point {number}')
        self.number = number


class MissedError(ValueError):
    """A path misses a point by more than its tolerance; `number` is that of the point, `distance` its distance [m]."""

    def __init__(self, number: int, distance: float) -> None:
        super().__init__(f'point {number}')
        self.number, self.distance = number, distance


class _Polyline(NamedTuple):
    """
    A polyline.

    Attributes
    ----------
    knots : array of float, shape (n,)
        Length from the start to each of its points, in knots.
    samples : array of float, shape (m, 2)
        Points of it, its own ones included [m].
    at : array of float, shape (m,)
        Length from the start to each sample, in knots.
    spans : int
        Of the path: knots of the whole.
    length : float
        Of the whole [m].

    """

    knots: Floats
    samples: Floats
    at: Floats
    spans: int
    length: float


def is_dense(points: Sequence[Point]) -> bool:
    """Return whether any two neighbours are so near to each other that the points are fitted."""
    return any(dist(one, other) < DENSE for one, other in pairwise(points))


def fitted(points: Sequence[Point], closed: bool, tolerance: float) -> list[tuple[Point, int]]:
    """
    Fit a path to points.

    Parameters
    ----------
    points : sequence of (float, float)
        Positions [m]; no two neighbours are equal.
    closed : bool
        Whether the last point leads to the first.
    tolerance : float
        Largest distance of points, their polyline and the path from each other [m].

    Returns
    -------
    list of ((float, float), int)
        Control points of a spline, each with the number of the point at or before its knot. An open path begins and
        ends at its first and last one.

    Raises
    ------
    TurnsBackError
        If the path turns back.
    MissedError
        If it misses a point.

    """
    originals = [*points, points[0]] if closed else list(points)
    for radius in (_GATHERED * tolerance, 0.5 * _GATHERED * tolerance, 0.0):
        kept, tips = _cleaned(_gathered(originals, radius), tolerance)
        if tips:
            raise TurnsBackError(tips[0])
        if len(kept) == 2 and kept[0][0] == kept[1][0]:
            continue  # it begins and ends at one place, and stays near it
        control, line = _within(np.array([point for point, _ in kept]), closed, tolerance)
        numbers = np.array([number for _, number in kept])
        far = _far(originals, numbers, control, line, closed, tolerance)
        if not far:
            break
    else:
        _refuse_misses(originals, far, control.tolist(), closed, tolerance)
    first = np.searchsorted(line.knots, np.arange(len(control)) + 1e-9, side='right') - 1
    return [((x, y), int(number)) for (x, y), number in zip(control.tolist(), numbers[first], strict=True)]


def _gathered(points: Sequence[Point], radius: float) -> list[tuple[Point, int]]:
    """Return the means of points within a radius [m] of the first of them, each with its number; the ends stay."""
    groups = [[0]]
    for number in range(1, len(points)):
        if dist(points[number], points[groups[-1][0]]) < radius:
            groups[-1].append(number)
        else:
            groups.append([number])
    means = [((_mean([points[n][0] for n in group]), _mean([points[n][1] for n in group])), group[0])
             for group in groups[1:-1]]
    return [(points[0], 0), *means, (points[-1], groups[-1][0] or len(points) - 1)]


def _mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values)


def turning_points(points: Sequence[Point], tolerance: float) -> list[int]:
    """Return the numbers of the points at which a path turns back; overlaps do not count if it is fitted."""
    if tolerance > 0.0 and is_dense(points):
        return _cleaned(_gathered(points, _GATHERED * tolerance), tolerance)[1]
    return [n for n in range(1, len(points) - 1) if _leads_back(points[n - 1], points[n], points[n + 1])]


def _leads_back(before: Point, at: Point, after: Point) -> bool:
    dx, dy, ex, ey = at[0] - before[0], at[1] - before[1], after[0] - at[0], after[1] - at[1]
    return dx * ex + dy * ey < _BACK * hypot(dx, dy) * hypot(ex, ey)


def _cleaned(
    kept: list[tuple[Point, int]], tolerance: float
) -> tuple[list[tuple[Point, int]], list[int]]:
    """
    Return points without short stretches that lead back and on, and the numbers of those where they turn back.

    What is left out lies within the tolerance of the rest [m].
    """
    cleaned, tips, last = list(kept), [], 0
    n = 1
    while n < len(cleaned) - 1:
        at, before, after = cleaned[n][0], _beside(cleaned, n, -1, last), _beside(cleaned, n, 1, len(cleaned) - 1)
        if _leads_back(before, at, after):
            ahead = _ahead(cleaned, n, (at[0] - before[0], at[1] - before[1]))
            if ahead is None or not _overlaps(cleaned, last, n, ahead, tolerance):
                last = n
                tips.append(cleaned[n][1])
            else:
                del cleaned[n + 1:ahead]
        n += 1
    return cleaned, tips


def _beside(points: Sequence[tuple[Point, int]], n: int, step: int, end: int) -> Point:
    """Return the first point at least _REACH along a polyline from a point, forwards or backwards; or its end."""
    way = 0.0
    while n != end and way < _REACH:
        way += dist(points[n][0], points[n + step][0])
        n += step
    return points[n][0]


def _ahead(points: Sequence[tuple[Point, int]], n: int, direction: Point) -> int | None:
    """Return the number of the first point ahead of a point where the path overlaps; None if it leads away."""
    (x, y), dx, dy = points[n][0], *direction
    for number in range(n + 1, len(points)):
        away = points[number][0][0] - x, points[number][0][1] - y
        if hypot(*away) > _OVERLAP:
            break
        if away[0] * dx + away[1] * dy > 0.0:
            return number
    return None


def _overlaps(points: Sequence[tuple[Point, int]], last: int, n: int, ahead: int, tolerance: float) -> bool:
    """Return whether the points between two lie near to the path before the first of them, or to its way on."""
    back = [point for point, _ in points[max(last, n - _MOST_BACK):n + 1]][::-1]
    on = [points[n][0], points[ahead][0]]
    return all(min(nearest(way, point, _OVERLAP)[1] for way in (back, on)) <= tolerance
               for point, _ in points[n + 1:ahead])


def _within(points: Floats, closed: bool, tolerance: float) -> tuple[Floats, _Polyline]:
    """Return control points of a path within a tolerance of a polyline [m], and the polyline."""
    knot = min(DENSE, _KNOTS * tolerance)
    while True:
        line = _sampled(points, knot)
        stiffness = np.full(line.spans, _STIFFNESS)
        for _ in range(_TRIES):
            control, distance = _fit(line, stiffness, closed)
            far = distance > _WITHIN * tolerance
            if not far.any():
                return control, line
            spans = np.minimum(line.at[far].astype(int), line.spans - 1)
            for beside in (-1, 0, 1):
                near = (spans + beside) % line.spans if closed else np.clip(spans + beside, 0, line.spans - 1)
                stiffness[np.unique(near)] *= 0.5
        if knot < _FINEST * tolerance:
            return control, line
        knot *= 0.5


def _lengths(vectors: Floats) -> Floats:
    """Return the lengths of vectors, shape (n, 2)."""
    found: Floats = np.sqrt(vectors[:, 0] * vectors[:, 0] + vectors[:, 1] * vectors[:, 1])
    return found


def _sampled(points: Floats, knot: float) -> _Polyline:
    """Return a polyline with knots at most about so far apart [m]."""
    steps = _lengths(points[1:] - points[:-1])
    lengths = np.array(list(accumulate(steps.tolist(), initial=0.0)))
    parts = np.maximum(1, np.ceil(steps * (_SAMPLES / knot) - 1e-9)).astype(int)
    leg = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(leg)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[leg]
    samples = points[leg] + share[:, None] * (points[leg + 1] - points[leg])
    count = max(_LEAST, round(float(lengths[-1]) / knot))
    scale = count / lengths[-1]
    return _Polyline(lengths * scale, np.concatenate([samples, points[-1:]]),
                     np.append(lengths[leg] + share * steps[leg], lengths[-1]) * scale, count, float(lengths[-1]))


def _basis(u: Floats) -> Floats:
    """Return the weights of four control points at u in [0, 1] of a span, shape (4, n)."""
    v = 1.0 - u
    return np.stack([v * v * v, (3.0 * u - 6.0) * u * u + 4.0, (3.0 * v - 6.0) * v * v + 4.0, u * u * u]) / 6.0


def _fit(line: _Polyline, stiffness: Floats, closed: bool) -> tuple[Floats, Floats]:
    """Return the control points of the path for λ in each span, and its distance at each sample [m]."""
    sides = math.ceil(_AROUND / line.length) if closed else 0
    laps, count = 2 * sides + 1, line.spans
    at = np.concatenate([line.at[:-1] + count * lap for lap in range(laps)] + [line.at[-1:] + count * (laps - 1)])
    target = np.concatenate([line.samples[:-1]] * laps + [line.samples[-1:]])
    total = laps * count
    span = np.minimum(at.astype(int), total - 1)
    basis = _basis(at - span)
    steps = np.diff(at)
    weights = 0.5 * (np.append(0.0, steps) + np.append(steps, 0.0))
    bands = _Bands(total, target[0], target[-1])
    bands.add(span, basis, weights, target)
    every, lam = np.arange(total), np.tile(stiffness, laps)
    for u in _GAUSS:
        bent = np.array([1.0 - u, 3.0 * u - 2.0, 1.0 - 3.0 * u, u])
        bands.add(every, np.repeat(bent[:, None], total, axis=1), 0.5 * lam, np.zeros((total, 2)))
    inner = bands.solved()
    first, last = target[:1], target[-1:]
    control = np.concatenate([2.0 * first - inner[:1], first, inner, last, 2.0 * last - inner[-1:]])
    path = sum(basis[part][:, None] * control[span + part] for part in range(4))
    distance = _lengths(path - target)
    if not closed:
        return control[1:-1], distance
    begin, samples = sides * count, len(line.at) - 1
    return control[1 + begin:1 + begin + count], distance[sides * samples:(sides + 1) * samples + 1]


class _Bands:
    """
    The normal equations of the control points between the ends of an open spline, which begins and ends straight.

    Parameters
    ----------
    count : int
        Spans of the spline.
    first, last : array of float, shape (2,)
        Its ends [m].

    """

    def __init__(self, count: int, first: Floats, last: Floats) -> None:
        self._count, self._ends = count, (first, last)
        self._diagonals, self._right = np.zeros((4, count - 1)), np.zeros((2, count - 1))

    def add(self, span: Whole, basis: Floats, weights: Floats, target: Floats) -> None:
        """Add the squares of weighted sums of each span's four control points, shape (4, n), and their targets."""
        basis, target = basis.copy(), target.copy()
        for end, (outer, inner, free), spans in (
                (self._ends[0], (0, 1, 2), (0, 1)), (self._ends[1], (3, 2, 1), (self._count - 1, self._count - 2))):
            # beyond an end lies its mirror: the control point 2 end - free
            at = span == spans[0]
            target[at] -= (2.0 * basis[outer, at] + basis[inner, at])[:, None] * end
            basis[free, at] -= basis[outer, at]
            basis[outer, at] = basis[inner, at] = 0.0
            beside = span == spans[1]
            target[beside] -= basis[outer, beside][:, None] * end
            basis[outer, beside] = 0.0
        places = [np.clip(span + part - 2, 0, self._count - 2) for part in range(4)]
        for part in range(4):
            weighted = weights * basis[part]
            for axis in (0, 1):
                self._right[axis] += np.bincount(places[part], weighted * target[:, axis], self._count - 1)
            for apart in range(4 - part):
                self._diagonals[apart] += np.bincount(
                    places[part], weighted * basis[part + apart], self._count - 1)

    def solved(self) -> Floats:
        """Return the control points, shape (n, 2), by Cholesky's decomposition."""
        # rows of L from the diagonal to the left, and L z = right
        rows, xs, ys = [(1.0, 0.0, 0.0, 0.0)] * 3, [0.0] * 3, [0.0] * 3
        near, far, farther = [0.0] * 3, [0.0] * 3, [0.0] * 3
        for d0, d1, d2, d3, x, y in zip(*self._diagonals.tolist(), *self._right.tolist(), strict=True):
            (a0, a1, a2, _), (b0, b1, _, _), (c0, _, _, _) = rows[-1], rows[-2], rows[-3]
            l3 = farther[-3] / c0
            l2 = (far[-2] - l3 * b1) / b0
            l1 = (near[-1] - l3 * a2 - l2 * a1) / a0
            l0 = math.sqrt(d0 - l3 * l3 - l2 * l2 - l1 * l1)
            rows.append((l0, l1, l2, l3))
            xs.append((x - l3 * xs[-3] - l2 * xs[-2] - l1 * xs[-1]) / l0)
            ys.append((y - l3 * ys[-3] - l2 * ys[-2] - l1 * ys[-1]) / l0)
            near.append(d1)
            far.append(d2)
            farther.append(d3)
        rows += [(1.0, 0.0, 0.0, 0.0)] * 3
        solution = [(0.0, 0.0)] * 3
        for n in range(len(xs) - 1, 2, -1):
            (l0, *_), (_, a1, _, _), (_, _, b2, _), (_, _, _, c3) = rows[n:n + 4]
            (ax, ay), (bx, by), (cx, cy) = solution[-1], solution[-2], solution[-3]
            solution.append(((xs[n] - a1 * ax - b2 * bx - c3 * cx) / l0, (ys[n] - a1 * ay - b2 * by - c3 * cy) / l0))
        return np.array(solution[:2:-1])


def _far(
    points: Sequence[Point], numbers: Whole, control: Floats, line: _Polyline, closed: bool, tolerance: float
) -> list[tuple[int, int]]:
    """Return the numbers of the points that may be farther than the tolerance from a path, and of spans near them."""
    path = np.array([span.at(part / _CHECKED)[:2] for span in spans_of(control.tolist(), closed)
                     for part in range(_CHECKED)])
    # near the mean that stands for the point
    mean = np.searchsorted(numbers, np.arange(len(points)), side='right') - 1
    middle = np.round(line.knots[mean] * _CHECKED).astype(int)
    beside = np.full(len(points), np.inf)
    targets = np.array(points)
    for step in range(-2 * _CHECKED, 2 * _CHECKED + 1):
        at = (middle + step) % len(path) if closed else np.clip(middle + step, 0, len(path) - 1)
        beside = np.minimum(beside, _lengths(path[at] - targets))
    return [(n, int(middle[n]) // _CHECKED) for n in np.flatnonzero(~(beside <= tolerance)).tolist()]


def _refuse_misses(
    points: Sequence[Point], far: Sequence[tuple[int, int]], control: Sequence[Point], closed: bool, tolerance: float
) -> None:
    """Raise MissedError if one of some points, each near a span of a path, is farther than the tolerance from it."""
    spans = spans_of(control, closed)
    for number, span in far:
        near = [spans[n % len(spans)] for n in range(span - _BESIDE, span + _BESIDE)
                if closed or 0 <= n < len(spans)]
        way = [one.at(part / _FINE)[:2] for one in near for part in range(_FINE + 1)]
        distance = nearest(way, points[number], math.inf)[1]
        if distance > tolerance + _ROUNDED:
            raise MissedError(number, distance)
