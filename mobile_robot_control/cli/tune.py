"""The command `tune`: search for a controller's gains, as the chapter does."""

import argparse
import math
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

from mobile_robot_control import __version__
from mobile_robot_control.cli import outputs, scenario_options, trial_options
from mobile_robot_control.cli.arguments import command, configuration, parser, positive
from mobile_robot_control.cli.trial_options import Interrupt, runner, whole
from mobile_robot_control.configuration import Configuration, configure
from mobile_robot_control.parameter_files import load
from mobile_robot_control.parameters import ParameterError, flatten
from mobile_robot_control.reporting import search_picture
from mobile_robot_control.simulation.closed_loop import rollout
from mobile_robot_control.simulation.metrics import RunMeter, summary
from mobile_robot_control.tuning import gains as gain_space
from mobile_robot_control.tuning import result
from mobile_robot_control.tuning.gains import CHROMOSOMES, POPULATIONS, VELOCITY, Gains
from mobile_robot_control.tuning.journal import Journal
from mobile_robot_control.tuning.objective import COMBINATIONS, Goal, Objective
from mobile_robot_control.tuning.search import ALGORITHMS, WORST, Found, Generation, SearchSettings, search


def _bound(text: str) -> tuple[str, tuple[float, float]]:
    name, _, interval = text.partition('=')
    low, _, high = interval.partition(':')
    try:
        return name, (float(low), float(high))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}': write NAME=LOW:HIGH, such as k1=0:5") from None


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    made = parser('tune', __doc__.partition(': ')[2])
    made.add_argument('controller', choices=tuple(CHROMOSOMES), help="what to search; 'velocity' keeps the position "
                      "law's gains, 'fuzzy' the velocity gains")
    made.add_argument('--seed', type=whole(0), required=True, metavar='N', help='of all chance')
    made.add_argument('--output', required=True, metavar='FILE.yaml', help='parameter file to write; beside it go the '
                      'history (.csv), a picture (.png) and, until the search is done, its journal (.yaml.journal)')
    made.add_argument('--resume', action='store_true', help='go on from the journal')
    made.add_argument('--overwrite', action='store_true', help='replace a better file, and a journal')
    made.add_argument('--algorithm', choices=tuple(ALGORITHMS), default='genetic')
    made.add_argument('--population', type=whole(5), metavar='N',
                      help="individuals; the chapter's 51 or 101, if left out")
    made.add_argument('--generations', type=whole(1), default=150, metavar='N')
    made.add_argument('--time-limit', type=positive, metavar='S', help='begin no generation after this wall time [s]')
    made.add_argument('--bounds', type=_bound, action='append', default=[], metavar='NAME=LOW:HIGH',
                      help='of a gene, such as k1=0:5; again and again')
    made.add_argument('--with-velocity', action='store_true',
                      help="search the velocity gains along with fuzzy, which the chapter keeps; the other searches do")
    made.add_argument('--combine', choices=tuple(COMBINATIONS), default='mean',
                      help='of the objective over the scenarios')
    made.add_argument('--literal-torque', action='store_true',
                      help='take max(tau) in Eq. (29) as printed, not max|tau|')
    made.add_argument('--laps', type=positive, default=1.0, metavar='N', help='length of each rollout')
    scenario_options.add(made)
    trial_options.add(made)
    return made.parse_args(arguments)


def _goal(options: argparse.Namespace, parameters: Configuration) -> Goal:
    genes = CHROMOSOMES[options.controller]
    if options.with_velocity and options.controller == 'fuzzy':
        genes += VELOCITY
    genes = gain_space.bounded(genes, dict(options.bounds))
    return Goal(options.controller, genes, tuple(scenario_options.scenarios(options, parameters)), options.laps,
                options.combine, options.literal_torque)


def _settings(options: argparse.Namespace, goal: Goal) -> SearchSettings:
    return SearchSettings(options.algorithm, len(goal.genes), options.population or POPULATIONS[options.controller],
                          options.generations, options.seed, options.time_limit or 0.0)


