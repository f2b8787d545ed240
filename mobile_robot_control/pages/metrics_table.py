"""Metrics and configurations of runs, side by side."""

from collections.abc import Callable, Iterator, Sequence
from html import escape
from typing import Any, NamedTuple

from mobile_robot_control.loop.indices import MEASURED, TRUE
from mobile_robot_control.loop.metric_table import INDEX_METRICS, METRIC_TABLE, RUN_METRICS, Metric
from mobile_robot_control.pages.page import html_table
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.words import (
    WHOLE,
    Unit,
    described_change,
    peak_torque,
    quantities,
    quantity,
    readable_unit,
)
from mobile_robot_control.settings.nodes import Configuration


class MetricRow(NamedTuple):
    """
    A metric in a table.

    Attributes
    ----------
    label, unit : str
        As shown.
    value : callable
        Returns it from the metrics of a run; None if it is not known.
    depends : tuple of str
        Properties that runs must share to be compared by it: the same `error`, and `energy` known or unknown.
    best : callable
        Returns the best one of several values, min or max.
    """

    label: str
    unit: str
    value: Callable[[dict[str, Any]], Any]
    depends: tuple[str, ...] = ()
    best: Callable[[Sequence[float]], float] = min


def _metric(*path: str) -> Callable[[dict[str, Any]], Any]:
    """Return the function that looks up a nested metric; None if it is missing."""
    def pick(metrics: dict[str, Any]) -> Any:
        value: Any = metrics
        for key in path:
            value = value.get(key) if value else None
        return value

    return pick


def _rows(metric: Metric) -> Iterator[MetricRow]:
    """Yield the rows of a metric: one, or one a wheel."""
    best = max if metric.better == 'larger' else min
    for wheel in ('right', 'left') if metric.of_wheels else ():
        yield MetricRow(f'{metric.label_in()}, {wheel}', metric.unit, _metric(metric.name, wheel), metric.needs, best)
    if not metric.of_wheels:
        yield MetricRow(metric.label_in(), metric.unit, _metric(metric.name), metric.needs, best)


ROWS = tuple(row for metric in (*RUN_METRICS, *INDEX_METRICS) if metric.better for row in _rows(metric))
"""Metrics with a better direction."""
_FACTS = tuple(_rows(METRIC_TABLE['initial_wheel_torque']))
_OF = {TRUE: 'the true pose', MEASURED: 'odometry'}
_NOTES = {
    TRUE: 'True error: of where the robot really was.',
    MEASURED: 'Measured error (odometry): of where odometry saw the robot; where it really was is not known.',
}


def comparable_runs(runs: Sequence[Run]) -> list[bool]:
    """Return which runs were complete and equally long: an early end saves energy, for example."""
    longest = max((run.metrics.get('duration') or 0.0 for run in runs), default=0.0)
    return [run.metrics.get('outcome') in WHOLE
            and (run.metrics.get('duration') or 0.0) >= 0.99 * longest for run in runs]


def _marked(values: Sequence[float | None], comparable: Sequence[bool], row: MetricRow) -> list[str]:
    """Return the cells of a row: the best of several comparable runs marked, and differences from the first run."""
    candidates = [value for value, counts in zip(values, comparable, strict=True) if counts and value is not None]
    texts = quantities(values, row.unit)
    if len(candidates) < 2:
        return texts
    # none is the best of equal ones
    best = row.best(candidates) if len(set(candidates)) > 1 else None
    marked = [f'<span class="best">★ {text}</span>' if counts and value is not None and value == best else text
              for text, value, counts in zip(texts, values, comparable, strict=True)]
    first = values[0]
    return marked[:1] + [
        f'{cell}<small class="change">{described_change(value, first, row.unit)}</small>'
        if first is not None and value is not None and counts and comparable[0] else cell
        for cell, value, counts in zip(marked[1:], values[1:], comparable[1:], strict=True)]


