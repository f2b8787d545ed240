"""Monte Carlo studies: random scenarios, and success rate, median, 95 % quantile and worst case over many runs."""

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.elementary import sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.loop.indices import Totals, index_row, objective
from mobile_robot_control.loop.metric_table import BAND, INDICES, METRIC_TABLE
from mobile_robot_control.loop.scenarios import Scenario
from mobile_robot_control.loop.ticks import Form
from mobile_robot_control.loop.trial import Outcome, Trial
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.quantities import Pose

Floats = NDArray[np.float64]
LARGEST_SEED = 2**64 - 1
WITHIN = 0.10
"""[m]: by default, the limit of the distance to the reference, from the late step on, in a successful run."""

CONFIDENCE = 0.95
"""Confidence of every interval of a study."""


OUTCOMES = ('completed', 'diverged', 'law_failed')
"""Ends of a run, in the order of their numbers in a row."""


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
        Of OUTCOMES.
    """

    success: bool
    metrics: dict[str, float]
    outcome: str = 'completed'


class JudgedRuns(Sequence[Judged]):
    """
    Judged runs as columns.

    Parameters
    ----------
    success : array of bool, shape (runs,)
        As in `Judged`, as are the others.
    metrics : dict of str to array of float, each of shape (runs,)
        By name.
    outcome : array of str, shape (runs,)
        Of OUTCOMES.
    """

    def __init__(self, success: NDArray[np.bool_], metrics: dict[str, Floats], outcome: NDArray[np.str_]) -> None:
        self.success, self.metrics, self.outcome = success, metrics, outcome

    @classmethod
    def of(cls, runs: Sequence[Judged]) -> 'JudgedRuns':
        """Return runs as columns, unchanged if they are."""
        if isinstance(runs, cls):
            return runs
        names = runs[0].metrics if runs else ()
        return cls(np.array([one.success for one in runs], bool),
                   {name: np.array([one.metrics[name] for one in runs]) for name in names},
                   np.array([one.outcome for one in runs], str))

    @classmethod
    def of_rows(cls, rows: Floats) -> 'JudgedRuns':
        """Return the runs of rows of a `make_judge`, shape (runs, columns)."""
        return cls(rows[:, 0] != 0.0, dict(zip(METRICS, rows[:, 2:].T.copy(), strict=False)),
                   np.array(OUTCOMES)[rows[:, 1].astype(int)])

    def __len__(self) -> int:
        return len(self.success)

    def chosen(self, which: Any) -> 'JudgedRuns':
        """Return the runs of a mask, of indices or of a slice."""
        return JudgedRuns(self.success[which], {name: column[which] for name, column in self.metrics.items()},
                          self.outcome[which])

    def __getitem__(self, n: Any) -> Any:
        if isinstance(n, slice):
            return self.chosen(n)
        return Judged(bool(self.success[n]), {name: float(column[n]) for name, column in self.metrics.items()},
                      str(self.outcome[n]))


@jitable
def _rms(integral: float, time: float) -> float:
    """Return the root mean square of a quantity from the integral of its square."""
    return math.sqrt(integral / time) if time > 0.0 else math.inf


@jitable
def _metric_row(totals: Totals, late: Totals) -> tuple[float, ...]:
    """Return the values of _METRICS."""
    has_torque = totals.highest_right > -math.inf
    return (
        _rms(totals.squared_position, totals.time),
        totals.max_position,
        late.max_position,
        _rms(totals.squared_heading, totals.time),
        max(totals.peak_right, totals.peak_left) if has_torque else math.nan,
        totals.energy if has_torque else math.nan,
        objective(totals, False),
    )


_METRICS = ('rms_position_error', 'max_position_error', 'late_max_position_error', 'rms_heading_error',
            'peak_wheel_torque', 'energy', 'objective')
METRICS = (*_METRICS, *INDICES)
"""The names of all metrics of a study."""


def metric_labels(band: float = BAND) -> dict[str, tuple[str, str]]:
    """Return label and SI unit of each metric of a study; `band` [m] is the limit of a settled error."""
    return {name: (METRIC_TABLE[name].label_in(band), METRIC_TABLE[name].unit) for name in METRICS}


@lru_cache(maxsize=16)
def make_judge(form: Form) -> Callable[[Outcome, int, float], tuple[float, ...]]:
    """
    Make the function ``(outcome, steps, within)`` that judges an outcome of so many steps, plain or compiled.

    A run succeeds if it is complete, and nearer to the reference than `within` [m] from the late step on. The row has
    1 or 0 for success, the number of its end among OUTCOMES, and its metrics, infinite if the run is not complete;
    among them the performance indices if the form has them.
    """
    takes_torque = not form.plant.takes_velocity

    def indexed(outcome: Outcome) -> tuple[float, ...]:
        return _metric_row(outcome.totals, outcome.late) + index_row(outcome.indices, outcome.totals, takes_torque)

    def plain(outcome: Outcome) -> tuple[float, ...]:
        return _metric_row(outcome.totals, outcome.late)

    row = jitable(indexed if form.indices else plain)
    failed, diverged = ((0.0, end, *[math.inf] * len(METRICS if form.indices else _METRICS)) for end in (2.0, 1.0))

    @jitable
    def judged(outcome: Outcome, steps: int, within: float) -> tuple[float, ...]:
        if outcome.law_failed:
            return failed
        if outcome.steps != steps:
            return diverged
        return (1.0 if outcome.late.max_position < within else 0.0, 0.0) + row(outcome)

    return judged


def judge(trial: Trial, outcome: Outcome, within: float = WITHIN) -> Judged:
    """Judge a trial as `make_judge` does."""
    success, end, *metrics = make_judge(trial.form)(outcome, trial.steps, within)
    return Judged(success != 0.0, dict(zip(METRICS, metrics, strict=False)), OUTCOMES[int(end)])


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
    runs = JudgedRuns.of(judged)
    successes = int(np.count_nonzero(runs.success))
    return {
        'runs': len(runs),
        'successes': successes,
        'success_rate': successes / len(runs),
        'success_interval': list(wilson_interval(successes, len(runs))),
        'metrics': {name: _quantiles(values, METRIC_TABLE[name].better == 'larger')
                    for name, values in runs.metrics.items()},
    }


def _quantiles(values: Floats, larger_is_better: bool) -> dict[str, float | None]:
    """Return median, 95 % quantile and worst of some values; None for infinite or unknown ones."""
    is_known = not np.isnan(values).any()
    # an infinite one is the worst, whichever way is better
    ordered = np.sort(np.where(values < math.inf, -values, values) if larger_is_better else values)

    def at(fraction: float) -> float | None:
        value = float(ordered[math.ceil(fraction * len(ordered)) - 1])
        return (-value if larger_is_better else value) if is_known and math.isfinite(value) else None

    return {'median': at(0.5), '95_percent': at(0.95), 'worst': at(1.0)}


class Scenarios(Sequence[Scenario]):
    """
    Scenarios as columns.

    Parameters
    ----------
    curve, scale : array of str and of float, shape (runs,)
        As in `Scenario`, as are the others.
    start : array of float, shape (runs, 3)
        Offsets x, y [m] and heading [rad].
    mass, friction : array of float, shape (runs,)
        Factors.
    noise : Noise
        Of all, with `seed`.
    seed, delay : array of int, shape (runs,)
        Of the noise, and of the torques [velocity periods].
    robot_names : tuple of str
        Parameters of the plant that differ.
    robots : array of float, shape (runs, names)
        Their values.
    """

    def __init__(
        self, curve: NDArray[np.str_], scale: Floats, start: Floats, mass: Floats, friction: Floats, noise: Noise,
        seed: NDArray[np.int64], delay: NDArray[np.int64], robot_names: tuple[str, ...] = (),
        robots: Floats | None = None,
    ) -> None:
        self.curve, self.scale, self.start, self.mass, self.friction = curve, scale, start, mass, friction
        self.noise, self.seed, self.delay, self.robot_names = noise, seed, delay, robot_names
        self.robots = np.empty((len(curve), 0)) if robots is None else robots

    @classmethod
    def of(cls, scenarios: Sequence[Scenario]) -> 'Scenarios':
        """Return scenarios as columns, unchanged if they are; the configured start is an offset of 0."""
        if isinstance(scenarios, cls):
            return scenarios
        curve, scale, start, mass, friction, noise, delay, robot = zip(*scenarios, strict=True)
        return cls(
            np.array(curve), np.array(scale), np.array([one or (0.0, 0.0, 0.0) for one in start]), np.array(mass),
            np.array(friction), noise[0], np.array([one.seed for one in noise]), np.array(delay),
            tuple(name for name, _ in robot[0]), np.array([[value for _, value in one] for one in robot]))

    def __len__(self) -> int:
        return len(self.curve)

    def chosen(self, which: Any) -> 'Scenarios':
        """Return the scenarios of a mask, of indices or of a slice."""
        return Scenarios(self.curve[which], self.scale[which], self.start[which], self.mass[which],
                         self.friction[which], self.noise, self.seed[which], self.delay[which], self.robot_names,
                         self.robots[which])

    def __getitem__(self, n: Any) -> Any:
        if isinstance(n, slice):
            return self.chosen(n)
        return Scenario(
            str(self.curve[n]), float(self.scale[n]), Pose(*self.start[n].tolist()), float(self.mass[n]),
            float(self.friction[n]), self.noise._replace(seed=int(self.seed[n])), int(self.delay[n]),
            tuple(zip(self.robot_names, self.robots[n].tolist(), strict=True)))


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


def draw_scenarios(distribution: ScenarioDistribution, count: int, seed: int) -> Scenarios:
    """
    Draw random scenarios, with starts uniform over the disc.

    The same seed gives the same scenarios; a longer list begins with the shorter one.
    """
    drawn = np.random.default_rng(seed).random((count, 9))
    curve, scale, radius, angle, heading, mass, friction, noise, delay = drawn.T
    distances, directions = distribution.within * np.sqrt(radius), map(sin_cos, (2.0 * math.pi * angle).tolist())
    sines, cosines = np.array([*directions]).reshape(-1, 2).T

    def one_of(values: tuple[object, ...], share: Floats) -> NDArray[Any]:
        return np.take(np.array(values), (share * len(values)).astype(int))

    return Scenarios(
        one_of(distribution.curves, curve), one_of(distribution.scales, scale),
        np.column_stack([distances * cosines, distances * sines, math.pi * (1.0 - 2.0 * heading)]),
        1.0 + distribution.variation * (2.0 * mass - 1.0), 1.0 + distribution.variation * (2.0 * friction - 1.0),
        distribution.noise, (noise * 2**32).astype(np.int64),
        (delay * (distribution.longest_delay + 1)).astype(np.int64))