def _purpose(parameters: Configuration, goal: Goal, settings: SearchSettings) -> dict[str, Any]:
    """Name all that the scores of a search depend on."""
    kept = {name: value for name, value in settings._asdict().items() if name not in ('generations', 'seconds')}
    loop = {f'{node}.{name}': value for node, group in parameters._asdict().items()
            for name, value in flatten(group).items()}
    return {'version': __version__, **kept, **goal._asdict(), **loop}


def _with_gains(parameters: Configuration, gains: Gains) -> Configuration:
    """Give a configuration other gains, checked as a whole."""
    values = {node: flatten(group) for node, group in parameters._asdict().items()}
    values['velocity_controller'] |= {f'gains.{name}': x for name, x in gains.velocity._asdict().items()}
    values['position_controller'] |= flatten(gains.control)
    return configure(values)


def _standing(file: Path, objective: Objective, controller: str) -> float:
    """Score the parameter file that is there already; infinite where there is none."""
    if not file.exists():
        return math.inf
    try:
        gains = gain_space.of(configure(load([file])))
        ours = controller in ('velocity', gains.control.controller_type)
    except ParameterError:
        ours = False
    if not ours:
        raise ParameterError([f'{file}: exists and holds no {controller} controller to compare with; name another '
                              '--output, or give --overwrite'])
    return objective.score(gains)


