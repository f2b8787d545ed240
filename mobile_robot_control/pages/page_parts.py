"""Shared parts of pages: the headline of runs, the first screen, the charts, and the validity of numbers."""

from collections.abc import Callable, Iterator, Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.analysis.promises import Promise, promise_values, spread_text, warnings_of
from mobile_robot_control.figures.figure import Figure, Floats, Line, Panel
from mobile_robot_control.figures.palette import GREY, INK, LINES, line_widths, on_dark
from mobile_robot_control.pages import page
from mobile_robot_control.pages.metrics_table import comparable_runs
from mobile_robot_control.pages.page import asset, pack
from mobile_robot_control.pages.replay_data import replay_data
from mobile_robot_control.runs.other_nodes import nodes_of_others
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.segments import event_text, events_within, segments
from mobile_robot_control.runs.series import Series, count_missing
from mobile_robot_control.runs.words import (
    peak_torque,
    quantity,
    readable,
    readable_unit,
    run_end,
    run_facts,
    run_sentence,
)
from mobile_robot_control.system.texts import shortened

_NAME = 40
"""Longest name of a run in the sentence [characters]."""
_NUMBERS: dict[str, tuple[Callable[[dict[str, Any]], float | None], str]] = {
    'RMS error': (lambda metrics: metrics.get('rms_position_error'), 'm'),
    'largest error': (lambda metrics: metrics.get('max_position_error'), 'm'),
    'RMS heading error': (lambda metrics: metrics.get('rms_heading_error'), 'rad'),
    'peak torque': (peak_torque, 'N m'),
    'energy': (lambda metrics: metrics.get('energy'), 'J'),
    'duration': (lambda metrics: metrics.get('duration'), 's'),
}
"""The source of each number in the metrics of a run, and its SI unit."""
_MISSING = 'messages missing'
"""The number that is not among the metrics."""


class Number(NamedTuple):
    """A number of a run with its unit, as text, and its label."""

    label: str
    text: str


def key_numbers(runs: Sequence[Run]) -> list[list[Number]]:
    """
    Return the five most informative numbers per run: the same for all runs, the first ones known for any.

    A number unknown for a run is a dash.
    """
    columns = [_column(label, [value(run.metrics) for run in runs], unit) for label, (value, unit) in _NUMBERS.items()]
    columns.append([Number(_MISSING, str(count_missing(run.series))) for run in runs])
    ordered = sorted(columns, key=lambda column: all(number.text == '–' for number in column))[:5]
    return [list(row) for row in zip(*ordered, strict=True)]


def _column(label: str, values: Sequence[float | None], unit: str) -> list[Number]:
    """Return a number of each run, all in one unit for an easy comparison."""
    shown = readable_unit(values, unit)
    return [Number(label, readable(value, unit, shown)) for value in values]


def sentence(runs: Sequence[Run]) -> str:
    """
    Return the headline of runs.

    Parameters
    ----------
    runs : sequence of Run
        At least one, with any outcome and any missing data.

    Returns
    -------
    str
        For one run: law, curve, outcome, errors, peak torque and missing data. For several: the one with the smallest
        RMS error among comparable ones, and the outcome of the others.
    """
    if len(runs) == 1:
        run, = runs
        drove = len({part.law for part in segments(run)})
        told = run_sentence(run.metrics, run.parameters, bool(run.series.origin), drove,
                            nodes_of_others(run.provenance))
        return f'{told}{_changed(run)}; {_missing(run)}.'
    return f'{_of_several(runs)}; {_missing_of_several(runs)}.'


def _changed(run: Run) -> str:
    """Describe the number of events that changed a run."""
    count = len(events_within(run))
    return f'; {count} event{" has" if count == 1 else "s have"} changed it' if count else ''


def _missing(run: Run) -> str:
    """Describe whether messages of a run are missing."""
    missing = count_missing(run.series)
    if missing:
        return f'{missing} message{" is" if missing == 1 else "s are"} missing from the recording'
    if run.problems:
        return 'its recording is not complete, see what is missing below'
    recorded = any(signal.received.size for signal in run.series.signals.values())
    return 'no message was lost' if recorded else 'its table is complete'


def _missing_of_several(runs: Sequence[Run]) -> str:
    incomplete = [_name(run) for run in runs if run.problems or count_missing(run.series)]
    if not incomplete:
        return 'no message is missing'
    return f'the recording of {_listed(incomplete)} is not complete, see what is missing below'


def _of_several(runs: Sequence[Run]) -> str:
    """Describe the best of several runs, and the outcome of those that cannot be compared with it."""
    fair = [run for run, counts in zip(runs, comparable_runs(runs), strict=True)
            if counts and run.metrics.get('rms_position_error') is not None]
    failed = [f'{_name(run)} {run_end(run.metrics, run.parameters, bool(run.series.origin))}'
              for run in runs if run not in fair]
    if len({run.metrics.get('error') for run in fair}) > 1:
        first = f'{len(runs)} runs are not ranked, as the errors of some are true and those of others measured'
    elif not fair:
        first = f'None of {len(runs)} runs can be compared with another'
    else:
        ranked = sorted(fair, key=lambda run: float(run.metrics['rms_position_error']))
        best = 'has the smallest error' if len(ranked) > 1 else 'alone is whole, and as long as the longest'
        first = f'Of {len(runs)} runs, {_name(ranked[0])} {best}: {run_facts(ranked[0].metrics, ranked[0].parameters)}'
        if len(ranked) > 1:
            first += f'; next is {_name(ranked[1])} with {readable(ranked[1].metrics["rms_position_error"], "m")}'
    return '; '.join([first, *failed])


