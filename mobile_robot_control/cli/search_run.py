"""One run of the command `tune`: search, compare with the file that is there already, write."""

import argparse
import math
import sys
from pathlib import Path
from typing import NamedTuple

from mobile_robot_control.cli.interrupt import Interrupt
from mobile_robot_control.cli.progress import tqdm
from mobile_robot_control.cli.scenario_options import scenarios
from mobile_robot_control.cli.search_notes import search_notes, search_purpose
from mobile_robot_control.cli.worker_options import TrialRunner
from mobile_robot_control.files import check_regular, write_atomically
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.configuration import configure
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.parameters.files import load
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.reporting.run_reading import RecordedRun
from mobile_robot_control.reporting.search_page import write_search_page
from mobile_robot_control.reporting.search_picture import draw_search
from mobile_robot_control.reporting.series import collect
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.metrics import summary
from mobile_robot_control.simulation.rollout import recorded
from mobile_robot_control.texts import printable
from mobile_robot_control.tuning import result, search_gains, search_space
from mobile_robot_control.tuning.journal import Journal
from mobile_robot_control.tuning.modelled import drive_of
from mobile_robot_control.tuning.objective import DEFAULT_SMOOTH, Goal, Objective
from mobile_robot_control.tuning.promises import promise, promise_lines
from mobile_robot_control.tuning.search import Found, Generation, SearchSettings, no_result, run_search
from mobile_robot_control.tuning.search_gains import Gains


def search_goal(options: argparse.Namespace, parameters: Configuration) -> Goal:
    """Return what the options search for."""
    genes = search_space.search_genes(options.controller, options.with_velocity, parameters.plant.model.drive)
    genes = search_space.without(genes, options.keep)
    if parameters.plant.shared.feedforward.enabled:
        genes += search_space.feedforward_genes(dict(options.bounds))
    genes = search_space.bounded(genes, dict(options.bounds))
    if not genes:
        raise ParameterError([f"'{options.controller}' leaves nothing to search; --keep less, or declare ranges: "
                              'Field(..., search=(low, high))'])
    smooth = DEFAULT_SMOOTH[drive_of(parameters)] if options.smooth is None else options.smooth
    return Goal(options.controller, genes, tuple(scenarios(options, parameters)), options.laps,
                options.combine, options.literal_torque, smooth)


def search_settings(options: argparse.Namespace, goal: Goal) -> SearchSettings:
    """Return how the options search."""
    population = options.population or search_space.population_of(options.controller)
    return SearchSettings(options.algorithm, len(goal.genes), population, options.generations, options.seed,
                          options.time_limit or 0.0)


def with_gains(parameters: Configuration, gains: Gains) -> Configuration:
    """Return a configuration with other gains, checked as a whole."""
    values = {node: flatten(group) for node, group in parameters._asdict().items()}
    values['velocity_controller'] |= {f'gains.{name}': x for name, x in gains.velocity._asdict().items()}
    values['position_controller'] |= flatten(gains.control)
    return configure(values)


def _standing(file: Path, objective: Objective, controller: str) -> float:
    """Return the score of the parameter file that is there already; infinite where there is none."""
    if not file.exists():
        return math.inf
    try:
        gains = search_gains.configured_gains(configure(load([file])))
        ours = controller in (search_space.VELOCITY, gains.control.controller_type)
    except ParameterError:
        ours = False
    if not ours:
        raise ParameterError([f'{file}: exists and holds no {controller} controller to compare with; name another '
                              '--output, or give --overwrite'])
    return objective.score(gains)


class _Driven(NamedTuple):
    """The loop that was run once with some gains, for the page, and its samples."""

    run: RecordedRun
    samples: list[Sample]


