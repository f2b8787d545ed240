"""Figures of one or several runs, made of panels over time."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mobile_robot_control.reporting.lines import Line, thinned
from mobile_robot_control.reporting.palette import FAINT, GREY, INK, LINES, line_widths, style
from mobile_robot_control.reporting.series import Series
from mobile_robot_control.reporting.spikes import ordinary_size, stretch
from mobile_robot_control.system.texts import printable

WIDTH = 5.6
"""[in]: as wide as a page shows a figure, so that its text is as large as that of the page."""
_LONGEST = 44
"""Characters of a name in a legend."""
_ROOM, _HANDLE, _LETTER = 4.8, 0.62, 0.085
"""[in]: width of the axes, of a line in the legend, and of a character."""


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
        Returns the line of a law's command, or of whatever else is compared with the first, drawn dotted over it.
    logarithmic : bool
        Whether to use a symmetric logarithmic scale where a few peaks are much larger than everything else.
    labels : tuple of str
        Of the first line and of the dotted one in the legend of a single run.
    """

    label: str
    value: Callable[[Series], Line]
    reference: Callable[[Series], Line] | None = None
    command: Callable[[Series], Line] | None = None
    logarithmic: bool = False
    labels: tuple[str, str] = ('measured', 'commanded')

    def has_lines(self, runs: Sequence[Named]) -> bool:
        """Return whether any of the runs has something to draw."""
        lines = [line for line in (self.value, self.reference, self.command) if line]
        return any(bool(np.isfinite(line(run.series).value).any()) for line in lines for run in runs)


def _plot(axes: Axes, line: Line, **options: Any) -> bool:
    """Draw a line if it has any points; return whether it has."""
    shown = thinned(line)
    if shown.time.size:
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
    widths = line_widths(len(runs))
    for (name, series), (color, dashes), width in zip(runs, LINES, widths, strict=False):
        if panel.reference and not reference_drawn:
            reference_drawn = _plot(axes, panel.reference(series), color=GREY, linewidth=widths[0] + 2.0,
                                    label='reference')
        dotted = panel.command(series) if panel.command else Line(np.zeros(0), np.zeros(0))
        label = (name if len(runs) > 1 else panel.labels[0] if dotted.time.size else
                 'robot' if panel.reference else '_')
        drawn |= _plot(axes, panel.value(series), color=color, linestyle=dashes, linewidth=width, label=label)
        command_drawn |= _plot(axes, dotted, color=INK, linewidth=1.1, linestyle=(0, (1, 2)),
                               label='_' if command_drawn else panel.labels[1])
    axes.set_ylabel(panel.label)
    axes.margins(x=0.02)
    if span:
        axes.set_xlim(*span)
    ordinary = ordinary_size([panel.value(run.series) for run in runs]) if panel.logarithmic else 0.0
    if ordinary:
        stretch(axes, ordinary)
        axes.set_ylabel(f'{panel.label},\nlogarithmic scale')
    elif drawn:
        axes.axhline(0.0, color=FAINT, linewidth=1.0, zorder=0.5)
    if not drawn:
        axes.text(0.5, 0.5, 'not recorded', transform=axes.transAxes, ha='center', va='center', color=GREY)


def draw_panels(panels: Sequence[Panel], runs: Sequence[Named], height: float = 1.75) -> Figure | None:
    """Draw those panels over time for which any run has something to draw, as `over_time`; None if there are none."""
    shown = [panel for panel in panels if panel.has_lines(runs)]
    return over_time(shown, runs, height=height) if shown else None


def legend(axes: Axes, columns: int = 4, others: Sequence[Axes] = ()) -> None:
    """
    Draw the legend above the axes, where no line can be, with at most so many columns; none without labels.

    It has the labels of other axes too, each once.
    """
    found: dict[str, Any] = {}
    for one in (axes, *others):
        for handle, label in zip(*one.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    handles, labels = list(found.values()), list(found)
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
        legend(rows[0], others=list(rows[1:]))
        rows[-1].set_xlabel('time [s]')
        figure.align_ylabels(list(rows))
    return figure
