"""Figures drawn by Matplotlib: the still pictures of pages and files."""

import io
import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawn
from matplotlib.patches import Circle
from matplotlib.ticker import LogFormatter, MaxNLocator

from mobile_robot_control.figures.figure import (
    BEST,
    COMMAND,
    DIFFERENCE,
    MEAN,
    REFERENCE,
    SEEN,
    VALUE,
    Figure,
    Floats,
    Panel,
    thinned,
)
from mobile_robot_control.figures.palette import BLUE, FAINT, GREY, INK, LINES, line_widths, save, style
from mobile_robot_control.system.texts import printable

_LONGEST = 44
"""Longest name in a legend [characters]."""
_ROOM, _HANDLE, _LETTER = 4.8, 0.62, 0.085
"""[in]: width of the axes, of a line in the legend, and of a character."""
_PLACES_OUTSIDE = [int(part) for part in mpl.__version__.split('.')[:2]] >= [3, 7]
"""Whether Matplotlib reserves room for a legend below the axes: that of Ubuntu 24.04 does not."""
_BELOW = 0.07
"""Share of the height for such a legend otherwise."""
_HEADING_LENGTH = 0.06
"""[m]: length of the line that shows a heading."""


def plain(text: str) -> str:
    r"""
    Return a text from elsewhere as a label that Matplotlib shows unchanged.

    Matplotlib reads a formula between dollars, and omits labels that are empty or begin with '_' from legends.

    Examples
    --------
    >>> print(plain('$x'), plain('_private'))
    \$x  _private

    """
    shown = printable(text).replace('$', r'\$')
    return f' {shown}' if not shown or shown.startswith('_') else shown


def draw(figure: Figure) -> Drawn:
    """
    Draw a figure.

    Panels over time share their axis, and have one legend above the first of them; every other panel has its own.
    """
    with style():
        # panels of marks lie side by side in the same plane, with one legend below
        mapped = any(panel.marks for panel in figure.panels)
        drawn = Drawn(figsize=(figure.width, figure.height), layout='compressed' if mapped else 'constrained')
        rows = figure.rows or [[panel.name] for panel in figure.panels]
        ratios = [1.0, figure.ratio] if len(rows[0]) == 2 and not mapped else None
        places = drawn.subplot_mosaic([list(row) for row in rows], width_ratios=ratios, sharex=mapped, sharey=mapped)
        for panel in figure.panels:
            _draw_panel(places[panel.name], panel, figure.runs)
        over_time = [places[panel.name] for panel in figure.panels if panel.over == 'time [s]']
        for axes in over_time[:-1]:
            axes.sharex(over_time[-1])
            axes.tick_params(labelbottom=False)
            axes.set_xlabel('')
        alone = [places[panel.name] for panel in figure.panels if places[panel.name] not in over_time]
        if over_time:
            legend(over_time[0], others=over_time[1:])
            drawn.align_ylabels(over_time)
        if figure.heading:
            drawn.suptitle(figure.heading)
        if mapped:
            _legend_below(drawn, alone)
        else:
            for axes in alone:
                legend(axes)
    return drawn


def draw_and_save(figure: Figure, file: Path) -> str:
    """Draw a figure as PNG and SVG, with these endings in place of the file's; return the SVG."""
    return save(draw(figure), file)


def shown_in_notebook(drawn: Drawn) -> Drawn:
    """Return a drawn figure that shows itself in a notebook."""
    # without pyplot, a notebook calls only this method
    drawn._repr_png_ = partial(_as_png, drawn)  # type: ignore[attr-defined]
    return drawn


def _as_png(figure: Drawn) -> bytes:
    buffer = io.BytesIO()
    with style():
        figure.savefig(buffer, format='png', dpi=110)
    return buffer.getvalue()


def _draw_panel(axes: Axes, panel: Panel, runs: Sequence[str]) -> None:
    shown = [curve for curve in panel.curves if curve.kind != DIFFERENCE]
    several, widths, labelled = len(runs) > 1, line_widths(len(runs)), set()
    # with a single line there is nothing to distinguish
    alone = not several and len(shown) == 1 and not panel.in_plane
    for curve in shown:
        color, dashes = LINES[curve.run]
        look: dict[str, Any] = {
            REFERENCE: {'color': GREY, 'linewidth': widths[0] + 2.0},
            VALUE: {'color': color, 'linestyle': dashes, 'linewidth': widths[curve.run]},
            COMMAND: {'color': INK, 'linewidth': 1.1, 'linestyle': (0, (1, 2))},
            SEEN: {'color': color, 'linewidth': 0.8, 'alpha': 0.6, 'zorder': 1.9},
            MEAN: {'color': GREY},
            BEST: {'color': BLUE},
        }[curve.kind]
        label = plain(runs[curve.run]) if several and curve.kind == VALUE else curve.name
        if alone or label in labelled or (several and curve.kind == SEEN):
            label = '_'
        labelled |= {label} if curve.kind != VALUE else set()
        line = curve.line if panel.in_plane else thinned(curve.line)
        axes.plot(line.time, line.value, label=label, **look)
    axes.set_xlabel(panel.over)
    axes.set_ylabel(panel.quantity)
    axes.set_title(panel.title, loc='right' if panel.in_plane and not panel.marks else 'center')
    if panel.in_plane:
        _finish_plane(axes, panel)
    else:
        _finish_scale(axes, panel, bool(shown))
    if not shown and not panel.marks:
        axes.text(0.5, 0.5, 'not recorded', transform=axes.transAxes, ha='center', va='center', color=GREY)


