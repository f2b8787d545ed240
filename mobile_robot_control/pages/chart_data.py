"""The data of a page's charts: the lines of figures over time, packed; web/charts.js draws them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mobile_robot_control.figures.figure import Figure, Panel
from mobile_robot_control.figures.lines import Floats, Line
from mobile_robot_control.figures.palette import GREY, INK, LINES, line_widths, on_dark
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.segments import event_text, events_within
from mobile_robot_control.runs.series import Series
from mobile_robot_control.web.assets import pack

_LARGEST = 3.0e38
"""Largest number in a 32-bit float; beyond it a chart has a gap."""
_DASHES = {'-': (), '--': (9, 5), '-.': (9, 4, 2, 4), ':': (2, 4)}
"""[px] of line and gap, in place of Matplotlib's names."""
_PLACES = 4000
"""Most places of the error along the path."""


class _Columns:
    """Packed arrays of numbers, each stored once: runs with one rate have the same times."""

    def __init__(self) -> None:
        self.packed: list[str] = []
        self._places: dict[str, int] = {}

    def add(self, values: Floats) -> int:
        """Add an array unless it is present; return its place."""
        text = pack(np.where(np.abs(values) <= _LARGEST, values, np.nan))
        if text not in self._places:
            self._places[text] = len(self.packed)
            self.packed.append(text)
        return self._places[text]


def _apart(line: Line) -> Line:
    """Return a line with separate times for its gaps, between those of their neighbours."""
    gaps = np.nonzero(np.isnan(line.value))[0]
    if not gaps.size:
        return line
    time = line.time.copy()
    before, after = np.maximum(gaps - 1, 0), np.minimum(gaps + 1, time.size - 1)
    time[gaps] = 0.5 * (line.time[before] + line.time[after])
    return Line(time, line.value)


def _chart(figure: Figure, panel: Panel, columns: _Columns) -> dict[str, Any]:
    lines = []
    for kind, run, name, line, thinned_from in panel.curves:
        shown = _apart(line)
        lines.append({'kind': kind, 'run': run, 'name': name, 'time': columns.add(shown.time),
                      'value': columns.add(shown.value), **({'thinnedFrom': thinned_from} if thinned_from else {})})
    return {
        'figure': figure.name, 'label': panel.label.replace('\n', ' '), 'unit': panel.unit, 'bend': panel.bend,
        'limits': [{'run': n, 'value': limit} for n, limit in panel.limits], 'lines': lines,
    }


def deviation(series: Series) -> dict[str, Floats]:
    """
    Return the path of the cart and the robot's deviation from it, at up to some thousand times, evenly spaced.

    The cart is assumed on straight lines between its messages; before the first and after the last there is nothing.
    The robot's position is the true one if known.

    Returns
    -------
    dict of str to array, shape (n,)
        `time` [s]; `x` and `y` of the cart [m]; `x_error` and `y_error`, the position of the robot minus that of the
        cart [m], in the axes of the odometry frame.

    """
    cart, time = series.time('reference'), series.time(series.motion)
    during = np.nonzero((time >= cart[0]) & (time <= cart[-1]))[0] if cart.size else np.zeros(0, int)
    chosen = during[np.linspace(0, during.size - 1, min(during.size, _PLACES)).astype(int)]
    found = {'time': time[chosen]}
    for axis in 'xy' if chosen.size else '':
        found[axis] = np.interp(time[chosen], cart, series.line('reference', axis).value)
        found[f'{axis}_error'] = series.line(series.motion, axis).value[chosen] - found[axis]
    return found


def _look(color: str) -> dict[str, str]:
    """Return a colour on light and on dark ground."""
    return {'light': color, 'dark': on_dark(color)}


def chart_data(figures: Sequence[Figure], runs: Sequence[Run]) -> dict[str, Any]:
    """
    Return the content of a page's charts, ready for JSON; web/charts.js describes it.

    Parameters
    ----------
    figures : sequence of Figure
        Source of the charts: one for each panel over time.
    runs : sequence of Run
        At least one, with messages.
    """
    columns = _Columns()
    spans = [run.series.span() for run in runs]
    looks = zip(runs, LINES, line_widths(len(runs)), strict=False)
    return {
        'start': min(start for start, _ in spans), 'end': max(end for _, end in spans),
        'runs': [{'name': run.name, **_look(color), 'width': round(1.2 * width, 2),
                  'dash': _DASHES[dashes] if isinstance(dashes, str) else [2 * length for length in dashes[1]]}
                 for run, (color, dashes), width in looks],
        'reference': _look(GREY), 'command': _look(INK),
        'charts': [_chart(figure, panel, columns) for figure in figures for panel in figure.panels
                   if not panel.in_plane],
        'events': [{'run': n, 'time': event.time, 'text': event_text(event)}
                   for n, run in enumerate(runs) for event in events_within(run)],
        'deviation': [{'run': n, **{name: columns.add(values) for name, values in found.items()}}
                      for n, found in enumerate(deviation(run.series) for run in runs) if found['time'].size],
        'columns': columns.packed,
    }
