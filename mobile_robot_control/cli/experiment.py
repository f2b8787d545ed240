"""The command `experiment`: the four nodes as processes over DDS, recorded, measured and drawn."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.cli.command_parser import make_parser, request_of
from mobile_robot_control.cli.main import make_main
from mobile_robot_control.experiment.experiment import ExperimentRequest, Experiments, Performed
from mobile_robot_control.pages.run_words import run_sentence
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.ros.services.stop import Stop
from mobile_robot_control.system.supervisor import leave_dds
from mobile_robot_control.system.texts import printable


class _Output(NamedTuple):
    """How the result is told."""

    json: Annotated[bool, Field('', 'print all metrics as one JSON object')] = False


def parser() -> argparse.ArgumentParser:
    """Make the parser of `experiment`."""
    # before all else: a signal is not lost
    stop = Stop()
    made = make_parser('experiment', __doc__, ExperimentRequest, _Output)
    made.set_defaults(stop=stop)
    return made


def _run(options: argparse.Namespace) -> int:
    request, output = request_of(ExperimentRequest, options), request_of(_Output, options)
    if output.json and request.compare:
        raise ParameterError(['--json is not allowed with --compare, whose metrics are in report.json'])
    experiments, folder = Experiments(request, options.command_line, options.stop), printable(
        str(Path(request.output).resolve()))
    if request.compare:
        reasons = experiments.compare()
        print(f'all runs and the report over them: {folder}')
        return 1 if reasons else 0
    performed = experiments.run()
    result = performed.result
    print(json.dumps(performed.metrics, indent=2) if output.json else f'{_sentence(performed)}.')
    if result.reason or result.outcome == 'interrupted':
        print(f'experiment: {result.reason or "interrupted"}', file=sys.stderr)
    if not output.json:
        print(f'{"bag, metrics and report" if request.report else "bag and metrics"}: {folder}')
    return 0 if result.outcome == 'completed' and not result.reason else 1


def _sentence(performed: Performed) -> str:
    return run_sentence(performed.metrics, performed.parameters, not performed.parameters.plant.shared.lockstep)


_main = make_main(parser, _run)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code, also where to leave DDS hangs, as it may where many processes end."""
    return leave_dds(int(_main(arguments)))


if __name__ == '__main__':
    sys.exit(main())
