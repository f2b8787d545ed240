"""Lines of a figure: one quantity over time, thinned to what a picture can show."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]
_BUCKETS = 1200
"""A line has at most about twice as many points; a figure is fewer pixels wide."""


class Line(NamedTuple):
    """One quantity over time [s]: two arrays of shape (n,)."""

    time: Floats
    value: Floats


def broken_at_jumps(line: Line) -> Line:
    """Return the line of an angle in (-π, π] [rad] with a NaN in each jump, so that no line is drawn across it."""
    jumps = np.nonzero(np.abs(np.diff(line.value)) > np.pi)[0] + 1
    return Line(np.insert(line.time, jumps, line.time[jumps]), np.insert(line.value, jumps, np.nan))


def thinned(line: Line) -> Line:
    """
    Return a line without the points that no picture could show.

    A long line is split into buckets of equally many points, and the smallest and the largest value of each stay, in
    order of time, so that no peak is lost. A short line stays as it is.

    Examples
    --------
    >>> thinned(Line(np.arange(1e5), np.sin(np.arange(1e5)))).time.size
    2402

    """
    count = line.time.size
    if count <= 2 * _BUCKETS:
        return line
    broken = np.nonzero(np.isnan(line.value))[0]
    whole = np.where(np.isnan(line.value), 0.0, line.value)
    edges = np.linspace(0, count, _BUCKETS + 1).astype(int)[:-1]
    lowest, highest = (_extremes(whole * sign, edges) for sign in (1.0, -1.0))
    chosen = np.unique(np.concatenate([lowest, highest, broken, [0, count - 1]]))
    return Line(line.time[chosen], line.value[chosen])


def _extremes(values: Floats, edges: NDArray[np.int_]) -> NDArray[np.int_]:
    """Return the index of the smallest value of each bucket."""
    ends = np.append(edges[1:], values.size)
    return np.array([start + np.argmin(values[start:end]) for start, end in zip(edges, ends, strict=True)])
