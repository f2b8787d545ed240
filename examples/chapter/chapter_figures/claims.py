"""The claims of the chapter, what is measured for each, and whether it holds."""

import math
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from chapter_figures.runs import (
    FUZZY_BESIDE,
    FUZZY_TRIFOLIUM,
    HYBRID_LEMNISCATE,
    LAP,
    ORDINARY_LEMNISCATE,
    ORDINARY_TRIFOLIUM,
    ChapterRun,
    Runs,
)
from mobile_robot_control.quantities import BodyVelocity
from mobile_robot_control.runs.words import peak_torque

RUNS = (FUZZY_BESIDE, FUZZY_TRIFOLIUM, HYBRID_LEMNISCATE, ORDINARY_LEMNISCATE, ORDINARY_TRIFOLIUM)
"""All runs that the claims are measured on."""
_CONSTANT_COMMAND = BodyVelocity(0.5, 1.0)
"""Whose steady-state error is measured [m/s], [rad/s]."""
_SETTLING_TIME = 60.0
"""[s]: several integral times of the printed gains."""


class Verdict(NamedTuple):
    """
    Whether a claim holds.

    Attributes
    ----------
    measured : str
        Numbers with units.
    holds : bool
        Whether the claim is true of these numbers.
    remark : str
        A condition or an explanation; '' for none.
    """

    measured: str
    holds: bool
    remark: str = ''


class Claim(NamedTuple):
    """
    A claim of the chapter.

    Attributes
    ----------
    where : str
        Section of the chapter.
    words : str
        The claim in brief.
    judge : callable
        Measures it on the chapter's runs.
    """

    where: str
    words: str
    judge: Callable[[Runs], Verdict]


def _peaks(runs: Runs, run: ChapterRun) -> dict[str, float]:
    """Return the largest absolute torque of either wheel [N m]."""
    found: dict[str, float] = runs.measured(run).metrics['peak_wheel_torque']
    return found


def _ordinary_exceeds(runs: Runs) -> Verdict:
    peaks = _peaks(runs, ORDINARY_LEMNISCATE)
    return Verdict(f'right {peaks["right"]:.0f}, left {peaks["left"]:.0f} N m', min(peaks.values()) > 50.0,
                   'at the first sample, which a slower motor would not follow')


def _ratio(runs: Runs, high: ChapterRun, low: ChapterRun, metric: str = 'peak_wheel_torque') -> float:
    """Return the ratio of a metric in two runs, each of the wheel with the larger value."""
    above, below = (max(runs.measured(run).metrics[metric].values()) for run in (high, low))
    return float(above / below)


def _hybrid_torques(runs: Runs) -> Verdict:
    ratio = _ratio(runs, ORDINARY_LEMNISCATE, HYBRID_LEMNISCATE)
    peak = peak_torque(runs.measured(HYBRID_LEMNISCATE).metrics) or math.inf
    return Verdict(f'{peak:.2f} N m, {ratio:.0f} times less', ratio > 10.0)


def _hybrid_power(runs: Runs) -> Verdict:
    ratio = _ratio(runs, ORDINARY_LEMNISCATE, HYBRID_LEMNISCATE, 'peak_wheel_power')
    peak = max(runs.measured(HYBRID_LEMNISCATE).metrics['peak_wheel_power'].values())
    return Verdict(f'{peak:.0f} W, {ratio:.0f} times less', ratio > 10.0)


def _fuzzy_torques(runs: Runs) -> Verdict:
    peaks = _peaks(runs, FUZZY_TRIFOLIUM)
    beside = max(_peaks(runs, FUZZY_BESIDE).values())
    return Verdict(f'right {peaks["right"]:.2f}, left {peaks["left"]:.2f} N m', max(peaks.values()) < 2.0,
                   f'but only if started on the curve: started beside it, {beside:.0f} N m')


def _fuzzy_ratio(runs: Runs) -> Verdict:
    ratio = _ratio(runs, ORDINARY_TRIFOLIUM, FUZZY_TRIFOLIUM)
    remark = '' if ratio <= 40.0 else 'more than claimed: the ordinary controller starts with a jump of its command'
    return Verdict(f'{ratio:.0f} times less', ratio >= 30.0, remark)


def _steady_state(runs: Runs) -> Verdict:
    last = None
    for tick in runs.velocity_steps(((0.0, _CONSTANT_COMMAND),), _SETTLING_TIME):
        last = tick
    if last is None:  # no time at all
        return Verdict('nothing', holds=False)
    asked = last.command
    errors = (asked.linear - last.velocity.linear, asked.angular - last.velocity.angular)
    return Verdict(f'{abs(errors[0]):.1g} m/s of {asked.linear:g}, {abs(errors[1]):.1g} rad/s of {asked.angular:g} '
                   f'after {_SETTLING_TIME:g} s', max(map(abs, errors)) < 1e-4,
                   'it decays with the integral times of a minute')


