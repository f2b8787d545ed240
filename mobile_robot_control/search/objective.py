"""The objective of a search: Eq. (29) of each individual over all scenarios."""

import math
import statistics
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.control.compensation import lead
from mobile_robot_control.control.laws import declared_gains
from mobile_robot_control.control.velocity_pi import is_stable
from mobile_robot_control.loop.indices import objective
from mobile_robot_control.loop.scenarios import Scenario, configured_scenario, scenario_trial
from mobile_robot_control.loop.ticks import driving_start
from mobile_robot_control.loop.trial import Outcome, Trial
from mobile_robot_control.search import space
from mobile_robot_control.search.genetic import Points, Scores
from mobile_robot_control.search.search import WORST
from mobile_robot_control.search.space import VELOCITY, Gains, Gene
from mobile_robot_control.settings.nodes import Configuration

RunTrials = Callable[[Sequence[Trial]], list[Outcome]]
_SEEDS = 20
DEFAULT_SMOOTH = {'torque': 0.0, 'velocity': 0.5}
"""Default of `Goal.smooth` by kind of plant: Eq. (29) has a term for the torque, but none for the command."""
COMBINATIONS: dict[str, Callable[[Sequence[float]], float]] = {'mean': statistics.fmean, 'worst': max}


class Goal(NamedTuple):
    """
    The target of a search.

    Attributes
    ----------
    controller : str
        Target of the search, of SEARCHES.
    genes : tuple of Gene
        With their bounds.
    scenarios : tuple of Scenario
        The scenarios of every individual.
    laps : float
        Length of each run.
    combine : str
        'mean' or 'worst' of the scenarios.
    literal : bool
        True takes max τ in Eq. (29) as printed; False takes max |τ|.
    smooth : float
        Weight of the variation per second, added to Eq. (29): of the torques of both wheels [s/(N m)] or, for a base
        that takes velocities, of the rim speeds in commands [s²/m].
    """

    controller: str
    genes: tuple[Gene, ...]
    scenarios: tuple[Scenario, ...]
    laps: float = 1.0
    combine: str = 'mean'
    literal: bool = False
    smooth: float = 0.0


class Better(NamedTuple):
    """
    The better ones of found and configured gains.

    Attributes
    ----------
    gains : Gains
        The better ones.
    found, configured : float
        Both scores.
    """

    gains: Gains
    found: float
    configured: float

    @property
    def as_configured(self) -> bool:
        """Whether the configured ones are better."""
        return self.configured < self.found

    @property
    def score(self) -> float:
        """Of the better ones."""
        return self.configured if self.as_configured else self.found

    def text(self, generations: int) -> str:
        """Return which ones are better, as a sentence."""
        after = f'after {generations} generation{"s" * (generations != 1)}'
        if self.as_configured:
            return (f'the configured gains are better and stay: objective {self.configured:.6g}, and {self.found:.6g} '
                    f'was found {after}')
        before = 'those configured fail' if not self.configured < WORST else f'{self.configured:.6g} as configured'
        return f'the gains found are better: objective {self.found:.6g} {after}, {before}'


def is_random(configuration: Configuration) -> bool:
    """Return whether runs of a checked configuration depend on the seed."""
    model = configuration.plant.model
    noise, odometry = model.imperfections.noise, model.odometry
    return any((*noise.pose, noise.velocity, model.base.command_jitter, odometry.jitter,
                odometry.dead_reckoning and odometry.slip))


