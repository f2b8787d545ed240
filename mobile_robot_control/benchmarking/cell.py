"""One cell of a benchmark: a law on a track with one seed, searched with each budget and judged on unseen scenarios."""

import json
import math
import time
import zlib
from collections.abc import Callable, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.analysis.modelled import drive_of
from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.control.laws import LAWS, declared_gains, prepared_gains
from mobile_robot_control.control.tracking_error import distance
from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.loop.batch import TrialRunner
from mobile_robot_control.loop.monte_carlo import JudgedRuns, ScenarioDistribution, draw_scenarios, judge
from mobile_robot_control.loop.scenarios import Scenario, configured_scenario, scenario_trial
from mobile_robot_control.loop.trial import Trial
from mobile_robot_control.parameters.declaration import ParameterError, flatten
from mobile_robot_control.quantities import Observation, Pose, TrackingError
from mobile_robot_control.runs.rollout import trial_rollout
from mobile_robot_control.search import space
from mobile_robot_control.search.journal import Journal
from mobile_robot_control.search.objective import DEFAULT_SMOOTH, Goal, Objective
from mobile_robot_control.search.search import Generation, SearchSettings, no_result, run_search
from mobile_robot_control.search.space import Gains, search_genes
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.nodes import Configuration, course_of
from mobile_robot_control.settings.tracks import Track
from mobile_robot_control.system.files import FileKind, parse_json, read_bounded, write_atomically
from mobile_robot_control.system.texts import printable
from mobile_robot_control.version import __version__

POPULATION = 25
"""Candidates of a generation: a longer search begins with the shorter one."""
JUDGED = ('rms_position_error', 'max_position_error', 'settling_time', 'peak_wheel_torque', 'energy',
          'torque_variation', 'command_variation')
"""The metrics that are kept of every run."""
NOT_SEARCHED = 'not searched'
"""First words of the reason of a result whose search could drive no candidate."""
_RESULT = FileKind('cell', 1 << 30)
_LATE = 0.75
_DRAWN = 120
"""Points of a picture."""
_STEPS, _REPEATS = 300, 5


class Cell(NamedTuple):
    """
    One cell.

    Attributes
    ----------
    law : str
        Its name.
    track : Track
        What is driven.
    seed : int
        Of the draw of both kinds of scenarios, and of the search.
    budgets : tuple of int
        Candidates of the search, ascending; () where gains are taken as configured.
    training, runs : int
        Scenarios of the search, and those that judge.
    more : ParameterSources
        Parameters on top of those of the track.
    """

    law: str
    track: Track
    seed: int
    budgets: tuple[int, ...]
    training: int
    runs: int
    more: ParameterSources = ParameterSources()

    def inputs(self) -> dict[str, Any]:
        """Return all that the result depends on, for JSON."""
        return {'version': __version__, 'arithmetic': ARITHMETIC, 'law': self.law,
                'source': LAWS.checksum(self.law), 'track': self.track.name,
                'content': self.track.content(self.more), 'seed': self.seed, 'budgets': self.budgets,
                'training': self.training, 'runs': self.runs}

    def file(self, folder: Path) -> Path:
        """Return where its result is kept: the name changes with the inputs."""
        digest = sha256(json.dumps(self.inputs(), sort_keys=True).encode()).hexdigest()[:12]
        return folder / f'{printable(f"{self.law}.{self.track.name}").replace("/", "_")}.{self.seed}.{digest}.json'

    def configuration(self, feedforward: bool = False) -> Configuration:
        """Return the loop with the law, its gains as configured."""
        return self.track.sources(self.more).with_values({
            'position_controller.controller_type': self.law, '/**.feedforward.enabled': feedforward}).configuration()

    def drawn(self, use: str, configuration: Configuration, count: int) -> list[Scenario]:
        """Draw scenarios for a use, 'training' or 'judging', whose seeds have nothing in common; of all laws alike."""
        nominal, asked = configured_scenario(configuration), self.track.parameters
        low, high = asked.delays or (nominal.delay, nominal.delay)
        spread = ScenarioDistribution(asked.curves, asked.scales, asked.within or 1.0, asked.variation, nominal.noise,
                                      high - low)
        return [scenario._replace(start=_scaled(scenario.start, asked.within, asked.turned),
                                  delay=low + scenario.delay)
                for scenario in draw_scenarios(spread, count, self.seed_of(use))]

    def seed_of(self, use: str) -> int:
        """Return the seed of a use, which depends on that of the benchmark and on the track."""
        return int.from_bytes(sha256(f'{self.seed} {self.track.name} {use}'.encode()).digest()[:8], 'big')


