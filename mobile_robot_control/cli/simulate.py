"""The command `simulate`: the four nodes' closed loop in one process, without ROS."""

import argparse
import json
import sys
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.cli.command_parser import make_parser, request_of
from mobile_robot_control.cli.main import make_main
from mobile_robot_control.configuration.files import configuration_text
from mobile_robot_control.configuration.nodes import has_exact_odometry
from mobile_robot_control.configuration.provenance import provenance
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.recording.csv_table import write_csv
from mobile_robot_control.reporting.run_words import run_sentence
from mobile_robot_control.simulation.closed_loop import Sample
from mobile_robot_control.simulation.simulate import Simulation, SimulationRequest
from mobile_robot_control.system.files import naming_errors, writable_file, write_atomically
from mobile_robot_control.system.interrupt import Interrupt
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.system.texts import printable


class _Output(NamedTuple):
    """What becomes of the run."""

    output: Annotated[str | None, Field('', 'FILE.csv to write, one row a velocity step; FILE.parameters.yaml and '
                                        'FILE.metrics.json go with it')] = None
    json: Annotated[bool, Field('', 'print all metrics as one JSON object')] = False


def parser() -> argparse.ArgumentParser:
    """Make the parser of `simulate`."""
    return make_parser('simulate', __doc__, SimulationRequest, _Output)


def _run(options: argparse.Namespace) -> int:
    simulation, output = Simulation(request_of(SimulationRequest, options)), request_of(_Output, options)
    parameters = simulation.parameters
    with ExitStack() as stack:
        interrupt = stack.enter_context(Interrupt())
        table = None
        if output.output is not None:
            stack.enter_context(naming_errors(Path(output.output)))
            path = writable_file(output.output)
            table = stack.enter_context(path.open('w', encoding='utf-8', newline=''))
            write_atomically(path.with_suffix('.parameters.yaml'), configuration_text(parameters, options.robot))
            path.with_suffix('.metrics.json').unlink(missing_ok=True)

        def written(samples: Iterable[Sample]) -> Iterable[Sample]:
            if table is not None:
                samples = write_csv(samples, table, not has_exact_odometry(parameters.plant))
            # disable=None shows the bar on a terminal only
            shown: Iterable[Sample] = tqdm(samples, total=simulation.steps, disable=None, leave=False)
            return shown

        metrics, failure = simulation.run(written, lambda: interrupt.requested)
    if output.output is not None:
        content = {**metrics, 'provenance': provenance(options.command_line, parameters)}
        write_atomically(path.with_suffix('.metrics.json'), json.dumps(content, indent=2) + '\n')
    print(json.dumps(metrics) if output.json else f'{run_sentence(metrics, parameters)}.')
    if output.output is not None and not output.json:
        print(f'table, parameters and metrics: {printable(str(path.resolve()))} and beside it')
    if failure:
        print(f'simulate: {failure}', file=sys.stderr)
    return 1 if failure else 0


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
