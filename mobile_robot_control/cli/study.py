"""The command `study`: Monte Carlo robustness of one or several controllers: starts, robots, noise and delay."""

import argparse
import csv
import io
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mobile_robot_control.cli.command_parser import make_parser
from mobile_robot_control.cli.interrupt import Interrupt
from mobile_robot_control.cli.options import (
    configuration,
    fraction,
    make_main,
    non_negative,
    positive,
    whole_number,
    writable_file,
)
from mobile_robot_control.cli.progress import tqdm
from mobile_robot_control.cli.run_length import check_laps
from mobile_robot_control.cli.worker_options import TrialRunner, add_worker_options, runner
from mobile_robot_control.files import write_atomically
from mobile_robot_control.model.actuators import LONGEST_DELAY
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.reporting.starts_map import Start, draw_starts_map
from mobile_robot_control.simulation.metrics import TRUE
from mobile_robot_control.simulation.trial import Trial
from mobile_robot_control.texts import printable
from mobile_robot_control.tuning.monte_carlo import (
    WITHIN,
    Judged,
    ScenarioDistribution,
    draw_scenarios,
    judge,
    summarise_runs,
)
from mobile_robot_control.tuning.promises import Promise, promise, promise_lines, promise_values
from mobile_robot_control.tuning.scenarios import Scenario, configured_scenario, scenario_trial

_BATCH = 100


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    made = make_parser('study', __doc__)
    made.add_argument('--runs', type=whole_number(1, 10**6), required=True, metavar='N',
                      help='random runs of each controller')
    made.add_argument('--seed', type=whole_number(0), required=True, metavar='N', help='of all chance')
    made.add_argument('--output', required=True, metavar='DIR', help='takes study.json, runs.csv and starts.png')
    made.add_argument('--overwrite', action='store_true', help='replace a study that DIR already holds')
    made.add_argument('--compare', nargs='+', default=[], metavar='FILE.yaml',
                      help='one controller each, on top of the other parameters')
    made.add_argument('--laps', type=positive, default=2.0, metavar='N', help='length of each run; success is judged '
                      'over its last quarter')
    made.add_argument('--curves', nargs='+', choices=CURVES, default=['trifolium', 'lemniscate'],
                      metavar='CURVE')
    made.add_argument('--scales', nargs='+', type=positive, default=[0.5, 1.0], metavar='M')
    made.add_argument('--within', type=positive, default=1.0, metavar='M', help="of the start from the cart's [m]")
    made.add_argument('--variation', type=fraction, default=0.2, metavar='X', help='of mass and friction, relative')
    made.add_argument('--noise-pose', type=non_negative, nargs=3, metavar=('X', 'Y', 'YAW'),
                      help='instead of noise.pose')
    made.add_argument('--noise-velocity', type=non_negative, metavar='W', help='instead of noise.velocity [rad/s]')
    made.add_argument('--longest-delay', type=whole_number(0), metavar='N',
                      help='delays of 0 to N periods of the velocity loop, instead of delay.velocity_steps')
    add_worker_options(made)
    options = made.parse_args(arguments)
    if options.longest_delay is not None and options.longest_delay > LONGEST_DELAY:
        made.error(f'--longest-delay {options.longest_delay}: it must be at most {LONGEST_DELAY}')
    return options


def _scenarios(options: argparse.Namespace, parameters: Configuration) -> list[Scenario]:
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


def _controllers(options: argparse.Namespace) -> dict[str, Configuration]:
    """Return the configurations to study by name."""
    if not options.compare:
        parameters = configuration(options)
        return {parameters.position_controller.control.controller_type: parameters}
    named: dict[str, Configuration] = {}
    for file in options.compare:
        stem = printable(Path(file).stem)
        name = stem if stem not in named else printable(file)
        if name in named:
            raise ParameterError([f'--compare {file}: is named twice; name each file once'])
        named[name] = configuration(options, extra_files=[file])
    return named