def _scaled(start: Pose | None, within: float, turned: float) -> Pose:
    """Return a start that was drawn facing anywhere, turned by so much at most."""
    assert start is not None  # noqa: S101 (for mypy: drawn ones have a start)
    if not within:
        start = start._replace(x=0.0, y=0.0)
    return start._replace(heading=start.heading * turned / math.pi)


def run_cell(cell: Cell, run: TrialRunner, file: Path, progress: Callable[[int], object],
             stopped: Callable[[], bool]) -> dict[str, Any] | None:
    """
    Search with each budget and judge.

    Parameters
    ----------
    cell : Cell
        What is searched and judged.
    run : callable
        Runs trials.
    file : Path
        Where its result will be; its journal lies beside.
    progress : callable
        Called with how many rollouts were done since the last time.
    stopped : callable
        Called before each generation; the cell ends if it returns True.

    Returns
    -------
    dict or None
        `results`, one for each budget, `step_time` [s] and `drawn`; None where it was stopped.
    """
    try:
        configuration = cell.configuration()
    except ParameterError as error:
        return {'results': [{'budget': budget, 'reason': '; '.join(error.violations)}
                            for budget in cell.budgets or (0,)], 'step_time': None, 'drawn': None}
    results = []
    gains, reason = space.configured_gains(configuration), ''
    genes: Any = search_genes(cell.law, True, drive_of(configuration))
    for budget in cell.budgets or (0,):
        score = None
        if budget and genes:
            found = _searched(cell, configuration, genes, budget, run, file, progress, stopped)
            if found is None:
                return None
            gains, score, reason = found
        if reason:
            failure = _failure(cell, configuration)[1]
            results.append({'budget': budget, 'reason': failure or f'{NOT_SEARCHED}: {reason}'})
        else:
            judged = _judged(cell, gains, run)
            progress(2 * cell.runs)
            results.append({'budget': budget, 'score': score, 'gains': _named(genes, gains, cell.law), **judged,
                            'reason': '' if any(judged['success']) else _why(cell, with_gains(configuration, gains))})
    return {'results': results, 'step_time': step_time(configuration),
            'drawn': None if reason else _picture(cell, with_gains(configuration, gains))}


