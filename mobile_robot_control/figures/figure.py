"""Figures as data: panels of lines and marks with their units. A page draws them live, `drawing` draws them still."""

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


WIDTH = 5.6
"""[in]: width of a figure on a page, so that its text is as large as that of the page."""
REFERENCE, VALUE, COMMAND, SEEN, DIFFERENCE, MEAN, BEST = (
    'reference', 'value', 'command', 'seen', 'difference', 'mean', 'best')
"""Kinds of curves: of the cart, of a run, dotted over it, thin beside it, a run minus the first; and of a search."""


class Trace(NamedTuple):
    """
    One line of a panel.

    Attributes
    ----------
    kind : str
        One of the kinds above; it determines the look.
    run : int
        Index of its run, from 0.
    name : str
        In the legend of a single run; several runs are distinguished by their own names.
    line : Line
        Points from left to right; in a plane from the first to the last.
    thinned_from : int
        Number of points before the line was thinned; 0 for a complete line.

    """

    kind: str
    run: int
    name: str
    line: Line
    thinned_from: int = 0


class RobotMark(NamedTuple):
    """A robot at x, y [m] and heading [rad] in a plane, of a run."""

    run: int
    x: float
    y: float
    heading: float


class Marks(NamedTuple):
    """
    Places in a plane with a common property.

    Attributes
    ----------
    name : str
        In the legend.
    marker : str
        Matplotlib's name.
    size : float
        [points²].
    run : int
        Index of the run whose colour they have.
    places : array of float, shape (n, 3)
        x, y [m] and heading [rad].
    with_headings : bool
        Whether headings are drawn.

    """

    name: str
    marker: str
    size: float
    run: int
    places: Floats
    with_headings: bool = False


class Panel(NamedTuple):
    """
    One pair of axes.

    Attributes
    ----------
    name : str
        Within the figure.
    label, unit : str
        Of the vertical axis; '' without a unit.
    curves : tuple of Trace
        From back to front.
    over : str
        Quantity of the horizontal axis, with its unit.
    bend : float
        Value beyond which the scale is logarithmic; 0 for a linear scale.
    limits : tuple of (int, float)
        Limits of the quantity, each with its run.
    span : tuple of float or None
        First and last value of the horizontal axis; all if None.
    logarithmic : bool
        Whether the vertical axis is logarithmic.
    from_zero : bool
        Whether the vertical axis begins at 0.
    in_plane : bool
        Whether both axes are those of the plane, to the same scale.
    poses, marks : tuple
        In a plane.
    circle : float
        Radius of a circle about the origin [m]; 0 for none.
    title : str
        Above the panel.

    """

    name: str
    label: str
    unit: str
    curves: tuple[Trace, ...]
    over: str = 'time [s]'
    bend: float = 0.0
    limits: tuple[tuple[int, float], ...] = ()
    span: tuple[float, float] | None = None
    logarithmic: bool = False
    from_zero: bool = False
    in_plane: bool = False
    poses: tuple[RobotMark, ...] = ()
    marks: tuple[Marks, ...] = ()
    circle: float = 0.0
    title: str = ''

    @property
    def quantity(self) -> str:
        """Label and unit."""
        return f'{self.label} [{self.unit}]' if self.unit else self.label


class Figure(NamedTuple):
    """
    A figure.

    Attributes
    ----------
    name : str
        Of its files, and of its place on a page.
    title, caption : str
        Above and below it on a page.
    runs : tuple of str
        Names of the runs, at most as many as there are colours.
    panels : tuple of Panel
        From top to bottom.
    height : float
        [in].
    width : float
        [in].
    rows : sequence of sequence of str, or None
        Names of panels in their layout; one below the other if None.
    ratio : float
        Width of the second column over that of the first, for panels in two columns.
    heading : str
        Above the picture itself.

    """

    name: str
    title: str
    caption: str
    runs: tuple[str, ...]
    panels: tuple[Panel, ...]
    height: float
    width: float = WIDTH
    rows: Sequence[Sequence[str]] | None = None
    ratio: float = 1.1
    heading: str = ''


def plane(name: str, curves: Sequence[Trace], poses: Sequence[RobotMark] = (), title: str = '') -> Panel:
    """Return a panel of the plane."""
    return Panel(name, 'y', 'm', tuple(curves), 'x [m]', in_plane=True, poses=tuple(poses), title=title)


def is_drawn(line: Line) -> bool:
    """Return whether a line has a point."""
    return bool(np.isfinite(line.value).any())
