"""Figures of the plane: paths and poses of runs, and the reference."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mobile_robot_control.reporting.lines import Floats
from mobile_robot_control.reporting.palette import GREY, LINES, line_widths, style
from mobile_robot_control.reporting.panels import WIDTH, Named, legend
from mobile_robot_control.reporting.series import Series


def triangle(pose: Sequence[float] | Floats, size: float) -> Floats:
    """
    Return the corners [m], shape (3, 2), of a triangle of a length [m] that points ahead.

    The pose is x, y [m] and heading [rad]; its point lies within the triangle.
    """
    x, y, heading = pose
    corners = np.array([[0.7, 0.0], [-0.3, 0.33], [-0.3, -0.33]]) * size
    cos, sin = np.cos(heading), np.sin(heading)
    turned: Floats = corners @ np.array([[cos, sin], [-sin, cos]]) + [x, y]
    return turned


def draw_pose(axes: Axes, pose: tuple[float, float, float], size: float, color: str, **options: Any) -> None:
    """
    Draw the robot at a pose, as a triangle that points ahead.

    Parameters
    ----------
    axes : Axes
        Of the plane.
    pose : tuple of float
        x, y [m] and heading [rad].
    size : float
        Length [m].
    color : str
        Of its edge.
    **options : object
        For the patch.
    """
    corners = triangle(pose, size)
    axes.fill(corners[:, 0], corners[:, 1], facecolor='none', edgecolor=color, linewidth=1.1, **options)


def path_on(axes: Axes, runs: Sequence[Named], poses: int = 14) -> None:
    """
    Draw paths and poses on axes of the plane.

    Parameters
    ----------
    axes : Axes
        Empty.
    runs : sequence of Named
        Overlaid.
    poses : int
        Poses along the path of a single run, evenly in time; of several runs only the first pose of each is drawn.
    """
    reference_drawn = False
    widths = line_widths(len(runs))
    for (name, series), (color, dashes), width in zip(runs, LINES, widths, strict=False):
        if not reference_drawn:
            reference_drawn = _plane(axes, series, 'reference', color=GREY, linewidth=widths[0] + 2.0,
                                     label='reference')
        shown = _plane(axes, series, series.motion, color=color, linestyle=dashes, linewidth=width,
                       label=name if len(runs) > 1 else 'robot' if series.motion == 'odom' else 'robot, true')
        if series.motion != 'odom':
            _plane(axes, series, 'odom', color=color, linewidth=0.8, alpha=0.6, zorder=1.9,
                   label='_' if len(runs) > 1 else 'robot, by odometry')
        if shown:
            _poses(axes, series, color, poses if len(runs) == 1 else 1)
    axes.set_aspect('equal', adjustable='datalim')
    axes.set_xlabel('x [m]')
    axes.set_ylabel('y [m]')
    if not axes.lines:
        axes.text(0.5, 0.5, 'not recorded', transform=axes.transAxes, ha='center', va='center', color=GREY)
    legend(axes)


def _plane(axes: Axes, series: Series, topic: str, **options: Any) -> bool:
    """Draw the path of a topic; return whether it has any points."""
    x, y = series.line(topic, 'x'), series.line(topic, 'y')
    if not x.value.size:
        return False
    chosen = _even(x.value.size, 3000)
    axes.plot(x.value[chosen], y.value[chosen], **options)
    return True


def _even(count: int, most: int) -> NDArray[np.int_]:
    """Return evenly spaced indices, first and last included."""
    return np.linspace(0, count - 1, min(count, most)).astype(np.int_)


def _poses(axes: Axes, series: Series, color: str, count: int) -> None:
    """Draw poses evenly in time, and a dot at the start."""
    x, y, heading = (series.line(series.motion, name).value for name in ('x', 'y', 'heading'))
    size = 0.075 * max(float(np.ptp(x)), float(np.ptp(y)), 0.1)
    for n in _even(x.size, count + 1)[:count]:
        draw_pose(axes, (x[n], y[n], heading[n]), size, color)
    axes.plot(x[0], y[0], 'o', color=color, markersize=4.0, label='_' if count == 1 else 'start')


def draw_path(runs: Sequence[Named]) -> Figure | None:
    """Draw paths, reference and poses of runs, overlaid, both axes to the same scale; None where there are none."""
    if not any(run.series.time(topic).size for run in runs for topic in ('odom', 'reference')):
        return None
    with style():
        figure = Figure(figsize=(WIDTH, 4.6), layout='constrained')
        path_on(figure.subplots(), runs)
    return figure
