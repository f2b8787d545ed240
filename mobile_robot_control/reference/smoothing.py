"""
Smooth curves through samples with rounding errors or noise.

The curve is the uniform cubic B-spline c that minimises Σ w |p(t_i) - q_i|² + λ Σ |Δ⁴c|², with Δ⁴c the fourth
differences of its control points: λ = (wave / 2π h)⁸ halves waves of the length `wave`, h being the distance of two
knots. Of several waves, generalised cross-validation chooses the one that predicts a sample best from the others
(P. Craven and G. Wahba, Smoothing Noisy Data with Spline Functions, 1979).

All sums are in an order of our own, without BLAS or LAPACK, so that every machine finds the same curve.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_DIFFERENCES = (1.0, -4.0, 6.0, -4.0, 1.0)
_PINNED = 1e6
"""Weight of a pin, in those of all samples."""
_RATIO, _WAVES = 1.25, 12
"""Of two waves that are compared, and their number, from the shortest on."""
MOST = 2.0
"""Largest distance of a sample from the curve, as a share of the one aimed at."""
_KNOTS = 4.0
"""Knots in the shortest wave."""
_FINER, _TIMES = 0.4, 4
"""Share of a shorter wave, tried where samples lie too far from the curve, and the number of tries."""


class Pin(NamedTuple):
    """A value that the curve has at a place, or that its derivative has there."""

    at: float
    value: tuple[float, ...]
    is_slope: bool = False


class Spline:
    """
    A uniform cubic B-spline.

    Parameters
    ----------
    control : array of float, shape (n + 3, d)
        Of n spans.
    step : float
        Of its knots, from 0 on.

    """

    def __init__(self, control: Floats, step: float) -> None:
        self.control, self.step = control, step

    @property
    def end(self) -> float:
        """Place of the last knot."""
        return self.step * (len(self.control) - 3)

    def at(self, places: Floats) -> Floats:
        """Return the points at some places, shape (n, d)."""
        return self._sums(places, _basis)

    def slope(self, places: Floats) -> Floats:
        """Return the derivatives at some places, shape (n, d)."""
        return self._sums(places, _slopes) / self.step

    def _sums(self, places: Floats, weights: Callable[[Floats], Floats]) -> Floats:
        span, u = _spans(places, self.step, len(self.control) - 3)
        b = weights(u)
        first, second, third, fourth = (b[part][:, None] * self.control[span + part] for part in range(4))
        total: Floats = ((first + second) + third) + fourth
        return total

    def pinned(self, pins: Sequence[Pin]) -> 'Spline':
        """Return the spline with exactly the values of pins at its ends, which it has nearly."""
        c = self.control.copy()
        for first, sign in ((0, 1.0), (-1, -1.0)):
            at_end = [pin for pin in pins if pin.at == (0.0 if first == 0 else self.end)]
            second, third = (first + int(sign), first + 2 * int(sign))
            for pin in at_end:
                if pin.is_slope:
                    c[first] = c[third] - sign * 2.0 * self.step * np.array(pin.value)
            for pin in at_end:
                if not pin.is_slope:
                    c[second] = (6.0 * np.array(pin.value) - c[first] - c[third]) / 4.0
        return Spline(c, self.step)


def _spans(places: Floats, step: float, count: int) -> tuple[NDArray[np.int64], Floats]:
    """Return the spans of places, and the places in them from 0 to 1."""
    at = places / step
    span = np.clip(at.astype(int), 0, count - 1)
    return span, at - span


def _basis(u: Floats) -> Floats:
    """Return the weights of four control points at u in [0, 1] of a span, shape (4, n)."""
    v = 1.0 - u
    return np.stack([v * v * v, (3.0 * u - 6.0) * u * u + 4.0, (3.0 * v - 6.0) * v * v + 4.0, u * u * u]) / 6.0


def _slopes(u: Floats) -> Floats:
    """Return the derivatives of the weights by u."""
    v = 1.0 - u
    return np.stack([-0.5 * v * v, u * (1.5 * u - 2.0), v * (2.0 - 1.5 * v), 0.5 * u * u])


class Samples(NamedTuple):
    """
    Samples of a curve.

    Attributes
    ----------
    places : array of float, shape (n,)
        Ascending, from 0 to the end of the curve.
    values : array of float, shape (n, d)
        There.
    weights : array of float, shape (n,)
        Of each.

    """

    places: Floats
    values: Floats
    weights: Floats


def shares(places: Floats) -> Floats:
    """Return the share of the way that each of some ascending places stands for, as weights."""
    steps = np.diff(places)
    found: Floats = 0.5 * (np.append(0.0, steps) + np.append(steps, 0.0))
    return found


Misses = Callable[[Spline], Floats]
"""Returns how far a curve misses each sample, as a share of what is allowed."""


def smooth(samples: Samples, shortest: float, pins: Sequence[Pin], misses: Misses, finer: bool = True) -> Spline:
    """
    Return the smooth curve through samples.

    Parameters
    ----------
    samples : Samples
        At least two.
    shortest : float
        Shortest wave; shorter ones are followed only where the samples would else lie too far from the curve.
    pins : sequence of Pin
        Of the curve.
    misses : callable
        How far a curve misses each sample: above 1.0, a shorter wave is chosen; above MOST, one below the shortest.
    finer : bool
        Whether those are tried.

    """
    chosen = _chosen(samples, shortest, pins, misses, True)
    for _ in range(_TIMES if finer else 0):
        if not (misses(chosen) > MOST).any():
            break
        shortest *= _FINER
        chosen = _chosen(samples, shortest, pins, misses, False)
    return chosen


def _chosen(samples: Samples, shortest: float, pins: Sequence[Pin], misses: Misses, predicts: bool) -> Spline:
    """Return the curve of the best of several waves, the shortest one first: by prediction, or of the longest one."""
    end = float(samples.places[-1])
    count = max(4, math.ceil(end * _KNOTS / shortest))
    step = end / count
    ratios = [shortest / (2.0 * math.pi * step)]
    while len(ratios) < _WAVES:
        ratios.append(ratios[-1] * _RATIO)
    scale = float(samples.weights.max())
    stiffness = scale * np.array([_eighth(ratio) for ratio in ratios])
    data, right = _normal(samples, step, count)
    held, more = _normal(_pin_samples(pins, scale * len(samples.places)), step, count)
    splines, traces = _solved(data, data + held, right + more, stiffness)
    total = math.fsum(samples.weights)
    kish = total * total / math.fsum(samples.weights * samples.weights)
    tried = []
    for n, control in enumerate(splines):
        spline = Spline(control, step).pinned(pins)
        away = spline.at(samples.places) - samples.values
        squares = math.fsum((samples.weights[:, None] * away * away).ravel().tolist())
        left = max(1e-6, 1.0 - traces[n] / kish)
        miss = float(misses(spline).max())
        tried.append((miss > 1.0, squares / (left * left) if predicts else miss if miss > 1.0 else -n, -n, spline))
    best: Spline = min(tried, key=lambda one: one[:3])[-1]
    return best


def _eighth(ratio: float) -> float:
    square = ratio * ratio
    return (square * square) * (square * square)


def _pin_samples(pins: Sequence[Pin], weight: float) -> Any:
    return [(pin.at, pin.value, _PINNED * weight, pin.is_slope) for pin in pins]


def _normal(samples: Any, step: float, count: int) -> tuple[Floats, Floats]:
    """Return the five diagonals of the normal equations of samples, or of pins, and their right-hand sides."""
    size = count + 3
    if isinstance(samples, Samples):
        span, u = _spans(samples.places, step, count)
        parts = [(span, _basis(u), samples.weights, samples.values)]
    else:
        parts = []
        for at, value, weight, is_slope in samples:
            span, u = _spans(np.array([at]), step, count)
            basis = _slopes(u) / step if is_slope else _basis(u)
            # in units of the curve, not of its derivative
            parts.append((span, basis, np.array([weight * (step * step if is_slope else 1.0)]), np.array([value])))
    diagonals, right = np.zeros((5, size)), np.zeros((size, 2))
    for span, basis, weights, values in parts:
        for part in range(4):
            weighted = weights * basis[part]
            for axis in range(values.shape[1]):
                right[:, axis] += np.bincount(span + part, weighted * values[:, axis], size)
            for apart in range(4 - part):
                diagonals[apart] += np.bincount(span + part, weighted * basis[part + apart], size)
    return diagonals, right


def _penalty(size: int) -> Floats:
    """Return the five diagonals of the squares of fourth differences."""
    diagonals = np.zeros((5, size))
    for part in range(5):
        for apart in range(5 - part):
            diagonals[apart, part:size - 4 + part] += _DIFFERENCES[part] * _DIFFERENCES[part + apart]
    return diagonals


def _solved(data: Floats, held: Floats, right: Floats, stiffness: Floats) -> tuple[list[Floats], list[float]]:
    """
    Return the control points for each stiffness, and the trace of the matrix that makes values of samples.

    By the decomposition L D Lᵀ of a matrix with nine diagonals, and those of its inverse near the main one (M. F.
    Hutchinson and F. R. de Hoog, Smoothing Noisy Data with Spline Functions, 1985).
    """
    size = held.shape[1]
    matrix = held[:, :, None] + _penalty(size)[:, :, None] * stiffness
    zero: Any = np.zeros(len(stiffness))
    lower, pivots, forward = [(zero,) * 5] * 4, [zero + 1.0] * 4, [(zero, zero)] * 4
    for n in range(size):
        a0, a1, a2, a3, a4 = (matrix[apart, n - apart] if n >= apart else zero for apart in range(5))
        below = lower[-3:]
        c4 = a4
        c3 = a3 - c4 * below[0][1]
        c2 = a2 - c4 * below[1][2] - c3 * below[1][1]
        c1 = a1 - c4 * below[2][3] - c3 * below[2][2] - c2 * below[2][1]
        l1, l2, l3, l4 = c1 / pivots[-1], c2 / pivots[-2], c3 / pivots[-3], c4 / pivots[-4]
        pivots.append(a0 - c4 * l4 - c3 * l3 - c2 * l2 - c1 * l1)
        lower.append((zero, l1, l2, l3, l4))
        (x1, y1), (x2, y2), (x3, y3), (x4, y4) = forward[:-5:-1]
        forward.append((right[n, 0] - l1 * x1 - l2 * x2 - l3 * x3 - l4 * x4,
                        right[n, 1] - l1 * y1 - l2 * y2 - l3 * y3 - l4 * y4))
    lower += [(zero,) * 5] * 4
    inverse, back = [(zero,) * 5] * 4, [(zero, zero)] * 4
    trace = zero
    for n in range(size + 3, 3, -1):
        m1, m2, m3, m4 = (lower[n + apart][apart] for apart in range(1, 5))
        (x1, y1), (x2, y2), (x3, y3), (x4, y4) = back[:-5:-1]
        z1, z2, z3, z4 = inverse[:-5:-1]
        pivot = pivots[n]
        back.append((forward[n][0] / pivot - m1 * x1 - m2 * x2 - m3 * x3 - m4 * x4,
                     forward[n][1] / pivot - m1 * y1 - m2 * y2 - m3 * y3 - m4 * y4))
        i1 = -(m1 * z1[0] + m2 * z1[1] + m3 * z1[2] + m4 * z1[3])
        i2 = -(m1 * z1[1] + m2 * z2[0] + m3 * z2[1] + m4 * z2[2])
        i3 = -(m1 * z1[2] + m2 * z2[1] + m3 * z3[0] + m4 * z3[1])
        i4 = -(m1 * z1[3] + m2 * z2[2] + m3 * z3[1] + m4 * z4[0])
        i0 = 1.0 / pivot - m1 * i1 - m2 * i2 - m3 * i3 - m4 * i4
        inverse.append((i0, i1, i2, i3, i4))
        d0, d1, d2, d3, _ = data[:, n - 4].tolist()
        trace = trace + d0 * i0 + 2.0 * (d1 * i1 + d2 * i2 + d3 * i3)
    points = np.array(back[:3:-1])
    return [points[:, :, n] for n in range(len(stiffness))], trace.tolist()
