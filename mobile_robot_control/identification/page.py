"""The page of an identification: the quality of the model's prediction, its numbers, and open questions."""

from collections.abc import Sequence
from html import escape

import numpy as np

from mobile_robot_control.figures.drawing import draw
from mobile_robot_control.figures.figure import COMMAND, VALUE, Figure, Floats, Line, Panel, Trace, plane
from mobile_robot_control.figures.palette import as_svg
from mobile_robot_control.identification.result import (
    GOOD,
    UNUSABLE,
    USABLE,
    Identification,
    Judgement,
    Parameter,
    Prediction,
    drive_of,
)
from mobile_robot_control.pages import page

_MOST_POINTS = 1500
_SHOWN = 30.0
"""[s] of the held-out part in the figures."""
_LAGS = 40


def answer(result: Identification) -> str:
    """Return the quality of the model's prediction in a sentence."""
    judged, (v, omega) = result.judgement, result.errors['held_out']
    missed = ' and '.join(f'{share:.1%} of the {name}' for name, share in zip(
        _MOTIONS, judged.shares, strict=True) if share)
    # a motion that is not in the recording has no share
    unseen = ''.join(f' It is not judged by the {name}, of which there was none.' for name, share in zip(
        _MOTIONS, judged.shares, strict=True) if not share)
    return (f'The model of a robot that takes {drive_of(result)} is {judged.grade}: where it has not seen the '
            f'recording, it misses {missed}, averaged over 0.2 s; from message to message {100.0 * v:.2g} cm/s and '
            f'{omega:.2g} rad/s RMS.{unseen}{_MEANING[judged.grade]}')


_MOTIONS = ('speed', 'turn rate')
_MEANING = {
    GOOD: '', USABLE: ' Gains found for it want a margin.',
    UNUSABLE: ' It stands for another robot than this one: gains found for it mean nothing.'}


def regime_lines(judged: Judgement) -> list[str]:
    """Return what a model that is not good misses in each regime."""
    if judged.grade == GOOD:
        return []
    return [f'  {name}: {v:.1%} of the speed, {omega:.1%} of the turn rate'
            for name, (v, omega) in sorted(judged.regimes.items(), key=lambda pair: -max(pair[1]))]


def _thin(times: Floats, values: Floats) -> Line:
    step = max(1, times.size // _MOST_POINTS)
    return Line(times[::step], values[::step])


def _figures(prediction: Prediction, residuals: Floats) -> list[Figure]:
    part = (prediction.times > prediction.held_out) & (prediction.times < prediction.held_out + _SHOWN)
    velocities = Figure(
        'velocities', 'Held-out part: velocities', 'Measured, and predicted by the model from commands or torques '
        'alone, for the part held out of the fit.', ('measured', 'modelled'), tuple(
            Panel(name, name, unit, (
                Trace(VALUE, 0, '', _thin(prediction.times[part], prediction.measured[part, n])),
                Trace(VALUE, 1, '', _thin(prediction.times[part], prediction.modelled[part, n]))))
            for n, (name, unit) in enumerate((('v', 'm/s'), ('ω', 'rad/s')))), 5.0, 11.0)
    path = Figure(
        'path', 'Held-out part: path', 'Both begin at the same pose; errors of the heading add up.',
        ('measured', 'modelled'),
        (plane('path', [Trace(VALUE, 0, '', Line(*prediction.measured_path[:, :2].T)),
                        Trace(VALUE, 1, '', Line(*prediction.modelled_path[:, :2].T))]),), 5.0)
    left = prediction.measured - prediction.modelled
    errors = Figure(
        'errors', 'Residuals', 'Measured less modelled, over the whole recording.', ('residual',), tuple(
            Panel(name, name, unit, (Trace(VALUE, 0, '', _thin(prediction.times, left[:, n])),))
            for n, (name, unit) in enumerate((('v', 'm/s'), ('ω', 'rad/s')))), 5.0)
    count = residuals.shape[0]
    bound = 1.96 / np.sqrt(count)
    lags = np.arange(1.0, _LAGS + 1.0)
    correlation = Figure(
        'correlation', 'Correlation of the residuals', 'Of the residuals without their modelled noise, so many samples '
        'apart; within the dotted lines it is chance.', ('correlation',), tuple(
            Panel(name, name, '', (
                Trace(COMMAND, 0, 'chance', Line(lags[[0, -1]], np.full(2, bound))),
                Trace(COMMAND, 0, '', Line(lags[[0, -1]], np.full(2, -bound))),
                Trace(VALUE, 0, '', Line(lags, np.array([
                    float(np.mean(residuals[lag:, n] * residuals[:-lag, n]) / np.mean(residuals[:, n] ** 2))
                    for lag in range(1, _LAGS + 1)])))), 'samples') for n, name in enumerate(('v', 'ω'))), 5.0)
    return [velocities, path, errors, correlation]


def _listed(texts: Sequence[str]) -> str:
    items = ''.join(f'<li>{escape(text)}</li>' for text in texts)
    return f'<ul>{items}</ul>'


def _interval(parameter: Parameter) -> str:
    return f'{parameter.low:.4g} to {parameter.high:.4g}' if np.isfinite(parameter.low) else 'as measured'


def _rows(pairs: Sequence[tuple[Parameter, float | None]], with_other: bool) -> list[list[str]]:
    rows = []
    for parameter, other in pairs:
        row = [page.breakable(parameter.name), f'{parameter.value:.4g}', _interval(parameter), escape(parameter.unit)]
        if with_other:
            outside = other is not None and np.isfinite(parameter.low) and not parameter.low <= other <= parameter.high
            value = '' if other is None else f'{other:.4g}'
            row.append(f'{value} (outside)' if outside else value)
        rows.append(row)
    return rows


def identification_page(
    result: Identification, title: str, pairs: Sequence[tuple[Parameter, float | None]], other: str = ''
) -> str:
    """
    Return the page of an identification.

    Parameters
    ----------
    result : Identification
        With at least one prediction.
    title : str
        Plain text.
    pairs : sequence of (Parameter, float or None)
        Each parameter, and its value in another file.
    other : str
        Name of that file; '' for none.
    """
    pictures = [
        page.picture(figure.title, figure.caption, page.drawing(as_svg(draw(figure))), name=figure.name)
        for one in result.predictions[:1] for figure in _figures(one, result.residuals)]
    head = ['parameter', 'value', '95 % interval', 'unit', *([other] if other else [])]
    told = [[escape(name), escape(f'{value:.4g}' if isinstance(value, float) else value)]
            for name, value in result.facts.items()]
    parts = [
        f'<h1>{escape(title)}</h1><p class="answer">{escape(answer(result))}</p>',
        *([_listed(regime_lines(result.judgement))] if result.judgement.grade != GOOD else []), pictures[0],
        page.section('numbers', 'Numbers', page.html_table(head, _rows(pairs, bool(other)))),
        *([page.section('reported', 'Further numbers', page.html_table(
            head[:4], _rows([(one, None) for one in result.reported], False)))] if result.reported else []),
        *(page.section(name, heading, _listed(texts)) for name, heading, texts in (
            ('lacking', 'What the model lacks', result.lacking),
            ('open', 'What the recordings do not tell', result.open), ('notes', 'Notes', result.notes)) if texts),
        page.grid(pictures[1:]),
        page.section('recording', 'The recording', page.html_table(('', 'measured'), told)),
        page.section('made', 'How it was made', page.made_with(result.provenance)),
    ]
    return page.page(title, parts)