class Objective:
    """
    Scores generations of a search.

    Parameters
    ----------
    configuration : Configuration
        The loop for the gains, checked.
    goal : Goal
        Target of the optimisation.
    run : callable
        Runs trials, on any number of cores or machines.
    """

    def __init__(self, configuration: Configuration, goal: Goal, run: RunTrials) -> None:
        self._shared, self._goal, self._run = configuration.plant.shared, goal, run
        self._gains = space.configured_gains(configuration)
        trials = [scenario_trial(configuration, scenario, goal.laps, 0.0) for scenario in goal.scenarios]
        self._trials = [one._replace(form=one.form._replace(varies=goal.smooth > 0.0)) for one in trials]
        if goal.controller != VELOCITY:
            self._gains = self._gains._replace(control=self._gains.control._replace(controller_type=goal.controller))
        # velocity gains outside the search have been checked with the configuration
        self._checks_velocity = any(gene.name.startswith('velocity_controller.') for gene in goal.genes)

    def gains(self, point: Sequence[float]) -> Gains:
        """Return the gains of a point in (0, 1]; they may make the velocity loop unstable."""
        return space.decode(self._goal.genes, point, self._gains)

    def __call__(self, points: Points) -> Scores:
        """
        Return the scores of a generation, shape (individuals,).

        Points have the shape (individuals, genes) and lie in (0, 1]. A score is WORST if the gains break a rule of
        their law or cannot be prepared, if the velocity loop is unstable at its rate, or if the motion diverges in a
        scenario.
        """
        scores = np.full(len(points), WORST)
        tried = [(n, gains) for n, gains in enumerate(map(self.gains, points.tolist())) if self._can_run(gains)]
        outcomes = self._run([trial for _, gains in tried for trial in self._with(gains)])
        size = len(self._trials)
        for place, (n, _) in enumerate(tried):
            scores[n] = self._score(outcomes[place * size:(place + 1) * size])
        return scores

    def score(self, gains: Gains) -> float:
        """Return the score of one controller, as in a generation."""
        return self._score(self._run(self._with(gains)))

    def better(self, found: Gains) -> 'Better':
        """Return the better ones of found gains and of those configured, which no search has to reach."""
        scores = self.score(found), self.score(self._gains)
        return Better(self._gains if scores[1] < scores[0] else found, *scores)

    def spread(self, configuration: Configuration) -> tuple[float, ...]:
        """Return the RMS errors [m] of the configured run over some seeds, ascending; () without noise."""
        if not is_random(configuration):
            return ()
        scenario = configured_scenario(configuration)
        trials = [scenario_trial(configuration, scenario._replace(noise=scenario.noise._replace(seed=seed)),
                                 self._goal.laps, 0.0)._replace(form=self._trials[0].form) for seed in range(_SEEDS)]
        # a diverged run has no error to compare
        return tuple(sorted(math.sqrt(outcome.totals.squared_position / outcome.totals.time)
                            if outcome.steps == trial.steps else math.inf
                            for trial, outcome in zip(trials, self._run(trials), strict=True)))

    def _can_run(self, gains: Gains) -> bool:
        """Return whether the gains keep their rules and the velocity loop is stable."""
        shared = self._shared
        return not space.violations(self._goal.genes, gains) and (
            not self._checks_velocity
            or is_stable(gains.velocity, shared.robot, shared.velocity_rate, shared.lockstep))

    def _with(self, gains: Gains) -> list[Trial]:
        """Return the trials of one controller, one a scenario."""
        law, law_gains = declared_gains(gains.control)
        return [
            trial._replace(
                law=law.name,
                loop=trial.loop._replace(
                    velocity_gains=gains.velocity, law_gains=law_gains, lead=lead(gains.control.feedforward)),
                state=trial.state._replace(law=driving_start(law, trial.form)),
            )
            for trial in self._trials
        ]

    def _score(self, outcomes: Sequence[Outcome]) -> float:
        """Combine the objectives of all scenarios."""
        scored = [
            self._one_score(outcome, trial.loop.plant.dt) if outcome.steps == trial.steps else WORST
            for outcome, trial in zip(outcomes, self._trials, strict=True)
        ]
        # a failed run makes the mean over the scenarios meaningless
        return WORST if WORST in scored else COMBINATIONS[self._goal.combine](scored)

    def _one_score(self, outcome: Outcome, dt: float) -> float:
        """Return Eq. (29) of a complete run, plus the weighted variation."""
        score = objective(outcome.totals, self._goal.literal)
        if self._goal.smooth > 0.0:
            score += self._goal.smooth * outcome.variation / (outcome.steps * dt)
        return score
