"""The runs of the command `study`: every controller in the same drawn scenarios, judged."""

import argparse
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.cli.run_length import check_laps
from mobile_robot_control.cli.worker_options import TrialRunner
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.simulation.metrics import TRUE
from mobile_robot_control.texts import as_lines
from mobile_robot_control.tuning.comparison import best_of, comparison_texts, comparison_values
from mobile_robot_control.tuning.failures import failure_texts, failure_values
from mobile_robot_control.tuning.monte_carlo import (
    Judged,
    ScenarioDistribution,
    draw_scenarios,
    judge,
    success_text,
    summarise_runs,
)
from mobile_robot_control.tuning.promises import Promise, promise, promise_lines, promise_values
from mobile_robot_control.tuning.scenarios import Scenario, configured_scenario, scenario_trial

_BATCH = 100
_SCENARIO = ('controller', 'curve', 'scale', 'start_x', 'start_y', 'start_yaw', 'mass_factor', 'friction_factor',
             'noise_seed', 'delay', 'success', 'outcome')


class StudiedController(NamedTuple):
    """
    The judged runs of one controller.

    Attributes
    ----------
    scenarios : list of Scenario
        Of all runs, those that an interrupt has left out too.
    judged : list of Judged
        Of the runs that were done, at least one, in the order of the scenarios.
    promise : Promise
        What was modelled, and the margins.
    parameters : Configuration
        Of all runs.
    """

    scenarios: list[Scenario]
    judged: list[Judged]
    promise: Promise
    parameters: Configuration


def study_scenarios(options: argparse.Namespace, parameters: Configuration) -> list[Scenario]:
    """Draw the scenarios of a controller."""
    nominal = configured_scenario(parameters)
    noise = Noise(
        nominal.noise.pose if options.noise_pose is None else tuple(options.noise_pose),
        nominal.noise.velocity if options.noise_velocity is None else options.noise_velocity,
    )
    distribution = ScenarioDistribution(tuple(options.curves), tuple(options.scales), options.within,
                                        options.variation, noise, options.longest_delay or 0)
    drawn = draw_scenarios(distribution, options.runs, options.seed)
    if options.longest_delay is None:
        return [scenario._replace(delay=nominal.delay) for scenario in drawn]
    return drawn


def check_study(options: argparse.Namespace, controllers: Mapping[str, Configuration]) -> None:
    """Check the length of the runs; raise ParameterError where it is none."""
    for parameters in controllers.values():
        check_laps(options.laps, parameters)


def run_study(
    options: argparse.Namespace, controllers: Mapping[str, Configuration], run: TrialRunner,
    progress: Callable[[int], object], stopped: Callable[[], bool],
) -> dict[str, StudiedController]:
    """
    Run and judge controllers in the same scenarios, batch by batch, until they are done or stopped.

    Parameters
    ----------
    options : Namespace
        Of the command.
    controllers : mapping of str to Configuration
        By name, checked by `check_study`.
    run : callable
        Runs trials.
    progress : callable
        Called with how many runs were done since the last time.
    stopped : callable
        Called before every batch; the study ends if it returns True.

    Returns
    -------
    dict of str to StudiedController
        Those of which any run was done.
    """
    results: dict[str, StudiedController] = {}
    for name, parameters in controllers.items():
        scenarios = study_scenarios(options, parameters)
        late = options.laps * 0.75
        drawn = (scenario_trial(parameters, scenario, options.laps, late) for scenario in scenarios)
        trials = [one._replace(form=one.form._replace(indices=True, band=options.settled_within)) for one in drawn]
        judged: list[Judged] = []
        for first in range(0, len(trials), _BATCH):
            if stopped():
                break
            batch = trials[first:first + _BATCH]
            judged += [judge(one, outcome, options.success_within)
                       for one, outcome in zip(batch, run(batch), strict=True)]
            progress(len(batch))
        if judged:
            results[name] = StudiedController(scenarios, judged, promise(parameters, scenarios), parameters)
    return results


def study_values(
    options: argparse.Namespace, results: Mapping[str, StudiedController], interrupted: bool
) -> dict[str, Any]:
    """Return the content of `study.json`."""
    return {
        'outcome': 'interrupted' if interrupted else 'completed', 'seed': options.seed, 'laps': options.laps,
        'curves': options.curves, 'scales': options.scales, 'within': options.within, 'variation': options.variation,
        'success': f'within {options.success_within} m over the last quarter',
        'success_within': options.success_within, 'settled_within': options.settled_within,
        'interrupted': interrupted, 'error': TRUE,
        'controllers': {name: summarise_runs(studied.judged)
                        | {'failures': failure_values(studied.scenarios, studied.judged)}
                        | promise_values(studied.promise)
                        for name, studied in results.items()},
        'best': best_of(_judged(results), options.metric),
        'comparisons': comparison_values(_judged(results), options.metric),
    }


def _judged(results: Mapping[str, StudiedController]) -> dict[str, list[Judged]]:
    """Return the judged runs by controller."""
    return {name: studied.judged for name, studied in results.items()}


def study_lines(options: argparse.Namespace, results: Mapping[str, StudiedController]) -> Iterator[str]:
    """Yield what the command prints: success, failures and what holds of each controller, and the comparison."""
    for name, studied in results.items():
        yield success_text(name, summarise_runs(studied.judged))
        yield from as_lines(failure_texts(studied.scenarios, studied.judged))
        yield from promise_lines(studied.promise)
    yield from as_lines(comparison_texts(_judged(results), options.metric, options.settled_within))


def study_columns(results: Mapping[str, StudiedController]) -> Sequence[str]:
    """Return the names of the columns of `runs.csv`."""
    return (*_SCENARIO, *next(iter(results.values())).judged[0].metrics)


def study_rows(results: Mapping[str, StudiedController]) -> Iterator[list[Any]]:
    """Yield the rows of `runs.csv`, one a run; a metric that is not known is nan."""
    for controller, studied in results.items():
        for scenario, run in zip(studied.scenarios, studied.judged, strict=False):
            assert scenario.start is not None  # noqa: S101 (for mypy: drawn ones have a start)
            yield [controller, scenario.curve, scenario.scale, *scenario.start, scenario.mass, scenario.friction,
                   scenario.noise.seed, scenario.delay, int(run.success), run.outcome, *run.metrics.values()]


def as_cell(value: Any) -> Any:
    """Return a value as `runs.csv` has it: empty where it is nan."""
    return '' if isinstance(value, float) and math.isnan(value) else value