class SearchRun:
    """One run of the command `tune`: from its options to the files that it writes."""

    def __init__(self, options: argparse.Namespace, parameters: Configuration, run: TrialRunner) -> None:
        self._options, self._parameters = options, parameters
        self._output, self._shown = Path(options.output), printable(options.output)
        self._goal = search_goal(options, parameters)
        self._settings = search_settings(options, self._goal)
        self._objective = Objective(parameters, self._goal, run)
        self._journal_file = self._output.parent / f'{self._output.name}.journal'

    def run(self) -> int:
        """Search and write; return the exit code."""
        check_regular(self._output)
        self._output.parent.mkdir(parents=True, exist_ok=True)
        standing = math.inf
        if not self._options.overwrite:
            standing = _standing(self._output, self._objective, self._goal.controller)
        if self._journal_file.exists() and not (self._options.resume or self._options.overwrite):
            raise ParameterError([f'{self._journal_file}: holds a search that was not finished; --resume goes on with '
                                  'it, --overwrite begins anew'])
        journal = Journal(self._journal_file, search_purpose(self._parameters, self._goal, self._settings),
                          self._options.resume and not self._options.overwrite)
        with Interrupt() as interrupt, tqdm(total=self._settings.generations, disable=None, unit='generation') as bar:
            def progress(generation: Generation) -> None:
                bar.set_postfix_str(f'best {generation.best:.4f}, mean {generation.mean:.4g}', refresh=False)
                bar.update()

            try:
                found = run_search(self._settings, self._objective, journal, progress, lambda: interrupt.requested)
            except OSError as error:
                return self._lost(error, standing)
            finally:
                journal.close()
        return self._done(found, standing, interrupt.requested)

    def _lost(self, error: OSError, standing: float) -> int:
        """Keep what can be kept when the journal or the cluster is gone."""
        found: Found | None = getattr(error, 'found', None)
        print(f'tune: {printable(str(error.filename or self._journal_file))}: {error.strerror or error}; what was '
              'scored before is kept: mend that and go on with --resume', file=sys.stderr)
        if found is not None and found.point is not None:
            gains = search_gains.parameters(self._goal.genes, self._objective.gains(found.point.tolist()))
            print(f'tune: the best of {len(found.history)} generations has the objective {found.score:.6g}: {gains}',
                  file=sys.stderr)
            self._write(found, standing)
        return 1

    def _done(self, found: Found, standing: float, interrupted: bool) -> int:
        why = no_result(found)
        if why:
            before = found.point is None and interrupted
            print(f'tune: {"interrupted before the first generation was scored" if before else why}', file=sys.stderr)
            return 1
        better = self._write(found, standing)
        generations = len(found.history)
        if generations >= self._settings.generations:
            self._journal_file.unlink(missing_ok=True)
        elif interrupted:
            print(f'tune: interrupted after {generations} of {self._settings.generations} generations; '
                  '--resume goes on', file=sys.stderr)
            return 1
        return 0 if better else 1

    def _write(self, found: Found, standing: float) -> bool:
        """Write all files, unless a better one is there already."""
        assert found.point is not None  # noqa: S101 (for mypy: callers have checked)
        gains = search_gains.rounded(self._objective.gains(found.point.tolist()))
        return self.write(gains, found._replace(score=self._objective.score(gains)), standing)

    def write(self, gains: Gains, found: Found, standing: float) -> bool:
        """Write all files for gains with their score, unless a better one is there already."""
        if standing <= found.score:
            print(f'tune: {self._shown} has the objective {standing:.6g} and stays, {found.score:.6g} was '
                  'found; --overwrite replaces it', file=sys.stderr)
            return standing == found.score
        tuned = with_gains(self._parameters, gains)
        after = self._drive('after', tuned)
        named = {node: tuple(values) for node, values in search_gains.parameters(self._goal.genes, gains).items()}
        held = promise(tuned, self._goal.scenarios)
        edges = () if found.point is None else search_space.at_the_edge(self._goal.genes, found.point.tolist())
        held = held._replace(cautions=(*held.cautions, *edges), spread=self._objective.spread(tuned))
        holds = promise_lines(held)
        notes = search_notes(self._options, self._goal, self._settings, found, after.run.metrics)
        write_atomically(self._output, result.parameter_file(tuned, named, [*notes, *holds]))
        write_atomically(self._output.with_suffix('.csv'), result.history_table(found.history))
        driven = [self._drive('before', self._parameters), after]
        title = f'{self._goal.controller.replace("_", " ")}: objective {found.score:.4g}'
        svg = draw_search(found.history, {one.run.name: one.samples for one in driven}, title,
                          self._output.with_suffix('.png'))
        write_search_page(self._output.with_suffix('.html'), title, found.history,
                          [one.run for one in driven if one.samples], held, svg)
        print(f'{self._shown}: objective {found.score:.6g} after {len(found.history)} generations', *holds, sep='\n')
        return True

    def _drive(self, name: str, parameters: Configuration) -> _Driven:
        """Run the configured loop once."""
        duration = self._goal.laps * parameters.reference_cart.curve.placement.period
        run, samples = recorded(parameters, duration)
        return _Driven(RecordedRun(name, collect(samples), (), summary(run), parameters), samples)
