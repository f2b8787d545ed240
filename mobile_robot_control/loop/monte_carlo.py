"""Monte Carlo studies: random scenarios, and success rate, median, 95 % quantile and worst case over many runs."""

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.elementary import sin_cos
from mobile_robot_control.loop.indices import Totals, index_values, objective
from mobile_robot_control.loop.metric_table import BAND, INDICES, METRIC_TABLE
from mobile_robot_control.loop.scenarios import Scenario
from mobile_robot_control.loop.trial import Outcome, Trial, outcome_name
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.quantities import Pose

LARGEST_SEED = 2**64 - 1
WITHIN = 0.10
"""[m]: by default, the limit of the distance to the reference, from the late step on, in a successful run."""

CONFIDENCE = 0.95
"""Confidence of every interval of a study."""


class Judged(NamedTuple):
    """
    Success and metrics of one run.

    Attributes
    ----------
    success : bool
        Whether the run was complete and near the reference late in it.
    metrics : dict of str to float
        SI units; infinite if the motion diverged, and for the settling time of an error that does not settle; nan for
        the torque and energy of a base without torques.
    outcome : str
        'completed', 'diverged' or 'law_failed'.
    """

    success: bool
    metrics: dict[str, float]
    outcome: str = 'completed'


def _rms(integral: float, time: float) -> float:
    """Return the root mean square of a quantity from the integral of its square."""
    return math.sqrt(integral / time) if time > 0.0 else math.inf


def _of_torque(value: float, totals: Totals) -> float:
    """Return a value; nan for a run without torques."""
    return value if totals.highest_right > -math.inf else math.nan


_METRICS: dict[str, Callable[[Outcome], float]] = {
    'rms_position_error': lambda o: _rms(o.totals.squared_position, o.totals.time),
    'max_position_error': lambda o: o.totals.max_position,
    'late_max_position_error': lambda o: o.late.max_position,
    'rms_heading_error': lambda o: _rms(o.totals.squared_heading, o.totals.time),
    'peak_wheel_torque': lambda o: _of_torque(max(o.totals.peak_right, o.totals.peak_left), o.totals),
    'energy': lambda o: _of_torque(o.totals.energy, o.totals),
    'objective': lambda o: objective(o.totals, False),
}


METRICS = (*_METRICS, *INDICES)
"""The names of all metrics of a study."""


def metric_labels(band: float = BAND) -> dict[str, tuple[str, str]]:
    """Return label and SI unit of each metric of a study; `band` [m] is the limit of a settled error."""
    return {name: (METRIC_TABLE[name].label_in(band), METRIC_TABLE[name].unit) for name in METRICS}


def judge(trial: Trial, outcome: Outcome, within: float = WITHIN) -> Judged:
    """
    Judge a trial: its success, and its metrics; with the performance indices if its form has them.

    It succeeds if it is complete, and nearer to the reference than `within` [m] from the late step on.
    """
    complete = outcome.steps == trial.steps
    found = {name: value(outcome) if complete else math.inf for name, value in _METRICS.items()}
    if trial.form.indices:
        takes_torque = not trial.form.plant.takes_velocity
        found |= index_values(outcome.indices, outcome.totals, takes_torque) if complete else dict.fromkeys(
            INDICES, math.inf)
    return Judged(complete and outcome.late.max_position < within, found, outcome_name(trial, outcome))


def wilson_interval(successes: int, runs: int) -> tuple[float, float]:
    """
    Return the bounds of Wilson's score interval, which contains the true success rate with 95 % confidence.

    Examples
    --------
    >>> [round(bound, 4) for bound in wilson_interval(99, 100)]
    [0.9455, 0.9982]

    """
    z = statistics.NormalDist().inv_cdf(0.5 + 0.5 * CONFIDENCE)
    rate, spread = successes / runs, z * z / runs
    centre = rate + 0.5 * spread
    half = math.sqrt(spread * (rate * (1.0 - rate) + 0.25 * spread))
    return max(0.0, (centre - half) / (1.0 + spread)), min(1.0, (centre + half) / (1.0 + spread))


def success_text(name: str, summary: Mapping[str, Any]) -> str:
    """Describe the success of a controller, from the result of `summarise_runs`."""
    low, high = (100.0 * bound for bound in summary['success_interval'])
    return (f'{name}: {100.0 * summary["success_rate"]:.2f} % of {summary["runs"]} runs succeed '
            f'(95 % interval {low:.2f} to {high:.2f} %)')


def summarise_runs(judged: Sequence[Judged]) -> dict[str, Any]:
    """Return the statistics of one controller's runs, at least one, as in `study.json`; non-finite values are None."""
    successes = sum(run.success for run in judged)
    return {
        'runs': len(judged),
        'successes': successes,
        'success_rate': successes / len(judged),
        'success_interval': list(wilson_interval(successes, len(judged))),
        'metrics': {name: _quantiles([run.metrics[name] for run in judged], METRIC_TABLE[name].better == 'larger')
                    for name in judged[0].metrics},
    }


def _quantiles(values: Sequence[float], larger_is_better: bool) -> dict[str, float | None]:
    """Return median, 95 % quantile and worst of some values; None for infinite or unknown ones."""
    ordered = sorted(values, key=lambda value: -value if larger_is_better and value < math.inf else value)

    def at(fraction: float) -> float | None:
        value = ordered[math.ceil(fraction * len(ordered)) - 1]
        return value if math.isfinite(value) and not any(map(math.isnan, ordered)) else None

    return {'median': at(0.5), '95_percent': at(0.95), 'worst': at(1.0)}


class ScenarioDistribution(NamedTuple):
    """
    The distribution of random scenarios.

    Attributes
    ----------
    curves : tuple of str
        All equally likely.
    scales : tuple of float
        All equally likely [m].
    within : float
        Largest distance of the robot's start from the cart's [m]; the heading is uniform in [-π, π].
    variation : float
        Largest relative change of mass and inertia together, and of friction.
    noise : Noise
        Of all scenarios; the seeds are drawn.
    longest_delay : int
        Delays are drawn between 0 and this one [periods of the velocity loop].
    """

    curves: tuple[str, ...]
    scales: tuple[float, ...]
    within: float = 1.0
    variation: float = 0.2
    noise: Noise = Noise()
    longest_delay: int = 0


def draw_scenarios(distribution: ScenarioDistribution, count: int, seed: int) -> list[Scenario]:
    """
    Draw random scenarios, with starts uniform over the disc.

    The same seed gives the same scenarios; a longer list begins with the shorter one.
    """
    rng = np.random.default_rng(seed)
    drawn = []
    for _ in range(count):
        curve, scale, radius, angle, heading, mass, friction, noise, delay = rng.random(9).tolist()
        distance, (sine, cosine) = distribution.within * math.sqrt(radius), sin_cos(2.0 * math.pi * angle)
        drawn.append(Scenario(
            distribution.curves[int(curve * len(distribution.curves))],
            distribution.scales[int(scale * len(distribution.scales))],
            Pose(distance * cosine, distance * sine, math.pi * (1.0 - 2.0 * heading)),
            1.0 + distribution.variation * (2.0 * mass - 1.0),
            1.0 + distribution.variation * (2.0 * friction - 1.0),
            distribution.noise._replace(seed=int(noise * 2**32)),
            int(delay * (distribution.longest_delay + 1)),
        ))
    return drawn
