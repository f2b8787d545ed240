"""
The command `simulate`: run the closed loop of the four nodes in one process, without ROS.

It calls the functions of the nodes in their order, and gives their numbers. The robot starts at rest at
the start of the reference cart, on the curve and facing along it; `plant.initial_pose` moves the start.
A run has 1 to 1e9 velocity steps.

For example:
  simulate --duration 16 --params-file config/fuzzy.yaml --output run.csv
  simulate --duration 16 -p plant.max_wheel_torque:=1.0 -p 'plant.initial_pose:=[0.8, -0.1, 0.3]' --json

Files written:
  FILE.csv              the run, one row per velocity step (docs/metrics.md#the-table-of-a-run)
  FILE.parameters.yaml  all parameters of the run, headed by the robot of --robot
  FILE.metrics.json     the metrics, which --json prints instead of a sentence (docs/metrics.md#metricsjson)
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.api.simulation_files import SimulationFiles, simulate_into_files
from mobile_robot_control.cli.command_parser import make_parser, request_of
from mobile_robot_control.cli.main import make_main
from mobile_robot_control.pages.run_words import run_sentence
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.simulation.simulate import SimulationRequest
from mobile_robot_control.system.texts import printable


class _Output(NamedTuple):
    """How the result is told."""

    json: Annotated[bool, Field('', 'print the metrics as one JSON object')] = False


def parser() -> argparse.ArgumentParser:
    """Make the parser of `simulate`."""
    return make_parser('simulate', __doc__, SimulationRequest, SimulationFiles, _Output)


def _run(options: argparse.Namespace) -> int:
    files, output = request_of(SimulationFiles, options), request_of(_Output, options)
    found, parameters = simulate_into_files(request_of(SimulationRequest, options), files, options.command_line)
    print(json.dumps(found.metrics) if output.json else f'{run_sentence(found.metrics, parameters)}.')
    if files.output is not None and not output.json:
        print(f'table, parameters and metrics: {printable(str(Path(files.output).resolve()))} and beside it')
    if found.failure:
        print(f'simulate: {found.failure}', file=sys.stderr)
    return 1 if found.failure else 0


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
