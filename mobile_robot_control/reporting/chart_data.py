"""The numbers of a page's charts: what the figures show over time, thinned and packed; web/charts.js draws them."""

import math
import re
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from mobile_robot_control.reporting.deviation import deviation
from mobile_robot_control.reporting.lines import Floats, Line, thinned
from mobile_robot_control.reporting.palette import GREY, INK, LINES, line_widths, on_dark
from mobile_robot_control.reporting.panels import Panel
from mobile_robot_control.reporting.run_figures import RunFigure
from mobile_robot_control.reporting.run_reading import RecordedRun
from mobile_robot_control.reporting.series import Series
from mobile_robot_control.reporting.spikes import ordinary_size
from mobile_robot_control.web.packing import pack

_BUCKETS, _DIFFERENCE_BUCKETS = 2000, 1000
"""Of a line, and of a difference: each keeps its smallest and its largest value."""
_LARGEST = 3.0e38
"""What a 32-bit float can hold; beyond it a chart has a gap."""
_DASHES = {'-': (), '--': (9, 5), '-.': (9, 4, 2, 4), ':': (2, 4)}
"""[px] of line and gap, in place of Matplotlib's names."""
TORQUE_FIGURE = 'torque'
"""The figure whose charts have the limits of the torque."""


class _Columns:
    """Packed arrays of numbers, each of them once: runs of one rate have the same times."""

    def __init__(self) -> None:
        self.packed: list[str] = []
        self._places: dict[str, int] = {}

    def add(self, values: Floats) -> int:
        """Add an array, unless it is there; return its place."""
        text = pack(np.where(np.abs(values) <= _LARGEST, values, np.nan))
        if text not in self._places:
            self._places[text] = len(self.packed)
            self.packed.append(text)
        return self._places[text]


def torque_limit(run: RecordedRun) -> float | None:
    """Return the smallest limit of a wheel's torque [N m] that a run was configured with; None without any."""
    if run.parameters is None:
        return None
    model = run.parameters.plant.model
    given = (model.max_wheel_torque, model.motor.stall_torque, run.parameters.velocity_controller.max_wheel_torque)
    return min((limit for limit in given if limit > 0.0), default=None)


def difference(line: Line, first: Line) -> Line:
    """
    Return a line minus another one, at its own times; the other one is taken to be straight between its points.

    Examples
    --------
    >>> first = Line(np.array([0.0, 2.0]), np.array([1.0, 3.0]))
    >>> difference(Line(np.array([0.0, 1.0]), np.array([5.0, 5.0])), first).value
    array([4., 3.])

    """
    if not first.time.size:
        return Line(line.time[:0], line.value[:0])
    if np.array_equal(line.time, first.time):
        return Line(line.time, line.value - first.value)
    return Line(line.time, line.value - np.interp(line.time, first.time, first.value, math.nan, math.nan))


def _apart(line: Line) -> Line:
    """Return a line whose gaps have times of their own, between those of their neighbours."""
    gaps = np.nonzero(np.isnan(line.value))[0]
    if not gaps.size:
        return line
    time = line.time.copy()
    before, after = np.maximum(gaps - 1, 0), np.minimum(gaps + 1, time.size - 1)
    time[gaps] = 0.5 * (line.time[before] + line.time[after])
    return Line(time, line.value)


def _chart_lines(panel: Panel, runs: Sequence[RecordedRun], columns: _Columns) -> Iterator[dict[str, Any]]:
    """Yield what a chart shows, from back to front."""
    def packed(kind: str, run: int, name: str, line: Line, buckets: int = _BUCKETS) -> Iterator[dict[str, Any]]:
        if np.isfinite(line.value).any():
            shown = _apart(thinned(line, buckets))
            yield {'kind': kind, 'run': run, 'name': name, 'time': columns.add(shown.time),
                   'value': columns.add(shown.value)}

    if panel.reference:
        for n, run in enumerate(runs):
            drawn = list(packed('reference', n, 'reference', panel.reference(run.series)))
            if drawn:  # one for all
                yield from drawn
                break
    first = panel.value(runs[0].series)
    for n, run in enumerate(runs):
        line = panel.value(run.series)
        yield from packed('value', n, panel.labels[0] if panel.command else 'robot', line)
        if n:
            yield from packed('difference', n, 'difference', difference(line, first), _DIFFERENCE_BUCKETS)
    for n, run in enumerate(runs):
        if panel.command:
            yield from packed('command', n, panel.labels[1], panel.command(run.series))


def _chart(figure: RunFigure, panel: Panel, runs: Sequence[RecordedRun], columns: _Columns) -> dict[str, Any]:
    """Return a chart."""
    label, unit = re.fullmatch(r'(.*?)(?: \[(.*)\])?', panel.label.replace('\n', ' ')).groups()  # type: ignore[union-attr]
    limits = [torque_limit(run) for run in runs] if figure.name == TORQUE_FIGURE else []
    return {
        'figure': figure.name, 'label': label, 'unit': unit or '',
        # beyond this value the scale is logarithmic, where it is not 0
        'bend': ordinary_size([panel.value(run.series) for run in runs]) if panel.logarithmic else 0.0,
        'limits': [{'run': n, 'value': limit} for n, limit in enumerate(limits) if limit],
        'lines': list(_chart_lines(panel, runs, columns)),
    }


def _look(color: str) -> dict[str, str]:
    """Return a colour on light and on dark ground."""
    return {'light': color, 'dark': on_dark(color)}


def _span(series: Series) -> tuple[float, float]:
    """Return the first and the last time of any message of a run [s]."""
    times = [time for time in map(series.time, series.signals) if time.size]
    return min(float(time[0]) for time in times), max(float(time[-1]) for time in times)


def chart_data(figures: Sequence[RunFigure], runs: Sequence[RecordedRun]) -> dict[str, Any]:
    """
    Return everything that the charts of a page show, as JSON can hold it; web/charts.js describes it.

    Parameters
    ----------
    figures : sequence of RunFigure
        Of which the charts are made: one of each panel in which any run has something to show.
    runs : sequence of RecordedRun
        At least one, with messages.
    """
    columns = _Columns()
    spans = [_span(run.series) for run in runs]
    looks = zip(runs, LINES, line_widths(len(runs)), strict=False)
    charts = [_chart(figure, panel, runs, columns) for figure in figures for panel in figure.panels]
    return {
        'start': min(start for start, _ in spans), 'end': max(end for _, end in spans),
        'runs': [{'name': run.name, **_look(color), 'width': round(1.2 * width, 2),
                  'dash': _DASHES[dashes] if isinstance(dashes, str) else [2 * length for length in dashes[1]]}
                 for run, (color, dashes), width in looks],
        'reference': _look(GREY), 'command': _look(INK),
        'charts': [chart for chart in charts if chart['lines']],
        'deviation': [{'run': n, **{name: columns.add(values) for name, values in found._asdict().items()}}
                      for n, found in enumerate(deviation(run.series) for run in runs) if found.time.size],
        'columns': columns.packed,
    }
