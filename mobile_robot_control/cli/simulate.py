"""The command `simulate`: the four nodes' closed loop in one process, without ROS."""

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, redirect_stdout
from pathlib import Path
from typing import Any

from mobile_robot_control.cli.command_parser import make_parser
from mobile_robot_control.cli.interrupt import Interrupt
from mobile_robot_control.cli.options import configuration, configuration_text, make_main, positive, writable_file
from mobile_robot_control.cli.progress import tqdm
from mobile_robot_control.cli.run_length import ONE_RUN, check_run_length
from mobile_robot_control.control.law import LawFailedError
from mobile_robot_control.files import naming_errors, write_atomically
from mobile_robot_control.parameters.nodes import has_exact_odometry
from mobile_robot_control.recording.csv_table import write_csv
from mobile_robot_control.reporting.run_words import run_sentence
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.metrics import summary
from mobile_robot_control.simulation.rollout import measure, rollout
from mobile_robot_control.texts import printable


def parse_simulate(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line of `simulate`; that of the process where it is None."""
    made = make_parser('simulate', __doc__)
    made.add_argument('--duration', type=positive, required=True, metavar='S', help='simulated time [s]')
    made.add_argument('--output', metavar='FILE.csv',
                      help='write one row a velocity step; FILE.parameters.yaml and FILE.metrics.json go with it')
    made.add_argument('--json', action='store_true', help='print all metrics as one JSON object')
    return made.parse_args(arguments)


def noting_failure(samples: Iterable[Sample], failures: list[str]) -> Iterator[Sample]:
    """Yield samples; note why the law failed."""
    try:
        yield from samples
    except LawFailedError as error:
        failures.append(str(error))
        raise


def _until(interrupt: Interrupt, samples: Iterable[Sample]) -> Iterator[Sample]:
    """Yield samples until an interrupt is requested."""
    for sample in samples:
        yield sample
        if interrupt.requested:
            return


def outcome_text(metrics: Mapping[str, Any], law: str, failures: Sequence[str]) -> str:
    """Return why a run with these metrics did not reach its end, in words; '' where it did."""
    at = f'at t = {metrics["duration"]} s'
    return {
        'completed': '',
        'interrupted': f'interrupted {at}',
        'diverged': f'the motion diverged {at}; lower the gains or raise the rates',
        'law_failed': f"the position law '{law}' failed {' '.join(failures)}",
    }[metrics['outcome']]


def _run(options: argparse.Namespace) -> int:
    parameters = configuration(options)
    check_run_length(f'--duration {options.duration:g}', options.duration, parameters.plant.shared.velocity_rate,
                     ONE_RUN)
    failures: list[str] = []
    with ExitStack() as stack:
        # what a law prints must not be among the results
        stack.enter_context(redirect_stdout(sys.stderr))
        interrupt = stack.enter_context(Interrupt())
        samples: Iterable[Sample] = noting_failure(rollout(parameters, options.duration), failures)
        if options.output:
            stack.enter_context(naming_errors(Path(options.output)))
            path = writable_file(options.output)
            file = stack.enter_context(path.open('w', encoding='utf-8', newline=''))
            samples = write_csv(samples, file, not has_exact_odometry(parameters.plant))
            plant = parameters.plant._replace(duration=options.duration)
            ran_with = configuration_text(parameters._replace(plant=plant), options.robot)
            write_atomically(path.with_suffix('.parameters.yaml'), ran_with)
            path.with_suffix('.metrics.json').unlink(missing_ok=True)
        steps = round(options.duration * parameters.plant.shared.velocity_rate) + 1
        # disable=None shows the bar on a terminal only
        shown = tqdm(samples, total=steps, disable=None, leave=False)
        run = measure(parameters, options.duration, _until(interrupt, shown))
    if interrupt.requested and run.outcome == 'diverged':
        run = run._replace(outcome='interrupted')
    metrics = summary(run)
    if options.output:
        write_atomically(path.with_suffix('.metrics.json'), json.dumps(metrics, indent=2) + '\n')
    print(json.dumps(metrics) if options.json else f'{run_sentence(metrics, parameters)}.')
    if options.output and not options.json:
        print(f'table, parameters and metrics: {printable(str(path.resolve()))} and beside it')
    why = outcome_text(metrics, parameters.position_controller.control.controller_type, failures)
    if why:
        print(f'simulate: {why}', file=sys.stderr)
    return 1 if why else 0


main = make_main('simulate', parse_simulate, _run)

if __name__ == '__main__':
    sys.exit(main())
