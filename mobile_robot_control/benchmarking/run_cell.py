"""The run of one cell of a benchmark: searches with each budget, and unseen scenarios that judge."""

import glob
import itertools
import math
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from mobile_robot_control.analysis.modelled import drive_of
from mobile_robot_control.benchmarking.cell import Cell
from mobile_robot_control.benchmarking.cell_result import (
    JUDGED,
    NOT_SEARCHED,
    BudgetResult,
    CellResult,
    DrivenPath,
    RunColumns,
    SearchEnd,
    gains_of,
)
from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.control.laws import LAWS, declared_gains, prepared_gains
from mobile_robot_control.control.tracking_error import distance
from mobile_robot_control.loop.closed_loop import Sample
from mobile_robot_control.loop.monte_carlo import judge
from mobile_robot_control.loop.scenarios import scenario_trial
from mobile_robot_control.loop.trial import Trial
from mobile_robot_control.model.plant import VELOCITY as DRIVEN_BY_VELOCITY
from mobile_robot_control.parameters.declaration import ParameterError, flatten
from mobile_robot_control.quantities import Observation, TrackingError
from mobile_robot_control.runs.rollout import trial_rollout
from mobile_robot_control.search import space
from mobile_robot_control.search.gains import Gains, configured_gains, rounded
from mobile_robot_control.search.journal import Journal
from mobile_robot_control.search.objective import Goal, Objective, RunTrials, default_smooth
from mobile_robot_control.search.search import SearchSettings, no_result
from mobile_robot_control.search.space import POPULATION, population_for, search_genes
from mobile_robot_control.search.stages import WIDENINGS, StagePlan, search_in_stages
from mobile_robot_control.settings.nodes import Configuration, course_of

LATE = 0.75
"""Share of a run after which its errors decide about success."""
_POINTS = 120
"""Points of a picture."""
_STEPS, _REPEATS = 300, 5


class Work(NamedTuple):
    """
    How a cell is run.

    Attributes
    ----------
    run : callable
        Runs trials.
    file : Path
        Where its result will be; journals lie beside.
    progress : callable
        Called with how many rollouts were done since the last time.
    stopped : callable
        Called before each generation; the cell ends if it returns True.
    """

    run: RunTrials
    file: Path
    progress: Callable[[int], object]
    stopped: Callable[[], bool]

    def journal(self, name: str) -> Path:
        """Return the journal of a search."""
        return self.file.with_suffix(f'.{name}.journal')

    def remove_journals(self) -> None:
        """Remove those of all searches."""
        for file in self.file.parent.glob(f'{glob.escape(self.file.stem)}.*.journal'):
            file.unlink()


def run_cell(cell: Cell, work: Work) -> CellResult | None:
    """Search with each budget and judge; return the result, None where it was stopped."""
    try:
        configuration = cell.configuration()
    except ParameterError as error:
        refused = cell.refused_horizon()
        reason = f'{NOT_SEARCHED}: {refused}' if refused else '; '.join(error.violations)
        return CellResult([BudgetResult(budget, reason) for budget in cell.budgets or (0,)])
    results = []
    gains, search, reason = configured_gains(configuration), None, ''
    genes: Any = search_genes(cell.law, True, drive_of(configuration),
                              configuration.velocity_controller.control.controller_type)
    for budget in cell.budgets or (0,):
        if budget and genes:
            searched = _searched(cell, configuration, genes, budget, work)
            if searched is None:
                return None
            gains, search, reason = searched
        if reason:
            failure = _failure(cell, configuration)[1]
            results.append(BudgetResult(budget, failure or f'{NOT_SEARCHED}: {reason}'))
        else:
            loop = with_gains(configuration, gains)
            judged = _judged(cell, loop, work)
            results.append(BudgetResult(budget, '' if any(judged.success) else _why(cell, loop), search,
                                        _named(genes, gains, cell.law), judged))
    return CellResult(results, _judged(cell, configuration, work) if cell.is_compared else None,
                      step_time(configuration), None if reason else _path(cell, with_gains(configuration, gains)))


def _searched(
    cell: Cell, configuration: Configuration, genes: Any, budget: int, work: Work
) -> tuple[Gains, SearchEnd | None, str] | None:
    """
    Search in stages; return the best gains, what the search has come to, and why there are none.

    None where it was stopped.
    """
    smooth = default_smooth(cell.objective, drive_of(configuration))
    goal = Goal(cell.law, genes, tuple(cell.drawn('training', configuration, cell.training)),
                cell.track.parameters.laps, smooth=smooth, objective=cell.objective)

    def objective_of(bounded: Any) -> Objective:
        return Objective(configuration, goal._replace(genes=bounded), work.run)

    population = population_for(len(genes))
    settings = SearchSettings('nelder_mead', len(genes), population, budget // POPULATION,
                              cell.seed_of('search') % 2**32)
    journal = Journal(work.journal(str(budget)), {'cell': work.file.name}, True)
    try:
        staged = search_in_stages(settings, StagePlan(WIDENINGS, cell.restarts), genes, objective_of, journal,
                                  lambda _: work.progress(population * cell.training), work.stopped)
    finally:
        journal.close()
    if not staged.is_complete:
        return None
    best, reason = staged.result, no_result(staged.result)
    if best.point is None or reason:
        return configured_gains(configuration), None, reason
    objective = objective_of(staged.genes)
    gains = rounded(objective.gains(best.point.tolist()))
    return gains, SearchEnd(best.score, objective.objectives(gains), staged.agreeing, [*staged.repeated],
                            staged.edges), ''


