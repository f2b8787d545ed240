"""The map of a study: where the robot started, coloured by how the run went."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mobile_robot_control.quantities import Pose

# Okabe and Ito's colours, told apart by everybody
_SUCCESS, _FAILURE = '#0072B2', '#D55E00'
_ARROW = 0.06


class Start(NamedTuple):
    """
    One run.

    Attributes
    ----------
    offset : Pose
        Of the start from the cart's.
    success : bool
        How it went.

    """

    offset: Pose
    success: bool


def draw_starts_map(controllers: Mapping[str, Sequence[Start]], file: Path) -> None:
    """
    Draw a map for each controller.

    Parameters
    ----------
    controllers : mapping of str to sequence of Start
        By title.
    file : Path
        PNG or SVG, by its ending.

    """
    figure = Figure(figsize=(4.6 * len(controllers) + 0.6, 5.6), layout='constrained')
    panels = figure.subplots(1, len(controllers), squeeze=False, sharex=True, sharey=True)[0]
    for axes, (title, starts) in zip(panels, controllers.items(), strict=True):
        for success, color, label, size in ((True, _SUCCESS, 'success', 4.0), (False, _FAILURE, 'failure', 16.0)):
            chosen = [start.offset for start in starts if start.success is success]
            axes.scatter([offset.x for offset in chosen], [offset.y for offset in chosen], s=size, color=color,
                         label=label, linewidths=0.0, zorder=1 + (not success))
        failed = [start.offset for start in starts if not start.success]
        _draw_headings(axes, failed)
        axes.plot(0.0, 0.0, '+', color='black', markersize=10.0)
        axes.set_title(title)
        axes.set_xlabel("x from the cart's start [m]")
        axes.set_aspect('equal')
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("y from the cart's start [m]")
    figure.legend(*panels[0].get_legend_handles_labels(), loc='outside lower center', ncols=2, frameon=False)
    figure.savefig(file, dpi=120)


def _draw_headings(axes: Axes, offsets: Sequence[Pose]) -> None:
    """Show which way the robot looked where it failed."""
    for x, y, heading in offsets:
        axes.plot([x, x + _ARROW * math.cos(heading)], [y, y + _ARROW * math.sin(heading)], color=_FAILURE,
                  linewidth=0.8)
