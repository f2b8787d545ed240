"""
The command `experiment`: run the four nodes over DDS, record every topic, measure and draw.

In lockstep a run takes its duration at wall speed; add `-p plant.real_time_factor:=0.0` to run as fast as
possible. With `config/wall_clock.yaml` the nodes run on the wall clock. The robot starts as in `simulate`.

For example:
  mrc experiment --duration 16 --params-file config/fuzzy.yaml --output runs/fuzzy
  mrc experiment --duration 16 --output runs/fast --composed --no-report -p plant.real_time_factor:=0.0
  mrc experiment --duration 16 --output runs/two --compare config/backstepping.yaml config/fuzzy.yaml
  mrc experiment --replay runs/fast --output runs/again --composed --no-report -p plant.real_time_factor:=0.0
  mrc experiment --duration 9 --output runs/mine --node 'reference_cart=python examples/foreign_nodes/reference_cart.py'
  mrc experiment --duration 16 --output runs/real --attach plant --yes --params-file base.yaml

Files written to DIR, or with --compare to DIR/NAME for each file and a report for all to DIR:
  bag/             every topic of the namespace, mcap
  parameters.yaml  all parameters of the run with its start pose, headed by the robot of --robot
  metrics.json     the metrics, which --json prints instead of a sentence (docs/metrics.md#metricsjson)
  report.html, report.json, figures/
                   as of `report`
  log/             output of each node; the Fast DDS settings of the run; ROS's own log files where it
                   cannot write them (ROS_LOG_DIR, ROS_HOME, HOME)

With --compare, a file whose NAME would be `..` or that of another file in DIR is refused.

When a node dies, hangs or refuses its parameters, the experiment ends with exit code 1 and its name; when
the disk is full, with the name of the file. The recording is complete up to there: a run in lockstep waits
for its recorder, however busy the machine is. The bag is written every half second, so that even after
`kill -9` it is readable up to there. Another process watches: when ROS 2 hangs in a library, as it may
without memory, it kills the experiment after --patience, at least 30 s, or 20 s after Ctrl-C or SIGTERM.

A refused experiment, such as one beside another robot on the same topics, leaves DIR as it was. With
--overwrite the old run lies in DIR/.replaced until the new one has run.

--attach plant drives a robot that runs already, on the wall clock. Without --yes nothing moves: the command
says what it would do. At the end, on Ctrl-C, and when this process is killed, another one sends zero commands
until the robot stands. That needs a network and a process: keep a hand on the robot's switch.

--replay is described in docs/usage.md#repeat-a-run, --node in
docs/lockstep.md#in-the-place-of-one-of-ours.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.cli import make_dds_main, make_parser, request_of
from mobile_robot_control.experiment.request import ExperimentRequest, Experiments, Performed
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.ros.shared.process import Stop
from mobile_robot_control.runs.words import run_sentence
from mobile_robot_control.system.texts import printable


class _Output(NamedTuple):
    """How the result is told."""

    json: Annotated[bool, Field('', 'print the metrics as one JSON object')] = False


class _Consent(NamedTuple):
    """Whether an attached robot may move."""

    yes: Annotated[bool, Field('', 'move an attached robot')] = False


def parser() -> argparse.ArgumentParser:
    """Make the parser of `experiment`."""
    # before all else: a signal is not lost
    stop = Stop()
    command = make_parser('experiment', __doc__, ExperimentRequest, _Output, _Consent, drives=True)
    command.set_defaults(stop=stop)
    return command


def _run(options: argparse.Namespace) -> int:
    request, output = request_of(ExperimentRequest, options), request_of(_Output, options)
    if output.json and request.compare:
        raise ParameterError(['--json is not allowed with --compare, whose metrics are in report.json'])
    experiments, folder = Experiments(request, options.command_line, options.stop), printable(
        str(Path(request.output).absolute()))
    if 'plant' in request.attach and not request_of(_Consent, options).yes:
        print(f'would drive the robot {experiments.intention()}; clear that floor, keep a hand on the switch, and '
              'repeat with --yes')
        return 0
    if request.compare:
        reasons = experiments.compare()
        print(f'all runs and the report over them: {folder}')
        return 1 if reasons else 0
    performed = experiments.run()
    result = performed.result
    print(json.dumps(performed.metrics, indent=2) if output.json else f'{_sentence(performed, request)}.')
    if result.reason or result.outcome == 'interrupted':
        print(f'experiment: {result.reason or "interrupted"}', file=sys.stderr)
    if not output.json:
        print(f'{"bag, metrics and report" if request.report else "bag and metrics"}: {folder}')
    return 0 if result.outcome == 'completed' and not result.reason else 1


def _sentence(performed: Performed, request: ExperimentRequest) -> str:
    return run_sentence(performed.metrics, performed.parameters, not performed.parameters.plant.shared.lockstep,
                        others=[*request.attach, *(name for name, _ in request.node)])


main = make_dds_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
