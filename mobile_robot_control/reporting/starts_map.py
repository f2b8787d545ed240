"""The map of a study: where the robot started, marked by how the run ended, and where most runs fail."""

import math
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from mobile_robot_control.quantities import Pose
from mobile_robot_control.reporting.palette import BLUE, GREY, INK, ORANGE, save, style
from mobile_robot_control.reporting.panels import plain
from mobile_robot_control.tuning.splits import Split

_HEADING_LENGTH = 0.06
"""[m] of the line that shows a heading."""
_MARKS = {'completed': ('o', 16.0, 'failure: too far away'), 'diverged': ('x', 22.0, 'failure: diverged'),
          'law_failed': ('s', 16.0, 'failure of the law')}
"""Marker, its size and its label, by the outcome of a failed run."""
_TITLE_WIDTH = 46
"""Characters."""


class Start(NamedTuple):
    """
    The start of a run and its result.

    Attributes
    ----------
    offset : Pose
        Of the start from the cart's [m], [rad].
    success : bool
        Whether the run succeeded.
    outcome : str
        'completed', 'diverged' or 'law_failed'.
    """

    offset: Pose
    success: bool
    outcome: str = 'completed'


class Starts(NamedTuple):
    """The starts of a controller, and the split of its scenarios that tells best where it fails, if any does."""

    starts: Sequence[Start]
    split: Split | None = None


def draw_starts_map(controllers: Mapping[str, Starts], file: Path) -> str:
    """Draw a map for each controller, by title, as PNG, with an SVG of the same name beside it; return the SVG."""
    with style():
        figure = Figure(figsize=(4.6 * len(controllers) + 0.6, 5.2), layout='compressed')
        panels = figure.subplots(1, len(controllers), squeeze=False, sharex=True, sharey=True)[0]
        labels: dict[str, Any] = {}
        for axes, (title, (starts, split)) in zip(panels, controllers.items(), strict=True):
            _draw_starts(axes, starts)
            axes.set_title('\n'.join([plain(title), *_split_lines(split)]))
            axes.set_xlabel("x from the cart's start [m]")
            if split and split.quantity == 'start_distance' and isinstance(split.value, float):
                axes.add_patch(Circle((0.0, 0.0), split.value, fill=False, color=GREY, linestyle='--'))
            labels |= {label: handle for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
        panels[0].set_ylabel("y from the cart's start [m]")
        figure.legend(labels.values(), labels.keys(), loc='outside lower center', ncols=len(labels))
        # a layout of equal axes needs a drawing before the final one, or titles lie outside
        figure.draw_without_rendering()
        return save(figure, file)


def _split_lines(split: Split | None) -> list[str]:
    """Return where most runs fail, as lines of a title; none where nothing is known."""
    if split is None:
        return []
    (there, drawn), (rest, others) = split.there, split.elsewhere
    return textwrap.wrap(f'{split.words}: {there} of {drawn} fail, elsewhere {rest} of {others}', _TITLE_WIDTH)


def _draw_starts(axes: Axes, starts: Sequence[Start]) -> None:
    """Draw starts as dots, and the heading and the kind of those that failed."""
    shown = [('success', 'o', 6.0, BLUE, [one.offset for one in starts if one.success])]
    failed = [one for one in starts if not one.success]
    shown += [(label, marker, size, ORANGE, [one.offset for one in failed if one.outcome == outcome])
              for outcome, (marker, size, label) in _MARKS.items()]
    for label, marker, size, color, offsets in shown:
        if offsets or color == BLUE:
            axes.scatter([offset.x for offset in offsets], [offset.y for offset in offsets], s=size, color=color,
                         marker=marker, label=label, linewidths=1.2 * (marker == 'x'), zorder=1 + (color == ORANGE))
    for x, y, heading in (start.offset for start in failed):
        axes.plot([x, x + _HEADING_LENGTH * math.cos(heading)], [y, y + _HEADING_LENGTH * math.sin(heading)],
                  color=ORANGE, linewidth=0.8)
    axes.plot(0.0, 0.0, '+', color=INK, markersize=10.0)
    axes.set_aspect('equal')