def metrics_table(runs: Sequence[Run]) -> str:
    """Return the metrics of runs side by side, as HTML, with the best of several in each row marked."""
    comparable = comparable_runs(runs)
    rows = [['outcome', *(escape(str(run.metrics.get('outcome', 'not measured'))) for run in runs)],
            ['duration', *(quantity(run.metrics.get('duration'), 's') for run in runs)],
            ['errors are those of', *(_OF.get(str(run.metrics.get('error')), '–') for run in runs)]]
    for row in ROWS:
        fair = comparable if _alike(runs, row) else [False] * len(runs)
        rows.append([row.label, *_marked([row.value(run.metrics) for run in runs], fair, row)])
    rows.append(['position error by odometry, RMS', *(_hidden(run.metrics) for run in runs)])
    if len(runs) > 1:
        rows.append(['peak torque against the least', *_ratios(runs, comparable)])
    for row in _FACTS:
        rows.append([row.label, *quantities([row.value(run.metrics) for run in runs], row.unit)])
    for n, (label, unit) in enumerate((('x', 'm'), ('y', 'm'), ('heading', 'rad'))):
        rows.append([f'final {label}', *(_part(run.metrics.get('final_pose'), n, unit) for run in runs)])
    # a metric unknown for all runs has no row
    rows = [row for row in rows if set(row[1:]) != {'–'}]
    notes = [note for kind, note in _NOTES.items() if any(run.metrics.get('error') == kind for run in runs)]
    if any('★' in cell for row in rows for cell in row):
        notes.append(f'★ marks the best of the runs that went to their end; + and − are differences to {runs[0].name}.')
    notes.append('Under the pointer: the exact value in SI units.')
    return html_table(['', *(run.name for run in runs)], rows) + f'<p class="soft">{escape(" ".join(notes))}</p>'


def _alike(runs: Sequence[Run], row: MetricRow) -> bool:
    """Return whether the values of runs have the same meaning: true and measured errors cannot be ranked."""
    measured = [run.metrics for run in runs if row.value(run.metrics) is not None]
    return ('error' not in row.depends or len({metrics.get('error') for metrics in measured}) < 2) and (
        'energy' not in row.depends or len({metrics.get('energy') is None for metrics in measured}) < 2)


def _hidden(metrics: dict[str, Any]) -> str:
    """Return the position error by odometry, if that is not the error itself."""
    measured = metrics.get('measured_rms_position_error')
    return '–' if measured == metrics.get('rms_position_error') else quantity(measured, 'm')


def _part(pose: Sequence[float | None] | None, n: int, unit: str) -> str:
    """Return the n-th number of a pose with its unit."""
    value = pose[n] if pose else None
    return quantity(value, unit, readable_unit([value], unit) if unit == 'rad' else Unit(unit, 1.0))


def _ratios(runs: Sequence[Run], comparable: Sequence[bool]) -> list[str]:
    """Return the peak torques as multiples of the smallest among comparable runs; nothing for a single torque."""
    peaks = [peak_torque(run.metrics) for run in runs]
    if sum(peak is not None for peak in peaks) < 2:
        return ['–'] * len(peaks)
    least = min((peak for peak, counts in zip(peaks, comparable, strict=True) if counts and peak), default=None)
    return ['–' if peak is None or least is None else f'{peak / least:.3g} times' for peak in peaks]


def configuration_table(runs: Sequence[Run]) -> str:
    """Return the parameters of runs side by side as HTML, different ones first; a sentence if none are known."""
    by_run = {run.name: _flat(run.parameters) for run in runs if run.parameters is not None}
    if not by_run:
        return ('<p>Not recorded: no parameter file lies beside the run; '
                'add <code>--params-file FILE</code> to show one.</p>')
    columns = list(by_run.values())
    names = list(dict.fromkeys(name for column in columns for name in column))
    rows = [[f'<code>{escape(name)}</code>', *(escape(column.get(name, '–')) for column in columns)] for name in names]
    differing = [row for row in rows if len(set(row[1:])) > 1]
    head = ['parameter', *by_run]
    parts = [html_table(head, differing)] if differing else []
    parts.append(f'<details><summary>All {len(rows)} parameters</summary>{html_table(head, rows)}</details>')
    return '\n'.join(parts)


def _flat(parameters: Configuration) -> dict[str, str]:
    """Return each parameter once as text: a shared one by its name alone, others with the node's name before it."""
    shared = {name: _text(value) for name, value in flatten(parameters.plant.shared).items()}
    own = {f'{node}.{name}': _text(value) for node, part in parameters._asdict().items()
           for name, value in flatten(part).items() if name not in shared}
    return shared | own


def _text(value: object) -> str:
    """Return a value as text, an array in brackets."""
    return '[' + ', '.join(f'{part:g}' for part in value) + ']' if isinstance(value, tuple) else str(value)