def _name(run: Run) -> str:
    return shortened(run.name, _NAME)


def _listed(names: Sequence[str]) -> str:
    """Return names as 'a', 'a and b' or 'a, b and c'."""
    return names[0] if len(names) == 1 else f'{", ".join(names[:-1])} and {names[-1]}'


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
        packed = pack(np.where(np.abs(values) <= _LARGEST, values, np.nan))
        if packed not in self._places:
            self._places[packed] = len(self.packed)
            self.packed.append(packed)
        return self._places[packed]


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
    columns = {'time': time[chosen]}
    for axis in 'xy' if chosen.size else '':
        columns[axis] = np.interp(time[chosen], cart, series.line('reference', axis).value)
        columns[f'{axis}_error'] = series.line(series.motion, axis).value[chosen] - columns[axis]
    return columns


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


_SCRIPTS = ('basics.js', 'clock.js', 'scene.js', 'replay.js', 'report.js')


def first_screen(title: str, runs: Sequence[Run], answer: str = '') -> str:
    """Return title, answer, numbers and, if a run has moved, the replay with its data, as HTML."""
    inner = [f'<h1>{escape(title)}</h1>', f'<p class="answer">{escape(answer or sentence(runs))}</p>', _numbers(runs)]
    try:
        data = replay_data(runs)
        block = '' if data is None else page.json_block('run-data', data)
    except Exception as error:  # whatever a run contains, the rest of the page is made
        reason = f'cannot be shown: {type(error).__name__}: {shortened(str(error))}'
        return f'<section class="first">{"".join(inner)}</section>\n{page.warning("Replay", [reason])}'
    # its script shows it; without scripts the pictures below show the same
    inner += ['<div class="replay" id="replay" hidden></div>'] if block else []
    return f'<section class="first">{"".join(inner)}</section>\n{block}'


def replay_page(runs: Sequence[Run]) -> str:
    """Return a page with only the first screen of a report, as HTML."""
    title = ', '.join(run.name for run in runs)
    return page.page(title, [first_screen(title, runs)], replay_styles(), replay_scripts())


def _numbers(runs: Sequence[Run]) -> str:
    """Return the numbers of a run as a list, or of several as a table, as HTML."""
    numbers = key_numbers(runs)
    if len(runs) == 1:
        items = ''.join(f'<div><dt>{escape(number.label)}</dt><dd>{escape(number.text)}</dd></div>'
                        for number in numbers[0])
        return f'<dl class="numbers">{items}</dl>'
    rows = ([page.breakable(run.name), *(escape(number.text) for number in row)]
            for run, row in zip(runs, numbers, strict=True))
    return page.html_table(['', *(number.label for number in numbers[0])], rows)


def replay_scripts() -> list[str]:
    """Return the scripts of the replay, in their order; the last one starts it."""
    return list(map(asset, _SCRIPTS))


def replay_styles() -> list[str]:
    """Return the style sheets of the first screen."""
    return [asset('replay.css')]


UPLOT_SCRIPT = 'uplot/uPlot.iife.min.js'
CHART_SCRIPTS = (UPLOT_SCRIPT, 'marks.js', 'view_export.js', 'charts.js', 'chart_bar.js', 'deviation.js')
CHART_STYLES = ('uplot/uPlot.min.css', 'charts.css')
_START = """(function () {
  const data = JSON.parse(document.getElementById('chart-data').textContent);
  mrc.clock = mrc.clock || mrc.makeClock(data.start, data.end);
  mrc.charts = mrc.showCharts(data, mrc.clock);
}());
"""


def chart_numbers(figures: Sequence[Figure], runs: Sequence[Run]) -> str:
    """Return the element with the numbers of a page's charts, as HTML."""
    return page.json_block('chart-data', chart_data(figures, runs))


def chart_scripts() -> list[str]:
    """Return the scripts of charts, in their order, to follow those of the replay; the last one draws them."""
    return [*map(asset, CHART_SCRIPTS), _START]


def chart_styles() -> list[str]:
    """Return the style sheets of a page with charts."""
    return list(map(asset, CHART_STYLES))


_HEAD = ('loop', 'gain margin', 'lower gain margin', 'delay margin', 'least gain margin at', 'least delay margin at')


def promise_parts(promise: Promise) -> Iterator[str]:
    """Yield the promise about numbers, as HTML."""
    warnings = warnings_of(promise)
    if warnings:
        yield page.warning('Not to be expected of a robot', warnings)
    values = promise_values(promise)
    rows = [[escape(name.replace('_', ' ')), quantity(loop['gain'], ''), quantity(loop['lowest_gain'], ''),
             quantity(loop['delay'], 's'), quantity(loop['gain'] and loop['gain_time'], 's'),
             quantity(loop['delay'] and loop['delay_time'], 's')]
            for name, loop in values['margins'].items() if isinstance(loop, dict)]
    yield page.html_table(_HEAD, rows)
    yield ('<p class="soft">A gain margin is the factor on the output of a controller that destabilises its loop, a '
           'delay margin the additional delay; a dash means that none is known or none was found. Times on the lap '
           'are those of the smallest margins.</p>')
    modelled = [f'{effect}: {value}' for effect, value in values['modelled'].items()]
    left_out = values['margins']['not_in_margins']
    unknown = 'Not modelled: a robot with any of these effects may have another error'
    for title, texts in (('Modelled', modelled), (unknown, values['not_modelled']), ('Not in the margins', left_out),
                          ('Ruled out', values['ruled_out']),
                          ('Spread', [spread_text(promise.spread)] if promise.spread else [])):
        if texts:
            yield f'<h3>{escape(title)}</h3><p>{escape("; ".join(texts))}.</p>'