class _Search:
    """One run of the command."""

    def __init__(self, options: argparse.Namespace, parameters: Configuration, run: trial_options.Runner) -> None:
        self._options, self._parameters = options, parameters
        self._output = Path(options.output)
        self._goal = _goal(options, parameters)
        self._settings = _settings(options, self._goal)
        self._objective = Objective(parameters, self._goal, run)
        self._journal_file = self._output.with_name(self._output.name + '.journal')

    def run(self) -> int:
        self._output.parent.mkdir(parents=True, exist_ok=True)
        if self._output.is_dir():
            raise IsADirectoryError(21, 'is a folder', str(self._output))
        standing = math.inf
        if not self._options.overwrite:
            standing = _standing(self._output, self._objective, self._goal.controller)
        if self._journal_file.exists() and not (self._options.resume or self._options.overwrite):
            raise ParameterError([f'{self._journal_file}: holds a search that was not finished; --resume goes on with '
                                  'it, --overwrite begins anew'])
        journal = Journal(self._journal_file, _purpose(self._parameters, self._goal, self._settings),
                          self._options.resume and not self._options.overwrite)
        with Interrupt() as interrupt, tqdm(total=self._settings.generations, disable=None, unit='generation') as bar:
            def progress(generation: Generation) -> None:
                bar.set_postfix_str(f'best {generation.best:.4f}, mean {generation.mean:.4g}', refresh=False)
                bar.update()

            try:
                found = search(self._settings, self._objective, journal, progress, lambda: interrupt.asked)
            except OSError as error:
                return self._lost(error, standing)
            finally:
                journal.close()
        return self._done(found, standing, interrupt.asked)

    def _lost(self, error: OSError, standing: float) -> int:
        """Keep what can be kept when the journal or the cluster is gone."""
        found: Found | None = getattr(error, 'found', None)
        print(f'tune: {error.filename or self._journal_file}: {error.strerror or error}; what was '
              'scored before is kept: mend that and go on with --resume', file=sys.stderr)
        if found is not None and found.point is not None:
            gains = gain_space.parameters(self._goal.genes, self._objective.gains(found.point.tolist()))
            print(f'tune: the best of {len(found.history)} generations has the objective {found.score:.6g}: {gains}',
                  file=sys.stderr)
            self._write(found, standing)
        return 1

    def _done(self, found: Found, standing: float, interrupted: bool) -> int:
        if found.point is None:
            print('tune: interrupted before the first generation was scored' if interrupted else
                  'tune: the time limit is too short for one generation', file=sys.stderr)
            return 1
        if found.score >= WORST:
            print('tune: no individual could be scored: all are unstable or diverge; give tighter --bounds or raise '
                  'the rates', file=sys.stderr)
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
        gains = gain_space.rounded(self._objective.gains(found.point.tolist()))
        return self.write(gains, found._replace(score=self._objective.score(gains)), standing)

    def write(self, gains: Gains, found: Found, standing: float) -> bool:
        """Write all files for gains with their score, unless a better one is there already."""
        if standing <= found.score:
            print(f'tune: {self._output} has the objective {standing:.6g} and stays, {found.score:.6g} was '
                  'found; --overwrite replaces it', file=sys.stderr)
            return standing == found.score
        tuned = _with_gains(self._parameters, gains)
        metrics, after = self._drive(tuned)
        named = {node: tuple(values) for node, values in gain_space.parameters(self._goal.genes, gains).items()}
        outputs.write(self._output, result.parameter_file(tuned, named, self._notes(found, metrics)))
        outputs.write(self._output.with_suffix('.csv'), result.history_table(found.history))
        _, before = self._drive(self._parameters)
        title = f'{self._goal.controller.replace("_", " ")}: objective {found.score:.4g}'
        search_picture.draw(found.history, {'before': before, 'after': after}, title, self._output.with_suffix('.png'))
        print(f'{self._output}: objective {found.score:.6g} after {len(found.history)} generations')
        return True

    def _drive(self, parameters: Configuration) -> tuple[dict[str, Any], list[Any]]:
        """Run the configured loop once."""
        shared = parameters.plant.shared
        meter = RunMeter(1.0 / shared.velocity_rate, 1.0 / shared.position_rate)
        samples = list(meter.watch(rollout(parameters, self._goal.laps
                                           * parameters.reference_cart.curve.placement.period)))
        return summary(meter.run('completed')), samples

    def _notes(self, found: Found, metrics: dict[str, Any]) -> list[str]:
        goal, settings = self._goal, self._settings
        torque = max(metrics['peak_wheel_torque'].values())
        return [
            f'{goal.controller} gains found by mobile_robot_control {__version__} with',
            f'  {self._options.command_line}',
            f'{settings.algorithm}, seed {settings.seed}, {len(found.history)} generations of {settings.population}, '
            f'{len(goal.scenarios)} scenario{"s" * (len(goal.scenarios) != 1)} of {goal.laps:g} laps',
            f'objective {found.score!r}: {goal.combine} of Eq. (29) with max '
            f'{"tau as printed" if goal.literal else "|tau|"}',
            f'the configured run: objective {metrics["objective"]:.4f}, RMS error '
            f'{100 * metrics["rms_position_error"]:.2f} cm, largest {100 * metrics["max_position_error"]:.2f} cm, '
            f'largest |torque| {torque:.3f} N m',
        ]


def _run(options: argparse.Namespace) -> int:
    parameters = configuration(options)
    if options.controller != 'velocity':
        control = parameters.position_controller.control._replace(controller_type=options.controller)
        parameters = parameters._replace(
            position_controller=parameters.position_controller._replace(control=control))
    with runner(options) as run:
        return _Search(options, parameters, run).run()


def _command_line(arguments: Sequence[str]) -> str:
    """Give the command without what changes no result: where it ran, and after which interruptions."""
    kept = [text for text, before in zip(arguments, ('', *arguments), strict=False)
            if text.partition('=')[0] not in ('--resume', '--workers', '--scheduler')
            and before not in ('--workers', '--scheduler')]
    return shlex.join(['tune', *kept])


def main(arguments: Sequence[str] | None = None) -> int:
    """
    Run the command.

    Parameters
    ----------
    arguments : sequence of str or None
        The command line; that of the process if None.

    Returns
    -------
    int
        Exit code.

    """
    options = _parse(arguments)
    options.command_line = _command_line(sys.argv[1:] if arguments is None else arguments)
    return command('tune', lambda: _run(options))


if __name__ == '__main__':
    sys.exit(main())
