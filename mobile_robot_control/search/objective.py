"""The objective of a search: Eq. (29) or the RMS error of each individual over all scenarios."""

import math
import statistics
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.control.compensation import lead
from mobile_robot_control.control.laws import declared_gains
from mobile_robot_control.control.velocity_law import PI
from mobile_robot_control.control.velocity_laws import selected_velocity_law, velocity_is_stable
from mobile_robot_control.control.velocity_stability import make_settling
from mobile_robot_control.loop.batch import compiled
from mobile_robot_control.loop.indices import objective
from mobile_robot_control.loop.scenarios import Scenario, configured_scenario, scenario_trial
from mobile_robot_control.loop.ticks import driving_start
from mobile_robot_control.loop.trial import LoopGains, Outcome, Trial, VariedTrials
from mobile_robot_control.search import space
from mobile_robot_control.search.gains import Gains, configured_gains
from mobile_robot_control.search.genetic import LOWEST_POINT, WORST, Points, Scores
from mobile_robot_control.search.space import VELOCITY, Gene
from mobile_robot_control.settings.nodes import Configuration

RunTrials = Callable[[Sequence[Trial]], list[Outcome]]
_SEEDS = 20
_VELOCITY_NODE = 'velocity_controller.'
EQ29, RMS = 'eq29', 'rms_position_error'
_SMOOTH = {EQ29: {'torque': 0.0, 'velocity': 0.5}, RMS: {'torque': 0.0, 'velocity': 0.01}}
OBJECTIVES = tuple(_SMOOTH)
_HALVINGS = 12


