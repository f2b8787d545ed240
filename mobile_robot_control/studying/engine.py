"""Studies, run and judged: controllers in the same drawn scenarios and robots."""

import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.analysis.promises import Promise, brief_lines, promise, promise_values
from mobile_robot_control.identification.result import read_estimates
from mobile_robot_control.loop.batch import TrialRunner
from mobile_robot_control.loop.drawn import judged_rows
from mobile_robot_control.loop.indices import TRUE
from mobile_robot_control.loop.monte_carlo import Floats, JudgedRuns, Scenarios, success_text, summarise_runs
from mobile_robot_control.reference.curves import OF_FILES
from mobile_robot_control.settings.nodes import Configuration
from mobile_robot_control.studying.comparison import answer_text, best_of, comparison_texts, comparison_values
from mobile_robot_control.studying.failures import failure_texts, failure_values
from mobile_robot_control.studying.request import StudyRequest, drawn_scenarios, study_draws
from mobile_robot_control.system.texts import as_lines

_BATCH = 100
"""Runs in a batch: as many at first, and more if it takes less time than `_SHORT` [s]."""
_SHORT = 0.3


class StudiedController(NamedTuple):
    """
    The judged runs of one controller.

    Attributes
    ----------
    scenarios : Scenarios
        Of all runs, including those that an interrupt has cut off.
    judged : JudgedRuns
        Of completed runs, at least one, in the order of the scenarios.
    promise : Promise
        The modelled effects, and the margins.
    parameters : Configuration
        Of all runs.
    """

    scenarios: Scenarios
    judged: JudgedRuns
    promise: Promise
    parameters: Configuration


def run_study(
    request: StudyRequest, controllers: Mapping[str, Configuration], run: TrialRunner,
    progress: Callable[[int], object], stopped: Callable[[], bool],
) -> dict[str, StudiedController]:
    """
    Run and judge controllers in the same scenarios, batch by batch, until they are done or stopped.

    Parameters
    ----------
    request : StudyRequest
        The request of the study.
    controllers : mapping of str to Configuration
        By name, of `studied_controllers`.
    run : callable
        Runs trials.
    progress : callable
        Called with the number of runs since the last call.
    stopped : callable
        Called before every batch; the study ends if it returns True.

    Returns
    -------
    dict of str to StudiedController
        Those with any completed run.
    """
    results: dict[str, StudiedController] = {}
    for name, parameters in controllers.items():
        if stopped():
            break
        scenarios = drawn_scenarios(request, parameters)
        draws = study_draws(request, parameters)
        rows: list[Floats] = []
        first, size = 0, _BATCH
        while first < len(scenarios) and not stopped():
            batch, begun = scenarios[first:first + size], time.perf_counter()
            try:
                rows.append(judged_rows(run, draws, batch))
            except KeyboardInterrupt:
                # of a batch that takes long: the ones before it count
                if not stopped():
                    raise
                break
            progress(len(batch))
            first += size
            if time.perf_counter() - begun < _SHORT:
                size *= 2
        if rows:
            results[name] = StudiedController(scenarios, JudgedRuns.of_rows(np.concatenate(rows)),
                                              promise(parameters, scenarios), parameters)
    return results


def study_values(
    request: StudyRequest, results: Mapping[str, StudiedController], interrupted: bool
) -> dict[str, Any]:
    """Return the content of `study.json`."""
    return {
        'outcome': 'interrupted' if interrupted else 'completed', 'seed': request.seed, 'laps': request.laps,
        'curves': sorted({one.scenarios[0].curve for one in results.values()} & {*OF_FILES}) or list(request.curves),
        'scales': list(request.scales), 'within': request.within,
        'variation': request.varied_by, 'robot_uncertainty': request.robot_uncertainty,
        'success': f'within {request.success_within} m over the last quarter',
        'success_within': request.success_within, 'settled_within': request.settled_within,
        'interrupted': interrupted, 'error': TRUE,
        'controllers': {name: summarise_runs(studied.judged)
                        | {'failures': failure_values(studied.scenarios, studied.judged)}
                        | promise_values(studied.promise)
                        for name, studied in results.items()},
        'best': best_of(_judged(results), request.metrics),
        'comparisons': comparison_values(_judged(results), request.metrics),
    }


def _judged(results: Mapping[str, StudiedController]) -> dict[str, JudgedRuns]:
    return {name: studied.judged for name, studied in results.items()}


def study_answer(request: StudyRequest, results: Mapping[str, StudiedController]) -> str:
    """Return the first sentence of the command's output: the best of several controllers, or the success of one."""
    (name, studied), *others = results.items()
    return (f'{answer_text(_judged(results), request.metrics, request.settled_within)}.' if others else
            success_text(name, summarise_runs(studied.judged)))


def study_lines(request: StudyRequest, results: Mapping[str, StudiedController]) -> list[str]:
    """Return what follows: the success of each of several controllers, promises, failures and the comparison."""
    several = len(results) > 1
    successes = [success_text(name, summarise_runs(studied.judged)) for name, studied in results.items() if several]
    failures = [f'{name}: {text}' if several else text for name, studied in results.items()
                for text in failure_texts(studied.scenarios, studied.judged)]
    compared = comparison_texts(_judged(results), request.metrics, request.settled_within)
    robots = [] if request.robot_uncertainty is None else [
        f'robots are drawn from the {read_estimates(request.robot_uncertainty).origin}']
    return [*as_lines([*successes, *robots]), *brief_lines([one.promise for one in results.values()]),
            *as_lines([*failures, *compared])]


def study_columns(results: Mapping[str, StudiedController], most: int | None = None) -> dict[str, NDArray[Any]]:
    """Return the columns of `runs.csv`, a row for each run, or `most`, of each controller; unknown metrics are nan."""
    each = []
    for controller, (scenarios, ran, *_) in results.items():
        judged = ran[:most]
        done = scenarios[:len(judged)]
        each.append({
            'controller': np.full(len(done), controller), 'curve': done.curve, 'scale': done.scale,
            **dict(zip(('start_x', 'start_y', 'start_yaw'), done.start.T, strict=True)),
            'mass_factor': done.mass, 'friction_factor': done.friction, 'noise_seed': done.seed, 'delay': done.delay,
            'success': judged.success, 'outcome': judged.outcome,
            **dict(zip(done.robot_names, done.robots.T, strict=True)), **judged.metrics})
    return {name: np.concatenate([one[name] for one in each]) for name in each[0]}
