"""What many random runs say: success rate with its interval, median, 95 % and worst case."""

import math
import statistics
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.simulation import metrics
from mobile_robot_control.simulation.trial import Outcome, Trial

WITHIN = 0.10
"""[m]: a run succeeds when the robot stays this near to the reference from the late step on."""

_CONFIDENCE = 0.95


class Judged(NamedTuple):
    """
    One run.

    Attributes
    ----------
    success : bool
        Whether it came to its end and was near the reference late in it.
    metrics : dict of str to float
        SI units; infinite where the motion diverged.

    """

    success: bool
    metrics: dict[str, float]


def _root_mean(total: float, time: float) -> float:
    return math.sqrt(total / time) if time > 0.0 else math.inf


_METRICS: dict[str, Callable[[Outcome], float]] = {
    'rms_position_error': lambda o: _root_mean(o.totals.squared_position, o.totals.time),
    'max_position_error': lambda o: o.totals.max_position,
    'late_max_position_error': lambda o: o.late.max_position,
    'rms_heading_error': lambda o: _root_mean(o.totals.squared_heading, o.totals.time),
    'peak_wheel_torque': lambda o: max(o.totals.peak_right, o.totals.peak_left),
    'energy': lambda o: o.totals.energy,
    'objective': lambda o: metrics.objective(o.totals, False),
}


def judge(trial: Trial, outcome: Outcome) -> Judged:
    """
    Judge one run.

    Parameters
    ----------
    trial : Trial
        What was asked for.
    outcome : Outcome
        What it gave.

    Returns
    -------
    Judged
        Success and metrics.

    """
    complete = outcome.steps == trial.steps
    found = {name: value(outcome) if complete else math.inf for name, value in _METRICS.items()}
    return Judged(complete and outcome.late.max_position < WITHIN, found)


def interval(successes: int, runs: int) -> tuple[float, float]:
    """
    Give the interval in which the true success rate lies with 95 % confidence, by Wilson's formula.

    Parameters
    ----------
    successes, runs : int
        How many of how many.

    Returns
    -------
    tuple of float
        Low and high.

    Examples
    --------
    >>> [round(bound, 4) for bound in interval(99, 100)]
    [0.9455, 0.9982]

    """
    z = statistics.NormalDist().inv_cdf(0.5 + 0.5 * _CONFIDENCE)
    rate, spread = successes / runs, z * z / runs
    centre = rate + 0.5 * spread
    half = math.sqrt(spread * (rate * (1.0 - rate) + 0.25 * spread))
    return max(0.0, (centre - half) / (1.0 + spread)), min(1.0, (centre + half) / (1.0 + spread))


def summary(judged: Sequence[Judged]) -> dict[str, Any]:
    """
    Sum up the runs of one controller.

    Parameters
    ----------
    judged : sequence of Judged
        One at least.

    Returns
    -------
    dict of str to object
        Numbers as `study.json` has them; what is not finite is None.

    """
    successes = sum(run.success for run in judged)
    return {
        'runs': len(judged),
        'successes': successes,
        'success_rate': successes / len(judged),
        'success_interval': list(interval(successes, len(judged))),
        'metrics': {name: _quantiles([run.metrics[name] for run in judged]) for name in _METRICS},
    }


def _quantiles(values: Sequence[float]) -> dict[str, float | None]:
    ordered = sorted(values)

    def at(fraction: float) -> float | None:
        value = ordered[math.ceil(fraction * len(ordered)) - 1]
        return value if math.isfinite(value) else None

    return {'median': at(0.5), '95_percent': at(0.95), 'worst': at(1.0)}
