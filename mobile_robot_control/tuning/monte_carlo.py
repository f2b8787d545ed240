"""What many random runs say: success rate with its interval, median, 95 % and worst case."""

import math
import statistics
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.model.noise import Noise
from mobile_robot_control.quantities import Pose
from mobile_robot_control.simulation.totals import objective
from mobile_robot_control.simulation.trial import Outcome, Trial
from mobile_robot_control.tuning.scenarios import Scenario

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
    'objective': lambda o: objective(o.totals, False),
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


def summarise_runs(judged: Sequence[Judged]) -> dict[str, Any]:
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


class ScenarioDistribution(NamedTuple):
    """
    From what random scenarios are drawn.

    Attributes
    ----------
    curves : tuple of str
        Each as likely as the others.
    scales : tuple of float
        Likewise [m].
    within : float
        Largest distance of the start from the cart's [m]; the heading is any.
    variation : float
        Largest relative change of mass (with the inertia) and of friction.
    noise : Noise
        Of all; the seeds are drawn.
    longest_delay : int
        Delays are drawn from 0 up to it.

    """

    curves: tuple[str, ...]
    scales: tuple[float, ...]
    within: float = 1.0
    variation: float = 0.2
    noise: Noise = Noise()
    longest_delay: int = 0


def draw_scenarios(spread: ScenarioDistribution, count: int, seed: int) -> list[Scenario]:
    """
    Draw random scenarios.

    Parameters
    ----------
    spread : Spread
        From what.
    count : int
        How many.
    seed : int
        The same seed, the same scenarios; a longer list begins with the shorter one.

    Returns
    -------
    list of Scenario
        Starts are spread evenly over the disc.

    """
    rng = np.random.default_rng(seed)
    drawn = []
    for _ in range(count):
        curve, scale, radius, angle, heading, mass, friction, noise, delay = rng.random(9).tolist()
        distance, direction = spread.within * math.sqrt(radius), 2.0 * math.pi * angle
        drawn.append(Scenario(
            spread.curves[int(curve * len(spread.curves))],
            spread.scales[int(scale * len(spread.scales))],
            Pose(distance * math.cos(direction), distance * math.sin(direction), math.pi * (1.0 - 2.0 * heading)),
            1.0 + spread.variation * (2.0 * mass - 1.0),
            1.0 + spread.variation * (2.0 * friction - 1.0),
            spread.noise._replace(seed=int(noise * 2**32)),
            int(delay * (spread.longest_delay + 1)),
        ))
    return drawn