def _convergence(run: ChapterRun) -> Callable[[Runs], Verdict]:
    """Return the judge of whether the largest errors of each lap at least halve from lap to lap."""
    def judge(runs: Runs) -> Verdict:
        series = runs.measured(run).series
        ahead, aside, turned = (series.line('tracking_error', name) for name in ('longitudinal', 'lateral', 'heading'))
        laps = np.minimum(ahead.time // LAP, round(run.duration / LAP) - 1)
        distance, heading = (
            [float(np.abs(error[laps == lap]).max()) for lap in np.unique(laps)]
            for error in (np.hypot(ahead.value, aside.value), turned.value)
        )
        falls = all(after < 0.5 * before for errors in (distance, heading) for before, after in pairwise(errors))
        by_lap = '; '.join(f'lap {n}: {100.0 * most:.2g} cm, {turn:.2g} rad'
                           for n, (most, turn) in enumerate(zip(distance, heading, strict=True), 1))
        return Verdict(f'largest in {by_lap}', falls)

    return judge


def _fuzzy_tracks(runs: Runs) -> Verdict:
    metrics = runs.measured(FUZZY_TRIFOLIUM).metrics
    return Verdict(f'RMS {100.0 * metrics["rms_position_error"]:.1f} cm, at most '
                   f'{100.0 * metrics["max_position_error"]:.1f} cm on a curve of 1 m',
                   metrics['max_position_error'] < 0.1)


def _largest_speeds(runs: Runs, run: ChapterRun) -> tuple[float, float]:
    """Return the largest absolute commands [m/s], [rad/s]."""
    series = runs.measured(run).series
    return (float(np.abs(series.line('cmd_vel', 'linear').value).max()),
            float(np.abs(series.line('cmd_vel', 'angular').value).max()))


def _fuzzy_velocities(runs: Runs) -> Verdict:
    fuzzy, ordinary = (_largest_speeds(runs, run) for run in (FUZZY_TRIFOLIUM, ORDINARY_TRIFOLIUM))
    return Verdict(f'{fuzzy[0]:.2f} m/s and {fuzzy[1]:.2f} rad/s against {ordinary[0]:.2f} m/s and '
                   f'{ordinary[1]:.2f} rad/s', fuzzy[0] < 0.5 * ordinary[0] and fuzzy[1] < 0.5 * ordinary[1],
                   'started on the curve both ask for about what the cart does; the torques differ by the jump at '
                   't = 0')


CLAIMS = (
    Claim('2.2', 'the PI controller leaves no steady-state velocity error', _steady_state),
    Claim('3.1', "ordinary backstepping: the errors converge (lemniscate)", _convergence(ORDINARY_LEMNISCATE)),
    Claim('4.1', 'hybrid backstepping: the errors converge (lemniscate)', _convergence(HYBRID_LEMNISCATE)),
    Claim('4.1', 'ordinary backstepping: both torques exceed 50 N m (lemniscate)', _ordinary_exceeds),
    Claim('4.1', 'hybrid backstepping: much less torque (lemniscate)', _hybrid_torques),
    Claim('4.1', 'hybrid backstepping: much less power (lemniscate)', _hybrid_power),
    Claim('4.2', 'fuzzy: satisfactory tracking (trifolium)', _fuzzy_tracks),
    Claim('4.2', 'fuzzy: torques not above 2 N m (trifolium)', _fuzzy_torques),
    Claim('4.2', 'fuzzy: torques 30 to 40 times less than ordinary backstepping (trifolium)', _fuzzy_ratio),
    Claim('4.2', 'fuzzy: much smaller velocity commands than ordinary backstepping (trifolium)', _fuzzy_velocities),
)


def judged(runs: Runs) -> list[tuple[Claim, Verdict]]:
    """Return every claim with its verdict, in the chapter's order."""
    return [(claim, claim.judge(runs)) for claim in CLAIMS]


def rows(found: Iterable[tuple[Claim, Verdict]]) -> list[list[str]]:
    """Return the rows of a table with the columns of HEAD."""
    return [[claim.where, claim.words, verdict.measured,
             ('yes' if verdict.holds else 'no') + (f'; {verdict.remark}' if verdict.remark else '')]
            for claim, verdict in found]


HEAD = ('section', 'the chapter', 'measured here', 'holds')