def _searched(
    cell: Cell, configuration: Configuration, genes: Any, budget: int, run: TrialRunner, file: Path,
    progress: Callable[[int], object], stopped: Callable[[], bool],
) -> tuple[Gains, float, str] | None:
    """Return gains, their score, and why there are none; None where the search was stopped."""
    before = max((one for one in cell.budgets if one < budget), default=0) // POPULATION
    goal = Goal(cell.law, genes, tuple(cell.drawn('training', configuration, cell.training)),
                cell.track.parameters.laps, smooth=DEFAULT_SMOOTH[drive_of(configuration)])
    settings = SearchSettings('differential_evolution', len(genes), POPULATION, max(1, budget // POPULATION),
                              cell.seed_of('search') % 2**32)
    objective = Objective(configuration, goal, run)
    journal = Journal(file.with_suffix('.journal'), {'cell': file.name}, True)

    def generation(one: Generation) -> None:
        # those of a smaller budget have been counted
        if one.number > before:
            progress(POPULATION * cell.training)

    try:
        found = run_search(settings, objective, journal, generation, stopped)
    finally:
        journal.close()
    # a search in which every candidate fails ends early by itself
    if len(found.history) < settings.generations and stopped():
        return None
    reason = no_result(found)
    point = [1.0] * len(genes) if found.point is None else found.point.tolist()
    return space.rounded(objective.gains(point)), found.score, reason


def write_result(file: Path, result: Mapping[str, Any]) -> None:
    """Write the result of a cell, with its checksum."""
    write_atomically(file, json.dumps({'arithmetic': ARITHMETIC, 'checksum': _checksum(result), 'cell': result}))


def read_result(file: Path) -> dict[str, Any]:
    """Read the result of a cell; raise OSError or ValueError if it is not one that was written."""
    content = parse_json(read_bounded(file, _RESULT))
    if not isinstance(content, dict) or content.get('checksum') != _checksum(content.get('cell')):
        raise ValueError('its checksum is wrong')
    result: dict[str, Any] = content['cell']
    return result


def check_arithmetic(file: Path) -> None:
    """Raise ParameterError if a cell was computed with another arithmetic."""
    try:
        read_result(file)
    except (OSError, ValueError):  # damaged: told where it is needed
        return
    found = parse_json(read_bounded(file, _RESULT)).get('arithmetic', 1)
    if found != ARITHMETIC:
        raise ParameterError([f'{file}: was computed with arithmetic {found}, and this program has {ARITHMETIC}: their '
                              'last bits differ; --overwrite begins anew, or name another --output'])


def _checksum(result: object) -> int:
    return zlib.crc32(json.dumps(result).encode())


def with_gains(configuration: Configuration, gains: Gains) -> Configuration:
    """Return a loop with other gains."""
    velocity, position = configuration.velocity_controller, configuration.position_controller
    return configuration._replace(velocity_controller=velocity._replace(gains=gains.velocity),
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
    varies = DEFAULT_SMOOTH[drive_of(configuration)] > 0.0
    trials = (scenario_trial(configuration, scenario, laps, _LATE * laps) for scenario in scenarios)
    return [one._replace(form=one.form._replace(indices=True, varies=varies)) for one in trials]


def _judged(cell: Cell, gains: Gains, run: TrialRunner) -> dict[str, Any]:
    """Run the unseen scenarios without and with feedforward; return what each has shown, as columns."""
    columns: dict[str, Any] = {}
    for fed in (False, True):
        loop = with_gains(cell.configuration(fed), gains)
        trials = judging_trials(cell, loop)
        if fed:
            trials = [one._replace(form=one.form._replace(indices=False, varies=False)) for one in trials]
        judged = [judge(trial, outcome, cell.track.parameters.success_within)
                  for trial, outcome in zip(trials, run(trials), strict=True)]
        kept = JUDGED[:1] if fed else JUDGED
        prefix = 'fed_' if fed else ''
        columns |= {f'{prefix}success': [one.success for one in judged],
                    f'{prefix}outcome': [one.outcome for one in judged],
                    **{f'{prefix}{name}': [_finite(one.metrics[name]) for one in judged] for name in kept}}
    return columns


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def judged_runs(result: Mapping[str, Any], prefix: str = '') -> JudgedRuns:
    """Return the judged runs of a result, without or with feedforward; a value that is not known is infinite."""
    names = [name for name in JUDGED if f'{prefix}{name}' in result]
    columns = [[math.inf if value is None else value for value in result[f'{prefix}{name}']] for name in names]
    return JudgedRuns(np.array(result[f'{prefix}success'], bool),
                      dict(zip(names, map(np.array, columns), strict=True)), np.array(result[f'{prefix}outcome'], str))


def was_searched(result: Mapping[str, Any]) -> bool:
    """Return whether a result, or a row of the table, is of gains: no search may have found any that can be driven."""
    return not result['reason'].startswith(NOT_SEARCHED)


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
    return '' if steps > trial.steps else f'it diverges at t = {steps * trial.loop.plant.dt:.3g} s', ''


def _picture(cell: Cell, configuration: Configuration) -> dict[str, list[float]]:
    """Return path, reference and error of the first unseen scenario, thinned out, to a micrometre."""
    trial = judging_trials(cell._replace(runs=1), configuration)[0]
    every = max(1, trial.steps // trial.ratio // _DRAWN) * trial.ratio
    rows = []
    try:
        for k, sample in enumerate(trial_rollout(trial, configuration)):
            if k % every == 0:
                pose, error = (sample.truth.pose, sample.truth.error) if sample.truth else (
                    sample.tick.pose, sample.tick.error)
                rows.append((sample.time, pose.x, pose.y, *sample.tick.reference.pose[:2],
                             distance(error)))
    except LawFailedError:
        pass
    names = ('time', 'x', 'y', 'reference_x', 'reference_y', 'error')
    return {name: [round(value, 6) for value in column]
            for name, column in zip(names, zip(*rows, strict=True), strict=True)}


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


def gains_of(cell: Cell, result: Mapping[str, Any]) -> Gains:
    """Return the gains of a result, exactly as they were judged."""
    return space.configured_gains(cell.track.sources(cell.more).with_values({
        'position_controller.controller_type': cell.law, **result['gains']}).configuration())
