"""The command `study`: Monte Carlo robustness of one or several controllers: starts, robots, noise and delay."""

import argparse
import csv
import io
import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

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
from mobile_robot_control.cli.study_run import (
    StudiedController,
    as_cell,
    check_study,
    run_study,
    study_columns,
    study_lines,
    study_rows,
    study_values,
)
from mobile_robot_control.cli.worker_options import add_worker_options, runner
from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.files import write_atomically
from mobile_robot_control.model.actuators import LONGEST_DELAY
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.reporting.run_reading import RecordedRun
from mobile_robot_control.reporting.series import collect
from mobile_robot_control.reporting.starts_map import Start, Starts, draw_starts_map
from mobile_robot_control.reporting.study_page import Judgement, StudiedRuns, chosen_runs, write_study_page
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.indices import BAND
from mobile_robot_control.simulation.rollout import trial_rollout
from mobile_robot_control.texts import printable
from mobile_robot_control.tuning.comparison import COMPARED
from mobile_robot_control.tuning.monte_carlo import METRICS, WITHIN
from mobile_robot_control.tuning.scenarios import scenario_trial
from mobile_robot_control.tuning.splits import best_split


def replayed_runs(studied: StudiedController, laps: float) -> dict[int, RecordedRun]:
    """Return some runs of a controller by their index: failures, and successes in the middle."""
    found = {}
    for n in chosen_runs(studied.judged):
        trial = scenario_trial(studied.parameters, studied.scenarios[n], laps, 0.75 * laps)
        samples = list(_until_failure(trial_rollout(trial, studied.parameters)))
        if samples:
            kind = 'success' if studied.judged[n].success else 'failure'
            found[n] = RecordedRun(f'run {n + 1}, {kind}', collect(samples), (), {}, studied.parameters)
    return found


def _until_failure(samples: Iterator[Sample]) -> Iterator[Sample]:
    """Yield samples up to the one at which a law fails, if any does."""
    try:
        yield from samples
    except LawFailedError:
        return


def parse_study(arguments: Sequence[str] | None, writes: bool = True) -> argparse.Namespace:
    """Read the command line of `study`, that of the process where it is None; `--output` is needed if it `writes`."""
    made = make_parser('study', __doc__)
    made.add_argument('--runs', type=whole_number(1, 10**6), required=True, metavar='N',
                      help='random runs of each controller')
    made.add_argument('--seed', type=whole_number(0), required=True, metavar='N', help='of all chance')
    made.add_argument('--output', required=writes, metavar='DIR', help='takes study.json, runs.csv and starts.png')
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
    made.add_argument('--metric', nargs='+', choices=METRICS, default=list(COMPARED), metavar='METRIC',
                      help='by which controllers are compared, the first one decides which is the best: '
                      f'{", ".join(METRICS)}; {" and ".join(COMPARED)} if left out')
    made.add_argument('--success-within', type=positive, default=WITHIN, metavar='M',
                      help='a run succeeds that stays nearer to the reference over its last quarter [m]')
    made.add_argument('--settled-within', type=positive, default=BAND, metavar='M',
                      help='an error has settled that stays smaller: of settling_time and share_within_band [m]')
    add_worker_options(made)
    options = made.parse_args(arguments)
    if options.longest_delay is not None and options.longest_delay > LONGEST_DELAY:
        made.error(f'--longest-delay {options.longest_delay}: it must be at most {LONGEST_DELAY}')
    options.metric = list(dict.fromkeys(options.metric))
    return options


def study_controllers(options: argparse.Namespace) -> dict[str, Configuration]:
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


def _table(results: dict[str, StudiedController]) -> str:
    """Return all runs as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(study_columns(results))
    writer.writerows(map(as_cell, row) for row in study_rows(results))
    return text.getvalue()


def _map(results: dict[str, StudiedController], file: Path) -> str:
    """Draw the map of starts; return its SVG."""
    return draw_starts_map({
        f'{name.replace("_", " ")}: {100.0 * sum(run.success for run in judged) / len(judged):.2f} %': Starts(
            [Start(scenario.start, run.success, run.outcome)
             for scenario, run in zip(scenarios, judged, strict=False) if scenario.start is not None],
            best_split(scenarios, judged),
        ) for name, (scenarios, judged, _, _) in results.items()
    }, file)


def _run(options: argparse.Namespace) -> int:
    controllers = study_controllers(options)
    check_study(options, controllers)
    folder = Path(options.output)
    if (folder / 'study.json').exists() and not options.overwrite:
        raise ParameterError([f'{folder}: holds a study already; name another folder, or add --overwrite'])
    folder.mkdir(parents=True, exist_ok=True)
    # nothing long begins before the place is known to be writable
    writable_file(str(folder / 'runs.csv'))
    total = options.runs * len(controllers)
    with runner(options) as run, Interrupt() as interrupt, tqdm(total=total, disable=None, unit='run') as bar:
        results = run_study(options, controllers, run, bar.update, lambda: interrupt.requested)
    if not results:
        print('study: interrupted before the first runs were done', file=sys.stderr)
        return 1
    values = study_values(options, results, interrupt.requested)
    write_atomically(folder / 'study.json', json.dumps(values, indent=2) + '\n')
    write_atomically(folder / 'runs.csv', _table(results))
    svg = _map(results, folder / 'starts.png')
    write_study_page(folder / 'study.html', {
        name: StudiedRuns(one.scenarios, one.judged, one.promise,
                          # after Ctrl-C nothing more is driven
                          {} if interrupt.requested else replayed_runs(one, options.laps))
        for name, one in results.items()}, Judgement(values['success'], tuple(options.metric), options.settled_within),
        svg, interrupt.requested)
    print(*study_lines(options, results), sep='\n')
    if interrupt.requested:
        print('study: interrupted; the files hold what was done', file=sys.stderr)
        return 1
    return 0


main = make_main('study', parse_study, _run)

if __name__ == '__main__':
    sys.exit(main())
