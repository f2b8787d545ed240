"""One quantity over time, as figures draw it."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]
_BUCKETS = 1200
"""A line needs no more points than twice this: a figure is about as many pixels wide."""


class Line(NamedTuple):
    """
    One quantity over time.

    Attributes
    ----------
    time, value : array, shape (n,)
        [s], and the quantity's unit.

    """

    time: Floats
    value: Floats


def broken_at_jumps(line: Line) -> Line:
    """
    Break the line of a wrapped angle where it jumps.

    Parameters
    ----------
    line : Line
        [rad] in (-π, π].

    Returns
    -------
    Line
        With a nan in each jump, where nothing is drawn.

    """
    jumps = np.nonzero(np.abs(np.diff(line.value)) > np.pi)[0] + 1
    return Line(np.insert(line.time, jumps, line.time[jumps]), np.insert(line.value, jumps, np.nan))


def thinned(line: Line) -> Line:
    """
    Leave out points that no picture could show.

    Parameters
    ----------
    line : Line
        Any number of points.

    Returns
    -------
    Line
        Of each bucket of points the smallest and the largest value, in order of time, so that no peak is lost; a
        short line as it is.

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
    """Find the place of the smallest value of each bucket."""
    ends = np.append(edges[1:], values.size)
    return np.array([start + np.argmin(values[start:end]) for start, end in zip(edges, ends, strict=True)])
