"""How well a model foretells a robot: its error on motion that it has not seen, and what that leaves known."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.identification.estimation import Z95
from mobile_robot_control.identification.recorded import Mask
from mobile_robot_control.identification.result import (
    GOOD,
    UNUSABLE,
    USABLE,
    Identification,
    Judgement,
    Parameter,
    Prediction,
)

LARGEST = {GOOD: 0.1, USABLE: 0.3}
"""Share of the motion that a model misses."""
_WINDOW = 0.2
"""[s] over which velocities are averaged: noise between two messages is no motion."""
_START = 0.6
"""[s] after a change of the velocity that belong to a start."""
_CHANGE = 0.2
"""Share of the largest velocity by which a start changes it in a window."""
_SLOW = 0.1
"""Share of the largest velocity below which a robot does not drive, or not turn."""
_STANDS = 0.01
"""[m/s], [rad/s]"""
_FEWEST = 10
"""Windows of a regime that is judged."""
_UNLIKE, _SURE = 0.05, 5.0
"""Least reported difference of two turn gains, and in its standard deviations."""


class _Windows(NamedTuple):
    """Mean velocities of windows, shape (n, 2), whether they were held out, and their regimes, shape (n,)."""

    measured: Floats
    modelled: Floats
    held_out: Mask
    regimes: dict[str, Mask]


def _windows(predictions: Sequence[Prediction]) -> _Windows:
    """Return the windows of all recordings."""
    measured, modelled, held_out, starts = [], [], [], []
    largest = np.nanmax(np.abs(np.concatenate([one.modelled for one in predictions])), axis=0) + 1e-12
    for prediction in predictions:
        number = np.floor((prediction.times - prediction.times[0]) / _WINDOW).astype(int)
        number[~np.isfinite(prediction.measured).all(axis=1)] = -1
        rows = [number == n for n in np.unique(number[number >= 0])]
        if not rows:
            continue
        means = np.array([prediction.modelled[row].mean(axis=0) for row in rows])
        changed = (np.abs(np.diff(means, axis=0, prepend=means[:1])) > _CHANGE * largest).any(axis=1)
        begins = np.array([prediction.times[row][0] for row in rows])
        since = begins - np.maximum.accumulate(np.where(changed, begins, -np.inf))
        starts += (since < _START - 1e-9).tolist()
        measured += [prediction.measured[row].mean(axis=0) for row in rows]
        modelled += means.tolist()
        held_out += [prediction.times[row][0] > prediction.held_out for row in rows]
    drives, turns = (np.abs(np.array(modelled)) > _SLOW * largest).T
    started = np.array(starts)
    return _Windows(np.array(measured), np.array(modelled), np.array(held_out), {
        'turning on the spot': turns & ~drives & ~started, 'driving': drives & ~started,
        'starting and braking': started})


def _rms(values: Floats) -> Floats:
    found: Floats = np.sqrt(np.mean(values**2, axis=0))
    return found


def judge(predictions: Sequence[Prediction]) -> Judgement:
    """Judge a model by the share of the motion that it misses where it was held out; by regime, in all recordings."""
    windows = _windows(predictions)
    usual, held_out = _rms(windows.measured), windows.held_out

    def shares(which: Mask) -> tuple[float, float]:
        missed = _rms(windows.measured[which] - windows.modelled[which]) / np.maximum(usual, 1e-12)
        # a robot that never turns has no share of it
        v, omega = np.where(usual > _STANDS, missed, 0.0)
        return float(v), float(omega)

    whole = shares(held_out if held_out.any() else np.ones(held_out.size, bool))
    grade = next((name for name, most in LARGEST.items() if max(whole) < most), UNUSABLE)
    return Judgement(grade, whole, {
        name: shares(which) for name, which in windows.regimes.items() if which.sum() >= _FEWEST})


def slip_with_curvature(predictions: Sequence[Prediction], model: str = 'the model') -> Iterator[str]:
    """Yield the turn on the spot beside that in curves, in turns of a model, where they differ."""
    windows = _windows(predictions)
    gains = []
    for regime in ('turning on the spot', 'driving'):
        which = windows.regimes[regime]
        if which.sum() >= _FEWEST:
            modelled, measured = windows.modelled[which, 1], windows.measured[which, 1]
            power = float(modelled @ modelled) + 1e-12
            gain = float(modelled @ measured) / power
            gains.append((gain, float(_rms(measured - gain * modelled)) / np.sqrt(power)))
    if len(gains) == 2:
        (spot, spot_error), (curve, curve_error) = gains
        if abs(spot - curve) > max(_UNLIKE, _SURE * float(np.hypot(spot_error, curve_error))):
            yield (f'the robot turns {spot:.2f} times as far as {model} on the spot, and {curve:.2f} times in '
                   'curves: its slip depends on the curvature')


def with_judgement(result: Identification, contradicts: bool = False) -> Identification:
    """
    Judge a result; widen the intervals of a model that fails a test by its error; an unusable one has none.

    No result is good where the twist of odometry contradicts its poses.
    """
    judgement = judge(result.predictions)
    if contradicts and judgement.grade == GOOD:
        judgement = judgement._replace(grade=USABLE)
    result = result._replace(judgement=judgement, lacking=(*result.lacking, *slip_with_curvature(result.predictions)))
    if judgement.grade == UNUSABLE:
        def unknown(parameter: Parameter) -> Parameter:
            return parameter._replace(low=np.nan, high=np.nan)

        return result._replace(parameters=tuple(map(unknown, result.parameters)), names=(), covariance=np.zeros((0, 0)),
                               reported=tuple(map(unknown, result.reported)))
    if judgement.grade == GOOD and not result.lacking:
        return result
    parameters = tuple(_widened(one, result) for one in result.parameters)
    half = {one.name: 0.5 * (one.high - one.low) for one in parameters}
    more = [(half[name] / Z95)**2 - variance for name, variance in zip(
        result.names, np.diag(result.covariance).tolist(), strict=True)]
    return result._replace(
        parameters=parameters, covariance=result.covariance + np.diag(np.maximum(more, 0.0)),
        reported=tuple(_widened(one, result) for one in result.reported),
        judgement=judgement._replace(widened=True))


def _widened(parameter: Parameter, result: Identification) -> Parameter:
    """Widen an interval by the share of the motion that the model misses: a lag and a dead time share theirs."""
    scale, least = abs(parameter.value), -np.inf
    for n in ('[0]', '[1]'):
        times = [f'plant.base.lag{n}', f'plant.base.dead_time{n}']
        if parameter.name in times:
            scale, least = sum(other.value for other in result.parameters if other.name in times), 0.0
    more = result.judgement.error * scale
    return parameter._replace(low=max(least, parameter.value - np.hypot(parameter.value - parameter.low, more)),
                              high=parameter.value + np.hypot(parameter.high - parameter.value, more))
