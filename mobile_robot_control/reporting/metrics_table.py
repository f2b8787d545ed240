"""Metrics and configurations of runs, side by side."""

from collections.abc import Callable, Sequence
from html import escape
from typing import Any, NamedTuple

from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.reporting.page import html_table
from mobile_robot_control.reporting.run_reading import RecordedRun


class Row(NamedTuple):
    """
    A metric as a table shows it.

    Attributes
    ----------
    label, unit : str
        Before and behind the number.
    value : callable
        Picks it from the metrics.

    """

    label: str
    unit: str
    value: Callable[[dict[str, Any]], Any]


def _of(name: str, *path: str) -> Callable[[dict[str, Any]], Any]:
    def pick(metrics: dict[str, Any]) -> Any:
        value = metrics.get(name)
        for key in path:
            value = value.get(key) if value else None
        return value

    return pick


def peak_torque(metrics: dict[str, Any]) -> float | None:
    """
    Give the largest torque of either wheel.

    Parameters
    ----------
    metrics : dict of str to object
        Of a run.

    Returns
    -------
    float or None
        [N m], absolute.

    """
    peaks = (metrics.get('peak_wheel_torque') or {}).values()
    known = [peak for peak in peaks if peak is not None]
    return max(known) if known else None


ROWS = (
    Row('position error, RMS', 'm', _of('rms_position_error')),
    Row('position error, largest', 'm', _of('max_position_error')),
    Row('heading error, RMS', 'rad', _of('rms_heading_error')),
    *(Row(f'peak torque, {wheel}', 'N m', _of('peak_wheel_torque', wheel)) for wheel in ('right', 'left')),
    *(Row(f'peak power, {wheel}', 'W', _of('peak_wheel_power', wheel)) for wheel in ('right', 'left')),
    Row('energy', 'J', _of('energy')),
    Row('objective, Eq. (29)', '', _of('objective')),
)
"""Metrics of which less is better."""
_FACTS = tuple(Row(f'first torque, {wheel}', 'N m', _of('initial_wheel_torque', wheel)) for wheel in ('right', 'left'))


def four_digits(value: float | None) -> str:
    """
    Write a number with four significant digits.

    Parameters
    ----------
    value : float or None
        None where there is none.

    Returns
    -------
    str
        For people.

    """
    return '–' if value is None else f'{value:.4g}'


def _comparable(runs: Sequence[RecordedRun]) -> list[bool]:
    """Say which runs went to their end over the same time: a run that died early has spent little."""
    longest = max((run.metrics.get('duration') or 0.0 for run in runs), default=0.0)
    return [run.metrics.get('outcome') in ('completed', 'not known')
            and (run.metrics.get('duration') or 0.0) >= 0.99 * longest for run in runs]


def _marked(values: Sequence[float | None], comparable: Sequence[bool], unit: str) -> list[str]:
    rivals = [value for value, fair in zip(values, comparable, strict=True) if fair and value is not None]
    texts = [four_digits(value) + (f' {unit}' if unit and value is not None else '') for value in values]
    if len(rivals) < 2:
        return texts
    return [f'<span class="best">★ {text}</span>' if fair and value == min(rivals) else text
            for text, value, fair in zip(texts, values, comparable, strict=True)]


def metrics_table(runs: Sequence[RecordedRun]) -> str:
    """
    Set the metrics of runs side by side.

    Parameters
    ----------
    runs : sequence of RecordedRun
        One or several; of several the best is marked in each row.

    Returns
    -------
    str
        HTML.

    """
    fair = _comparable(runs)
    rows = [['outcome', *(escape(str(run.metrics.get('outcome', 'not measured'))) for run in runs)],
            ['duration', *(f'{four_digits(run.metrics.get("duration"))} s' for run in runs)]]
    for row in ROWS:
        rows.append([row.label, *_marked([row.value(run.metrics) for run in runs], fair, row.unit)])
    if len(runs) > 1:
        rows.append(['peak torque against the least', *_ratios(runs, fair)])
    for row in _FACTS:
        rows.append([row.label, *(f'{four_digits(row.value(run.metrics))} {row.unit}' for run in runs)])
    for n, (label, unit) in enumerate((('x', 'm'), ('y', 'm'), ('heading', 'rad'))):
        rows.append([f'final {label}', *(_part(run.metrics.get('final_pose'), n, unit) for run in runs)])
    note = '<p class="soft">★ marks the best of the runs that went to their end.</p>' if len(runs) > 1 else ''
    return html_table(['', *(run.name for run in runs)], rows) + note


def _part(pose: Sequence[float | None] | None, place: int, unit: str) -> str:
    value = pose[place] if pose else None
    return '–' if value is None else f'{value:.3f} {unit}'


def _ratios(runs: Sequence[RecordedRun], fair: Sequence[bool]) -> list[str]:
    peaks = [peak_torque(run.metrics) for run in runs]
    least = min((peak for peak, counts in zip(peaks, fair, strict=True) if counts and peak), default=None)
    return ['–' if peak is None or least is None else f'{peak / least:.3g} times' for peak in peaks]


def configuration_table(runs: Sequence[RecordedRun]) -> str:
    """
    Set the parameters that runs ran with side by side, those first in which they differ.

    Parameters
    ----------
    runs : sequence of RecordedRun
        One or several.

    Returns
    -------
    str
        HTML; a sentence where nothing is known.

    """
    known = {run.name: _flat(run.parameters) for run in runs if run.parameters is not None}
    if not known:
        return ('<p>Not recorded: no parameter file lies beside the run; '
                'add <code>--params-file FILE</code> to show one.</p>')
    columns = list(known.values())
    names = list(dict.fromkeys(name for column in columns for name in column))
    rows = [[f'<code>{escape(name)}</code>', *(escape(column.get(name, '–')) for column in columns)] for name in names]
    differing = [row for row in rows if len(set(row[1:])) > 1]
    head = ['parameter', *known]
    parts = [html_table(head, differing)] if differing else []
    parts.append(f'<details><summary>All {len(rows)} parameters</summary>{html_table(head, rows)}</details>')
    return '\n'.join(parts)


def _flat(parameters: Configuration) -> dict[str, str]:
    """Give each parameter once: a shared one without a node's name."""
    shared = {name: _text(value) for name, value in flatten(parameters.plant.shared).items()}
    own = {f'{node}.{name}': _text(value) for node, part in parameters._asdict().items()
           for name, value in flatten(part).items() if name not in shared}
    return shared | own


def _text(value: Any) -> str:
    return '[' + ', '.join(f'{part:g}' for part in value) + ']' if isinstance(value, tuple) else str(value)
