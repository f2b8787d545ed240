"""The headline of runs: one sentence of plain text, and five key numbers per run."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.pages.metrics_table import comparable_runs
from mobile_robot_control.pages.readable import readable, readable_unit
from mobile_robot_control.pages.run_words import peak_torque, run_end, run_facts, run_sentence
from mobile_robot_control.runs.gaps import count_missing
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.segments import events_within, segments
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
        told = run_sentence(run.metrics, run.parameters, bool(run.series.origin), drove)
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
    return 'no message was lost' if recorded else 'no row of its table is missing'


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
