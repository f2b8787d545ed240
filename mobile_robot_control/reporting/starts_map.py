"""The map of a study: where the robot started, coloured by success or failure."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mobile_robot_control.quantities import Pose
from mobile_robot_control.reporting.palette import BLUE, INK, ORANGE, save, style
from mobile_robot_control.reporting.panels import plain

_HEADING_LENGTH = 0.06
"""[m] of the line that shows a heading."""


class Start(NamedTuple):
    """
    The start of a run and its result.

    Attributes
    ----------
    offset : Pose
        Of the start from the cart's [m], [rad].
    success : bool
        Whether the run succeeded.
    """

    offset: Pose
    success: bool


def draw_starts_map(controllers: Mapping[str, Sequence[Start]], file: Path) -> str:
    """Draw a map for each controller, by title, as PNG, with an SVG of the same name beside it; return the SVG."""
    with style():
        figure = Figure(figsize=(4.6 * len(controllers) + 0.6, 5.2), layout='compressed')
        panels = figure.subplots(1, len(controllers), squeeze=False, sharex=True, sharey=True)[0]
        for axes, (title, starts) in zip(panels, controllers.items(), strict=True):
            _draw_starts(axes, starts)
            axes.set_title(plain(title))
            axes.set_xlabel("x from the cart's start [m]")
        panels[0].set_ylabel("y from the cart's start [m]")
        figure.legend(*panels[0].get_legend_handles_labels(), loc='outside lower center', ncols=2)
        # a layout of equal axes needs a drawing before the final one, or titles lie outside
        figure.draw_without_rendering()
        return save(figure, file)


def _draw_starts(axes: Axes, starts: Sequence[Start]) -> None:
    """Draw starts as dots, and the heading of those that failed."""
    for success, color, label, size in ((True, BLUE, 'success', 6.0), (False, ORANGE, 'failure', 16.0)):
        chosen = [start.offset for start in starts if start.success is success]
        axes.scatter([offset.x for offset in chosen], [offset.y for offset in chosen], s=size, color=color,
                     label=label, linewidths=0.0, zorder=1 + (not success))
    for x, y, heading in (start.offset for start in starts if not start.success):
        axes.plot([x, x + _HEADING_LENGTH * math.cos(heading)], [y, y + _HEADING_LENGTH * math.sin(heading)],
                  color=ORANGE, linewidth=0.8)
    axes.plot(0.0, 0.0, '+', color=INK, markersize=10.0)
    axes.set_aspect('equal')