def _study(trials: Sequence[Trial], run: TrialRunner, bar: Any, interrupt: Interrupt) -> list[Judged]:
    """Run and judge trials, batch by batch, until an interrupt."""
    judged: list[Judged] = []
    for first in range(0, len(trials), _BATCH):
        if interrupt.requested:
            break
        batch = trials[first:first + _BATCH]
        judged += [judge(one, outcome) for one, outcome in zip(batch, run(batch), strict=True)]
        bar.update(len(batch))
    return judged


def _table(scenarios: Sequence[Scenario], results: dict[str, list[Judged]]) -> str:
    """Return all runs as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    names = next(iter(results.values()))[0].metrics
    writer.writerow(['controller', 'curve', 'scale', 'start_x', 'start_y', 'start_yaw', 'mass_factor',
                     'friction_factor', 'noise_seed', 'delay', 'success', *names])
    for controller, judged in results.items():
        for scenario, run in zip(scenarios, judged, strict=False):
            assert scenario.start is not None  # noqa: S101 (for mypy: drawn ones have a start)
            writer.writerow([controller, scenario.curve, scenario.scale, *scenario.start, scenario.mass,
                             scenario.friction, scenario.noise.seed, scenario.delay, int(run.success),
                             *('' if math.isnan(value) else value for value in run.metrics.values())])
    return text.getvalue()


def _map(scenarios: Sequence[Scenario], results: dict[str, list[Judged]], file: Path) -> None:
    """Draw the map of starts."""
    draw_starts_map({
        f'{name.replace("_", " ")}: {100.0 * sum(run.success for run in judged) / len(judged):.2f} %': [
            Start(scenario.start, run.success)
            for scenario, run in zip(scenarios, judged, strict=False) if scenario.start is not None
        ] for name, judged in results.items()
    }, file)


def _run(options: argparse.Namespace) -> int:
    controllers = _controllers(options)
    for parameters in controllers.values():
        check_laps(options.laps, parameters)
    folder = Path(options.output)
    if (folder / 'study.json').exists() and not options.overwrite:
        raise ParameterError([f'{folder}: holds a study already; name another folder, or add --overwrite'])
    folder.mkdir(parents=True, exist_ok=True)
    # nothing long begins before the place is known to be writable
    writable_file(str(folder / 'runs.csv'))
    results: dict[str, list[Judged]] = {}
    promises: dict[str, Promise] = {}
    total = options.runs * len(controllers)
    with runner(options) as run, Interrupt() as interrupt, tqdm(total=total, disable=None, unit='run') as bar:
        for name, parameters in controllers.items():
            scenarios = _scenarios(options, parameters)
            late = options.laps * 0.75
            trials = [scenario_trial(parameters, scenario, options.laps, late) for scenario in scenarios]
            judged = _study(trials, run, bar, interrupt)
            if judged:
                results[name], promises[name] = judged, promise(parameters, scenarios)
    if not results:
        print('study: interrupted before the first runs were done', file=sys.stderr)
        return 1
    found = {name: summarise_runs(judged) | promise_values(promises[name]) for name, judged in results.items()}
    settings = {
        'outcome': 'interrupted' if interrupt.requested else 'completed', 'seed': options.seed, 'laps': options.laps,
        'curves': options.curves, 'scales': options.scales, 'within': options.within, 'variation': options.variation,
        'success': f'within {WITHIN} m over the last quarter', 'interrupted': interrupt.requested,
        'error': TRUE,
    }
    write_atomically(folder / 'study.json', json.dumps({**settings, 'controllers': found}, indent=2) + '\n')
    write_atomically(folder / 'runs.csv', _table(scenarios, results))
    _map(scenarios, results, folder / 'starts.png')
    for name, numbers in found.items():
        low, high = (100.0 * bound for bound in numbers['success_interval'])
        print(f'{name}: {100.0 * numbers["success_rate"]:.2f} % of {numbers["runs"]} runs succeed '
              f'(95 % interval {low:.2f} to {high:.2f} %)', *promise_lines(promises[name]), sep='\n')
    if interrupt.requested:
        print('study: interrupted; the files hold what was done', file=sys.stderr)
        return 1
    return 0


main = make_main('study', _parse, _run)

if __name__ == '__main__':
    sys.exit(main())
