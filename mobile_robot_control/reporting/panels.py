"""Figures of one or several runs, made of panels over time."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mobile_robot_control.reporting.lines import Line, thinned
from mobile_robot_control.reporting.palette import FAINT, GREY, INK, LINES, style
from mobile_robot_control.reporting.series import Series
from mobile_robot_control.texts import printable

WIDTH = 5.6
"""[in]: as wide as a page shows a figure, so that its text is as large as that of the page."""
_LONGEST = 44
"""Characters of a name in a legend."""
_ROOM, _HANDLE, _LETTER = 4.8, 0.62, 0.085
"""[in]: width of the axes, of a line in the legend, and of a character."""
_SPIKE = 25.0
"""A peak this many times larger than 98 % of the values would make all others look flat."""


class Named(NamedTuple):
    """A run and its name in legends, which may contain formulas: see `plain`."""

    name: str
    series: Series


def plain(text: str) -> str:
    r"""
    Return a text from elsewhere as a label that Matplotlib shows as it is.

    Between dollars Matplotlib reads a formula, and it leaves labels that are empty or begin with '_' out of legends.

    Examples
    --------
    >>> print(plain('$x'), plain('_private'))
    \$x  _private

    """
    shown = printable(text).replace('$', r'\$')
    return f' {shown}' if not shown or shown.startswith('_') else shown


class Panel(NamedTuple):
    """
    One pair of axes over time.

    Attributes
    ----------
    label : str
        Quantity and unit.
    value : callable
        Returns the line of a run.
    reference : callable or None
        Returns the line of the reference, drawn grey under the others.
    command : callable or None
        Returns the line of a law's command, drawn dotted over the others.
    logarithmic : bool
        Whether to use a symmetric logarithmic scale where a few peaks are much larger than everything else.
    """

    label: str
    value: Callable[[Series], Line]
    reference: Callable[[Series], Line] | None = None
    command: Callable[[Series], Line] | None = None
    logarithmic: bool = False


def _spiky(lines: Sequence[Line]) -> float:
    """Return the 98 % quantile of the absolute values where a peak is much larger, otherwise 0."""
    values = np.abs(np.concatenate([line.value for line in lines]))
    if values.size < 100:  # too few for a quantile
        return 0.0
    ordinary = float(np.quantile(values, 0.98))
    return ordinary if ordinary > 0.0 and float(values.max()) > _SPIKE * ordinary else 0.0


def _plot(axes: Axes, line: Line, **options: Any) -> bool:
    """Draw a line; return whether it has any points."""
    shown = thinned(line)
    axes.plot(shown.time, shown.value, **options)
    return bool(shown.time.size)


def panel_on(axes: Axes, panel: Panel, runs: Sequence[Named], span: tuple[float, float] | None) -> None:
    """
    Draw a panel on axes.

    Parameters
    ----------
    axes : Axes
        Empty.
    panel : Panel
        Its content.
    runs : sequence of Named
        Overlaid.
    span : tuple of float or None
        First and last time to show [s]; all if None.
    """
    drawn = reference_drawn = command_drawn = False
    for (name, series), (color, dashes) in zip(runs, LINES, strict=False):
        if panel.reference and not reference_drawn:
            reference_drawn = _plot(axes, panel.reference(series), color=GREY, linewidth=3.5, label='reference')
        label = name if len(runs) > 1 else 'measured' if panel.command else 'robot' if panel.reference else '_'
        drawn |= _plot(axes, panel.value(series), color=color, linestyle=dashes, label=label)
        if panel.command:
            command_drawn |= _plot(axes, panel.command(series), color=INK, linewidth=1.1, linestyle=(0, (1, 2)),
                                   label='_' if command_drawn else 'commanded')
    axes.set_ylabel(panel.label)
    axes.margins(x=0.02)
    if span:
        axes.set_xlim(*span)
    ordinary = _spiky([panel.value(run.series) for run in runs]) if panel.logarithmic else 0.0
    if ordinary:
        _stretch(axes, ordinary)
        axes.set_ylabel(f'{panel.label},\nlogarithmic scale')
    elif drawn:
        axes.axhline(0.0, color=FAINT, linewidth=1.0, zorder=0.5)
    if not drawn:
        axes.text(0.5, 0.5, 'not recorded', transform=axes.transAxes, ha='center', va='center', color=GREY)


def _stretch(axes: Axes, ordinary: float) -> None:
    """Make the scale logarithmic beyond the ordinary values, with a tick at every decade or every few."""
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


def legend(axes: Axes, columns: int = 4) -> None:
    """Draw the legend above the axes, where no line can be, with at most so many columns; none without labels."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        labels = [label if len(label) <= _LONGEST else f'{label[:_LONGEST - 1]}…' for label in labels]
        # as many in a row as fit: a legend wider than the figure would narrow the axes
        room = int(_ROOM / (_HANDLE + _LETTER * max(map(len, labels))))
        axes.legend(handles, labels, loc='lower left', bbox_to_anchor=(0.0, 1.0), ncols=max(1, min(columns, room)),
                    borderaxespad=0.2, handlelength=2.6, columnspacing=1.4, handletextpad=0.5)


def over_time(
    panels: Sequence[Panel], runs: Sequence[Named], span: tuple[float, float] | None = None, height: float = 1.75
) -> Figure:
    """
    Draw panels one below the other over the same time, with one legend above the first.

    Parameters
    ----------
    panels : sequence of Panel
        From top to bottom.
    runs : sequence of Named
        Overlaid; at most as many as there are LINES.
    span : tuple of float or None
        First and last time to show [s]; all if None.
    height : float
        Of a panel [in].
    """
    with style():
        figure = Figure(figsize=(WIDTH, 0.65 + height * len(panels)), layout='constrained')
        rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axes, panel in zip(rows, panels, strict=True):
            panel_on(axes, panel, runs, span)
        legend(rows[0])
        rows[-1].set_xlabel('time [s]')
        figure.align_ylabels(list(rows))
    return figure