def with_gains(configuration: Configuration, gains: Gains) -> Configuration:
    """Return a loop with other gains."""
    velocity, position = configuration.velocity_controller, configuration.position_controller
    return configuration._replace(velocity_controller=velocity._replace(control=gains.velocity),
                                  position_controller=position._replace(control=gains.control))


def _named(genes: Any, gains: Gains, law: str) -> dict[str, Any]:
    """Return the gains that were searched, by node and name; those of the law alone where nothing can be."""
    if genes:
        return {f'{node}.{name}': value for node, values in space.parameters(genes, gains).items()
                for name, value in values.items() if name != 'controller_type'}
    return {f'position_controller.{law}.{name}': value
            for name, value in flatten(declared_gains(gains.control)[1]).items()}


def judging_trials(cell: Cell, configuration: Configuration) -> list[Trial]:
    """Return the trials that judge a loop."""
    laps, scenarios = cell.track.parameters.laps, cell.drawn('judging', configuration, cell.runs)
    varies = drive_of(configuration) == DRIVEN_BY_VELOCITY
    trials = (scenario_trial(configuration, scenario, laps, LATE * laps) for scenario in scenarios)
    return [one._replace(form=one.form._replace(indices=True, varies=varies)) for one in trials]


def _judged(cell: Cell, loop: Configuration, work: Work) -> RunColumns:
    """Run the unseen scenarios; return what each has shown, as columns."""
    trials = judging_trials(cell, loop)
    judged = [judge(trial, outcome, cell.track.parameters.success_within)
              for trial, outcome in zip(trials, work.run(trials), strict=True)]
    work.progress(cell.runs)
    return RunColumns([run.success for run in judged], [run.outcome for run in judged],
                      {name: [finite(run.metrics[name]) for run in judged] for name in JUDGED})


def driven_again(cell: Cell, result: BudgetResult, work: Work) -> BudgetResult:
    """Return a result whose gains are known, with what they show in the unseen scenarios."""
    return result._replace(judged=_judged(cell, with_gains(cell.configuration(), gains_of(cell, result.gains)), work))


def finite(value: float) -> float | None:
    """Return a value; None where it is not finite."""
    return value if math.isfinite(value) else None


def _why(cell: Cell, configuration: Configuration) -> str:
    """Return why a law fails or diverges in the first unseen scenario; '' where it does not."""
    end, failure = _failure(cell, configuration)
    return failure or end


def _failure(cell: Cell, configuration: Configuration) -> tuple[str, str]:
    """Return where a loop diverges in the first unseen scenario, and why its law fails there; '' where it does not."""
    trial = judging_trials(cell._replace(runs=1), configuration)[0]
    steps = 0
    try:
        for _ in trial_rollout(trial, configuration):
            steps += 1
    except LawFailedError as error:
        return '', str(error)
    except ParameterError as error:
        return '', '; '.join(error.violations)
    return '' if steps > trial.steps else f'it diverges at t = {steps * trial.loop.robot.plant.dt:.3g} s', ''


def _path(cell: Cell, configuration: Configuration) -> DrivenPath:
    """Return path, reference and error of the first unseen scenario."""
    trial = judging_trials(cell._replace(runs=1), configuration)[0]
    samples = []
    with suppress(LawFailedError):
        for sample in trial_rollout(trial, configuration):
            samples.append(sample)
    return driven_path(trial, samples)


def driven_path(trial: Trial, samples: Iterable[Sample]) -> DrivenPath:
    """Return path, reference and error of the samples of a trial, thinned out, to a micrometre."""
    every = max(1, trial.steps // trial.ratio // _POINTS) * trial.ratio
    rows = []
    for sample in itertools.islice(samples, 0, None, every):
        pose, error = (sample.truth.pose, sample.truth.error) if sample.truth else (sample.tick.pose, sample.tick.error)
        rows.append((sample.time, pose.x, pose.y, *sample.tick.reference.pose[:2], distance(error)))
    return DrivenPath(*([round(value, 6) for value in column] for column in zip(*rows, strict=True)))


def step_time(configuration: Configuration) -> float | None:
    """Measure one step of the law as a node does it [s]: the best mean of some repeats; None where it fails."""
    law, shared = LAWS[configuration.position_controller.control.controller_type], configuration.plant.shared
    cart, best = course_of(configuration.reference_cart).reference(0.0), math.inf
    observation = Observation(TrackingError(0.01, 0.01, 0.01), cart, cart.velocity, (cart,) * shared.reference_horizon)
    try:
        gains = prepared_gains(law, declared_gains(configuration.position_controller.control)[1],
                               1.0 / shared.position_rate)
        for _ in range(_REPEATS):
            state, begun = law.start, time.perf_counter()
            for _ in range(_STEPS):
                state, _ = law.step(state, observation, gains, 1.0 / shared.position_rate)
            best = min(best, (time.perf_counter() - begun) / _STEPS)
    except Exception:  # a law can raise anything; its runs tell the reason
        return None
    return best
