"""Lines of a figure: one quantity over time, thinned to the resolution of a picture."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]
_BUCKETS = 600
"""A thinned line has about twice as many points at most; a figure has fewer pixels in width."""
_SPIKE = 25.0
"""A peak so many times larger than 98 % of the values would make all others look flat."""


class Line(NamedTuple):
    """One quantity over time [s]: two arrays of shape (n,)."""

    time: Floats
    value: Floats


def broken_at_jumps(line: Line) -> Line:
    """Return the line of an angle in (-π, π] [rad] with a NaN in each jump, so that no line crosses it."""
    jumps = np.nonzero(np.abs(np.diff(line.value)) > np.pi)[0] + 1
    return Line(np.insert(line.time, jumps, line.time[jumps]), np.insert(line.value, jumps, np.nan))


def thinned(line: Line, buckets: int = _BUCKETS) -> Line:
    """
    Return a line without the points that no picture could show.

    A long line is split into buckets of equally many points. The smallest and the largest value of each stay, in order
    of time, so that no peak is lost; of the NaNs in a bucket, which break the line, the first stays. A line of at most
    two points a bucket is returned unchanged.

    Examples
    --------
    >>> thinned(Line(np.arange(1e5), np.sin(np.arange(1e5)))).time.size
    1202

    """
    count = line.time.size
    if count <= 2 * buckets:
        return line
    edges = np.linspace(0, count, buckets + 1).astype(int)[:-1]
    # rows of equal length: a bucket that is shorter by one repeats its last point
    ends = np.append(edges[1:], count)
    rows = np.minimum(edges[:, np.newaxis] + np.arange(int((ends - edges).max())), ends[:, np.newaxis] - 1)
    values = line.value[rows]
    unknown = np.isnan(values)
    lowest, highest = (np.argmin(np.where(unknown, np.inf, sign * values), axis=1) for sign in (1.0, -1.0))
    every = np.arange(buckets)
    broken = edges[unknown.any(axis=1)] + np.argmax(unknown, axis=1)[unknown.any(axis=1)]
    chosen = np.unique(np.concatenate([rows[every, lowest], rows[every, highest], broken, [0, count - 1]]))
    return Line(line.time[chosen], line.value[chosen])


def ordinary_size(lines: Sequence[Line]) -> float:
    """Return the 98 % quantile of the absolute values if a peak is much larger, otherwise 0."""
    values = np.abs(np.concatenate([line.value for line in lines]))
    if values.size < 100:  # too few for a quantile
        return 0.0
    ordinary = float(np.quantile(values, 0.98))
    return ordinary if ordinary > 0.0 and float(values.max()) > _SPIKE * ordinary else 0.0
