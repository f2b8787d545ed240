"""
The command `simulate`: run the closed loop of the four nodes in one process, without ROS.

It calls the functions of the nodes in their order, and gives their numbers. The robot starts at rest at
the start of the reference cart, on the curve and facing along it; `plant.initial_pose` moves the start.
A run has 1 to 1e9 velocity steps.

For example:
  mrc simulate --duration 16 --params-file config/fuzzy.yaml --output run.csv
  mrc simulate --duration 16 -p plant.max_wheel_torque:=1.0 -p 'plant.initial_pose:=[0.8, -0.1, 0.3]' --json

Files written:
  FILE.csv              the run, one row per velocity step (docs/metrics.md#the-table-of-a-run)
  FILE.parameters.yaml  all parameters of the run, headed by the robot of --robot
  FILE.metrics.json     the metrics, which --json prints instead of a sentence (docs/metrics.md#metricsjson)
"""

import argparse
import json
import sys
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.cli import make_main, make_parser, request_of
from mobile_robot_control.loop.closed_loop import Sample
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.runs.csv_table import write_csv
from mobile_robot_control.runs.request import Simulation, SimulationRequest, SimulationResult
from mobile_robot_control.runs.words import run_sentence
from mobile_robot_control.settings.files import save_configuration
from mobile_robot_control.settings.nodes import Configuration, has_exact_odometry, known_course
from mobile_robot_control.settings.provenance import provenance
from mobile_robot_control.system.files import naming_errors, writable_file, write_atomically
from mobile_robot_control.system.process import Interrupt
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.system.texts import printable


class SimulationFiles(NamedTuple):
    """The files of a simulation."""

    output: Annotated[str | None, Field('', 'table of the run to write')] = None


def simulate_into_files(
    request: SimulationRequest, files: SimulationFiles, command_line: str
) -> tuple[SimulationResult, Configuration]:
    """Simulate until the end or an interrupt, and write; return the result, and the configuration."""
    simulation = Simulation(request)
    parameters = simulation.parameters
    with ExitStack() as stack:
        interrupt = stack.enter_context(Interrupt())
        table = None
        if files.output is not None:
            stack.enter_context(naming_errors(Path(files.output)))
            path = writable_file(files.output)
            table = stack.enter_context(path.open('w', encoding='utf-8', newline=''))
            save_configuration(path.with_suffix('.parameters.yaml'), parameters, request.sources.robot)
            path.with_suffix('.metrics.json').unlink(missing_ok=True)

        def written(samples: Iterable[Sample]) -> Iterable[Sample]:
            if table is not None:
                samples = write_csv(samples, table, not has_exact_odometry(parameters.plant))
            # disable=None shows the bar on a terminal only
            shown: Iterable[Sample] = tqdm(samples, total=simulation.steps, disable=None, leave=False)
            return shown

        result = simulation.run(written, lambda: interrupt.requested)
    if files.output is not None:
        content = {**result.metrics, 'provenance': provenance(command_line, parameters)}
        write_atomically(path.with_suffix('.metrics.json'), json.dumps(content, indent=2) + '\n')
    return result, parameters


class _Output(NamedTuple):
    """How the result is told."""

    json: Annotated[bool, Field('', 'print the metrics as one JSON object')] = False


def parser() -> argparse.ArgumentParser:
    """Make the parser of `simulate`."""
    return make_parser('simulate', __doc__, SimulationRequest, SimulationFiles, _Output, drives=True)


def _run(options: argparse.Namespace) -> int:
    files, output = request_of(SimulationFiles, options), request_of(_Output, options)
    result, parameters = simulate_into_files(request_of(SimulationRequest, options), files, options.command_line)
    for words in getattr(known_course(parameters.reference_cart), 'ignored', ()):
        print(printable(words), file=sys.stderr)
    print(json.dumps(result.metrics) if output.json else f'{run_sentence(result.metrics, parameters)}.')
    if files.output is not None and not output.json:
        print(f'table, parameters and metrics: {printable(str(Path(files.output).resolve()))} and beside it')
    if result.failure:
        print(f'simulate: {result.failure}', file=sys.stderr)
    return 1 if result.failure else 0


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