def default_smooth(objective: str, drive: str) -> float:
    """
    Return the default of `Goal.smooth`.

    Eq. (29) has a term for the torque, but none for the command of a base, whose variation costs a few per cent of
    either objective.
    """
    return _SMOOTH[objective][drive]


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
    objective : str
        Of OBJECTIVES: Eq. (29), or the RMS position error [m].
    smooth : float
        Weight of the variation per second, added to the objective: of the torques of both wheels [s/(N m)] or, for a
        base that takes velocities, of the rim speeds in commands [s²/m].
    """

    controller: str
    genes: tuple[Gene, ...]
    scenarios: tuple[Scenario, ...]
    laps: float = 1.0
    combine: str = 'mean'
    literal: bool = False
    smooth: float = 0.0
    objective: str = EQ29


class Better(NamedTuple):
    """
    The better ones of found and configured gains.

    Attributes
    ----------
    gains : Gains
        The better ones.
    searched, configured : float
        Both scores.
    """

    gains: Gains
    searched: float
    configured: float

    @property
    def as_configured(self) -> bool:
        """Whether the configured ones are better."""
        return self.configured < self.searched

    @property
    def score(self) -> float:
        """Of the better ones."""
        return self.configured if self.as_configured else self.searched

    def text(self, generations: int) -> str:
        """Return which ones are better, as a sentence."""
        after = f'after {generations} generation{"s" * (generations != 1)}'
        if self.as_configured:
            return (f'the configured gains are better and stay: objective {self.configured:.6g}, and '
                    f'{self.searched:.6g} was found {after}')
        before = 'those configured fail' if not self.configured < WORST else f'{self.configured:.6g} as configured'
        return f'the gains found are better: objective {self.searched:.6g} {after}, {before}'


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

    Attributes
    ----------
    configured : Gains
        Those of the configuration.
    """

    def __init__(self, configuration: Configuration, goal: Goal, run: RunTrials) -> None:
        self._shared, self._goal, self._run = configuration.plant.shared, goal, run
        velocity = configuration.velocity_controller
        self._limit, step = velocity.max_wheel_torque, selected_velocity_law(velocity.control)[0].step
        # the PI law has an analysis of its own
        self._settling = None if velocity.control.controller_type == PI else compiled(make_settling(step), step)
        self.configured = configured_gains(configuration)
        trials = [scenario_trial(configuration, scenario, goal.laps, 0.0) for scenario in goal.scenarios]
        self._trials = [one._replace(form=one.form._replace(varies=goal.smooth > 0.0)) for one in trials]
        if goal.controller != VELOCITY:
            control = self.configured.control._replace(controller_type=goal.controller)
            self.configured = self.configured._replace(control=control)
        # velocity gains outside the search have been checked with the configuration
        self._checks_velocity = any(gene.name.startswith(_VELOCITY_NODE) for gene in goal.genes)

    def gains(self, point: Sequence[float]) -> Gains:
        """Return the gains of a point in (0, 1]; they may make the velocity loop unstable."""
        return space.decode(self._goal.genes, point, self.configured)

    def __call__(self, points: Points) -> Scores:
        """
        Return the scores of a generation, shape (individuals,).

        Points have the shape (individuals, genes) and lie in (0, 1]. A score is WORST if the gains break a rule of
        their law or cannot be prepared, if the velocity loop is unstable at its rate, or if the motion diverges in a
        scenario.
        """
        scores = np.full(len(points), WORST)
        tried = [(n, gains) for n, gains in enumerate(map(self.gains, points.tolist())) if self._can_run(gains)]
        outcomes = self._run(self._with([gains for _, gains in tried]))
        size = len(self._trials)
        for place, (n, _) in enumerate(tried):
            scores[n] = self._score(outcomes[place * size:(place + 1) * size])
        return scores

    def score(self, gains: Gains) -> float:
        """Return the score of one controller, as in a generation."""
        return self._score(self._run(self._with([gains])))

    def objectives(self, gains: Gains) -> dict[str, float]:
        """Return the mean of each objective over the scenarios of one controller, without the variation."""
        outcomes = self._run(self._with([gains]))
        return {name: statistics.fmean(_measure(outcome, name, self._goal.literal) for outcome in outcomes)
                for name in OBJECTIVES}

    def begin(self, points: Points) -> Points:
        """Return drawn points, shape (individuals, genes), with their velocity gains moved to where they are stable."""
        genes = self._goal.genes
        columns = [n for n, gene in enumerate(genes) if gene.name.startswith(_VELOCITY_NODE)]
        configured = [(number - genes[n].low) / (genes[n].high - genes[n].low) for n, number in zip(
            columns, space.numbers_of([genes[n] for n in columns], self.configured), strict=True)]
        towards, begun = np.clip(configured, LOWEST_POINT, 1.0), points.copy()
        for point in begun:
            for _ in range(_HALVINGS):
                if self._is_stable(self.gains(point.tolist())):
                    break
                point[columns] += 0.5 * (towards - point[columns])
        return begun

    def better(self, searched: Gains) -> 'Better':
        """Return the better ones of found gains and of those configured, which no search has to reach."""
        scores = self.score(searched), self.score(self.configured)
        return Better(self.configured if scores[1] < scores[0] else searched, *scores)

    def spread(self, configuration: Configuration) -> tuple[float, ...]:
        """Return the RMS errors [m] of the configured run over some seeds, ascending; () without noise."""
        if not is_random(configuration):
            return ()
        scenario = configured_scenario(configuration)
        trials = [scenario_trial(configuration, scenario._replace(noise=scenario.noise._replace(seed=seed)),
                                 self._goal.laps, 0.0)._replace(form=self._trials[0].form) for seed in range(_SEEDS)]
        # a diverged run has no error to compare
        return tuple(sorted(_measure(outcome, RMS, False)
                            if outcome.steps == trial.steps else math.inf
                            for trial, outcome in zip(trials, self._run(trials), strict=True)))

    def _can_run(self, gains: Gains) -> bool:
        """Return whether the gains keep their rules and the velocity loop is stable."""
        return not space.violations(self._goal.genes, gains) and self._is_stable(gains)

    def _is_stable(self, gains: Gains) -> bool:
        """Return whether the velocity loop is stable, or its gains are not searched."""
        shared = self._shared
        return not self._checks_velocity or velocity_is_stable(
            gains.velocity, shared.robot, self._limit, shared.velocity_rate, shared.lockstep, self._settling)

    def _with(self, several: Sequence[Gains]) -> VariedTrials:
        """Return the trials of controllers, those of each one a scenario."""
        loops = []
        for gains in several:
            law, law_gains = declared_gains(gains.control)
            loops.append(LoopGains(law.name, driving_start(law, self._trials[0].form),
                                   selected_velocity_law(gains.velocity)[1], law_gains,
                                   lead(gains.control.feedforward)))
        return VariedTrials(self._trials, loops)

    def _score(self, outcomes: Sequence[Outcome]) -> float:
        """Combine the objectives of all scenarios."""
        scored = [
            self._one_score(outcome, trial.loop.robot.plant.dt) if outcome.steps == trial.steps else WORST
            for outcome, trial in zip(outcomes, self._trials, strict=True)
        ]
        # a failed run makes the mean over the scenarios meaningless
        return WORST if WORST in scored else COMBINATIONS[self._goal.combine](scored)

    def _one_score(self, outcome: Outcome, dt: float) -> float:
        """Return the objective of a complete run, plus the weighted variation."""
        score = _measure(outcome, self._goal.objective, self._goal.literal)
        if self._goal.smooth > 0.0:
            score += self._goal.smooth * outcome.variation / (outcome.steps * dt)
        return score


def _measure(outcome: Outcome, name: str, literal: bool) -> float:
    """Return an objective of a run by name."""
    totals = outcome.totals
    return objective(totals, literal) if name == EQ29 else math.sqrt(totals.squared_position / totals.time)
