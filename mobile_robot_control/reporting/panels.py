"""Figures made of panels over time: the engine of all figures of a run."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mobile_robot_control.reporting.lines import Line, thinned
from mobile_robot_control.reporting.palette import FAINT, GREY, INK, LINES, style
from mobile_robot_control.reporting.series import Series

WIDTH = 5.6
"""[in] of a figure: as wide as a page shows it, so that its text has the page's size."""
_LONGEST = 44
"""Letters of a name in a legend."""
_ROOM, _HANDLE, _LETTER = 4.8, 0.62, 0.085
"""[in]: width of the axes, of a line in the legend, and of a letter."""
_SPIKE = 25.0
"""A peak so many times beyond what the run asks for otherwise would flatten everything else."""


class Named(NamedTuple):
    """
    A run and its name in legends.

    Attributes
    ----------
    name : str
        Short.
    series : Series
        Its topics.

    """

    name: str
    series: Series


class Panel(NamedTuple):
    """
    One pair of axes over time.

    Attributes
    ----------
    label : str
        Quantity and unit.
    value : callable
        Gives a run's line.
    reference : callable or None
        Gives the line that is asked for, drawn grey under the others.
    command : callable or None
        Gives the line that a law asks for, dotted over the others.
    logarithmic : bool
        A few large peaks are shown on a symmetric logarithmic scale.

    """

    label: str
    value: Callable[[Series], Line]
    reference: Callable[[Series], Line] | None = None
    command: Callable[[Series], Line] | None = None
    logarithmic: bool = False


def _spiky(lines: Sequence[Line]) -> float:
    """Give the size of what is ordinary where rare peaks tower above it, else 0."""
    values = np.abs(np.concatenate([line.value for line in lines]))
    if values.size < 100:  # too few to say what is rare
        return 0.0
    ordinary = float(np.quantile(values, 0.98))
    return ordinary if ordinary > 0.0 and float(values.max()) > _SPIKE * ordinary else 0.0


def _plot(axes: Axes, line: Line, **options: Any) -> bool:
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
        What to draw.
    runs : sequence of Named
        Overlaid.
    span : tuple of float or None
        Times to show [s]; all if None.

    """
    drawn = False
    told = {'reference': False, 'command': False}
    for (name, series), (color, dashes) in zip(runs, LINES, strict=False):
        if panel.reference and not told['reference']:
            told['reference'] = _plot(axes, panel.reference(series), color=GREY, linewidth=3.5, label='reference')
        label = name if len(runs) > 1 else 'measured' if panel.command else 'robot' if panel.reference else '_'
        drawn |= _plot(axes, panel.value(series), color=color, linestyle=dashes, label=label)
        if panel.command:
            told['command'] |= _plot(axes, panel.command(series), color=INK, linewidth=1.1, linestyle=(0, (1, 2)),
                                     label='_' if told['command'] else 'commanded')
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
    """Show decades beyond the ordinary, with a tick for every other one."""
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
    """
    Put the legend above the axes, where no line can be.

    Parameters
    ----------
    axes : Axes
        With labelled lines, or without any: then nothing is drawn.
    columns : int
        Entries in a row.

    """
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        labels = [label if len(label) <= _LONGEST else f'{label[:_LONGEST - 1]}…' for label in labels]
        # as many in a row as fit: a legend wider than the figure would press the axes together
        room = int(_ROOM / (_HANDLE + _LETTER * max(map(len, labels))))
        axes.legend(handles, labels, loc='lower left', bbox_to_anchor=(0.0, 1.0), ncols=max(1, min(columns, room)),
                    borderaxespad=0.2, handlelength=2.6, columnspacing=1.4, handletextpad=0.5)


def over_time(
    panels: Sequence[Panel], runs: Sequence[Named], span: tuple[float, float] | None = None, height: float = 1.75
) -> Figure:
    """
    Draw panels one below the other, over the same time.

    Parameters
    ----------
    panels : sequence of Panel
        From top to bottom.
    runs : sequence of Named
        Overlaid; as many as there are LINES at the most.
    span : tuple of float or None
        Times to show [s]; all if None.
    height : float
        Of a panel [in].

    Returns
    -------
    Figure
        With one legend, above the first panel.

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