def _finish_scale(axes: Axes, panel: Panel, drawn: bool) -> None:
    """Set the scales of a panel other than a plane."""
    if panel.over == 'time [s]':
        axes.margins(x=0.02)
    else:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if panel.span:
        axes.set_xlim(*panel.span)
    if panel.logarithmic:
        axes.set_yscale('log')
        axes.yaxis.set_major_formatter(LogFormatter())
        axes.yaxis.set_minor_formatter(LogFormatter(minor_thresholds=(1.5, 0.5)))
    elif panel.bend:
        _bend(axes, panel.bend)
        axes.set_ylabel(f'{panel.quantity},\nlogarithmic scale')
    elif drawn:
        axes.axhline(0.0, color=FAINT, linewidth=1.0, zorder=0.5)
    if panel.from_zero:
        axes.set_ylim(bottom=0.0)


def _bend(axes: Axes, ordinary: float) -> None:
    """Make the scale logarithmic beyond ordinary values, with ticks at decades."""
    decade = math.ceil(math.log10(ordinary))
    axes.set_yscale('symlog', linthresh=10.0**decade, linscale=1.0)
    lowest, highest = axes.dataLim.intervaly
    lowest, highest = (1.8 * limit if abs(limit) > 10.0**decade else sign * 10.0**decade
                       for limit, sign in ((lowest, -1.0), (highest, 1.0)))
    axes.set_ylim(lowest, highest)
    powers = [10.0**power for power in range(decade, 1 + math.ceil(math.log10(max(highest, -lowest))))]
    step = 1 + len(powers) // 4
    ticks = [0.0, *powers[::step], *(-power for power in powers[::step])]
    axes.set_yticks([tick for tick in ticks if lowest <= tick <= highest])
    axes.minorticks_off()
    axes.yaxis.set_major_formatter(lambda value, _: f'{value:g}')


def _finish_plane(axes: Axes, panel: Panel) -> None:
    """Draw the parts that only a plane has."""
    paths = [curve.line for curve in panel.curves if curve.kind == VALUE]
    for n, pose in enumerate(panel.poses):
        color, _ = LINES[pose.run]
        path = paths[pose.run] if pose.run < len(paths) else paths[0]
        size = 0.075 * max(*(float(np.nanmax(each) - np.nanmin(each)) for each in path), 0.1)
        corners = triangle((pose.x, pose.y, pose.heading), size)
        axes.fill(corners[:, 0], corners[:, 1], facecolor='none', edgecolor=color, linewidth=1.1)
        if n == 0 or pose.run != panel.poses[n - 1].run:
            alone = len({one.run for one in panel.poses}) == 1 and len(panel.poses) > 1
            axes.plot(pose.x, pose.y, 'o', color=color, markersize=4.0, label='start' if alone else '_')
    for mark in panel.marks:
        color, _ = LINES[mark.run]
        x, y, heading = mark.places.T
        axes.scatter(x, y, s=mark.size, color=color, marker=mark.marker, label=mark.name,
                     linewidths=1.2 * (mark.marker == 'x'), zorder=1 + mark.run)
        if mark.with_headings:
            axes.plot([x, x + _HEADING_LENGTH * np.cos(heading)], [y, y + _HEADING_LENGTH * np.sin(heading)],
                      color=color, linewidth=0.8)
    if panel.marks:
        axes.plot(0.0, 0.0, '+', color=INK, markersize=10.0)
    if panel.circle:
        axes.add_patch(Circle((0.0, 0.0), panel.circle, fill=False, color=GREY, linestyle='--'))
    axes.set_aspect('equal', adjustable=None if panel.marks else 'datalim')


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


def legend(axes: Axes, columns: int = 4, others: Sequence[Axes] = ()) -> None:
    """
    Draw the legend above the axes, outside all lines, with at most so many columns; none without labels.

    It includes the labels of other axes, each once.
    """
    entries = _labels((axes, *others))
    handles, labels = list(entries.values()), list(entries)
    if handles:
        labels = [label if len(label) <= _LONGEST else f'{label[:_LONGEST - 1]}…' for label in labels]
        # as many in a row as fit: a legend wider than the figure would narrow the axes
        room = int(_ROOM / (_HANDLE + _LETTER * max(map(len, labels))))
        axes.legend(handles, labels, loc='lower left', bbox_to_anchor=(0.0, 1.0), ncols=max(1, min(columns, room)),
                    borderaxespad=0.2, handlelength=2.6, columnspacing=1.4, handletextpad=0.5)


def _labels(every: Sequence[Axes]) -> dict[str, Any]:
    """Return the legend entries of axes, each label once."""
    entries: dict[str, Any] = {}
    for axes in every:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    return entries


def _legend_below(drawn: Drawn, every: Sequence[Axes]) -> None:
    """Draw one legend of all axes below them."""
    entries = _labels(every)
    if _PLACES_OUTSIDE:
        drawn.legend(entries.values(), entries.keys(), loc='outside lower center', ncols=len(entries))
    else:
        drawn.legend(entries.values(), entries.keys(), loc='lower center', ncol=len(entries))
        layout: Any = drawn.get_layout_engine()
        layout.set(rect=(0.0, _BELOW, 1.0, 1.0 - _BELOW))
    for axes in every[1:]:
        axes.set_ylabel('')
    # a layout of equal axes needs a drawing before the final one, or titles lie outside
    drawn.draw_without_rendering()
