"""The command `experiment`: the four nodes as processes over DDS, recorded, measured and drawn."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mobile_robot_control.cli.command_parser import make_parser
from mobile_robot_control.cli.experiment_folders import WRITTEN, experiment_folders
from mobile_robot_control.cli.experiment_performance import perform, progress_bar
from mobile_robot_control.cli.namespace_option import add_namespace_option
from mobile_robot_control.cli.options import configuration, distinct, make_main, positive, ros_path
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.nodes import Configuration
from mobile_robot_control.reporting.run_words import run_sentence
from mobile_robot_control.ros.deadline import leave_dds
from mobile_robot_control.ros.environment import check_environment
from mobile_robot_control.ros.stop import Stop
from mobile_robot_control.texts import printable

if TYPE_CHECKING:
    from mobile_robot_control.cli.experiment_result import ExperimentResult
    from mobile_robot_control.cli.experiment_runner import Drive


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    # before all else: a signal is not lost
    stop = Stop()
    made = make_parser('experiment', __doc__)
    made.set_defaults(stop=stop)
    made.add_argument('--duration', type=positive, metavar='S', help='simulated time [s]; needed without --replay')
    made.add_argument('--output', type=ros_path, required=True, metavar='DIR',
                      help='folder for bag, metrics and pictures')
    made.add_argument('--overwrite', action='store_true', help='replace an experiment that DIR already holds')
    made.add_argument('--composed', action='store_true', help='all four nodes in one process')
    made.add_argument('--compare', nargs='+', metavar='FILE', default=[],
                      help='several parameter files, one run after the other on the same curve from the same start, '
                      'and one report over all')
    made.add_argument('--replay', metavar='BAG', help='experiment in lockstep, or its bag: the run is done again with '
                      'all that changed it, and must be the same to the last bit')
    made.add_argument('--json', action='store_true', help='print all metrics as one JSON object')
    made.add_argument('--no-report', action='store_false', dest='with_report', help='write the metrics alone')
    add_namespace_option(made, 'in which the nodes run')
    made.add_argument('--patience', type=positive, default=20.0, metavar='S',
                      help='wall time without progress after which a run is given up')
    options = made.parse_args(arguments)
    if options.duration is None and options.replay is None:
        made.error('the following arguments are required: --duration')
    if options.json and options.compare:
        made.error('argument --json: not allowed with argument --compare, whose metrics are in report.json')
    if options.replay is not None and options.compare:
        made.error('argument --replay: not allowed with argument --compare')
    return options


def _configured(options: argparse.Namespace, extra_files: Sequence[str] = ()) -> Configuration:
    parameters = configuration(options, options.namespace, [f'plant.duration:={options.duration!r}'], extra_files)
    if not parameters.plant.shared.stamped_cmd_vel:
        raise ParameterError(["stamped_cmd_vel = false: an experiment's topics are joined by their stamps; "
                              "add -p '/**.stamped_cmd_vel:=true'"])
    return parameters


def _run(options: argparse.Namespace) -> int:
    output = Path(options.output)
    if options.compare:
        return _compare(options, output)
    if options.replay is not None:
        return _replay(options, output)
    parameters = _configured(options)
    check_environment(output / 'log')
    with (experiment_folders({output: parameters}, options.overwrite, options.robot) as unused,
          progress_bar(options.duration) as bar):
        result, metrics = perform(options, parameters, output, bar, unused)
    return _tell(result, metrics, parameters, options)


def _tell(
    result: 'ExperimentResult', metrics: dict[str, Any], parameters: Configuration, options: argparse.Namespace
) -> int:
    """Print how an experiment ended; return the exit code."""
    print(json.dumps(metrics, indent=2) if options.json
          else f'{run_sentence(metrics, parameters, not parameters.plant.shared.lockstep)}.')
    if result.reason or result.outcome == 'interrupted':
        print(f'experiment: {result.reason or "interrupted"}', file=sys.stderr)
    if not options.json:
        written = 'bag, metrics and report' if options.with_report else 'bag and metrics'
        print(f'{written}: {printable(str(Path(options.output).resolve()))}')
    return 0 if result.outcome == 'completed' and not result.reason else 1


def _replay(options: argparse.Namespace, output: Path) -> int:
    """Do a recorded run again, and compare."""
    # imported late: most runs replay nothing
    from mobile_robot_control.cli.replay_plan import compare_replay, plan_replay  # noqa: PLC0415

    replay = plan_replay(options)

    def drive() -> 'Drive':
        from mobile_robot_control.cli.replay_run import ReplayRun  # noqa: PLC0415 (imports rclpy)

        return ReplayRun(replay)

    parameters = replay.configuration
    check_environment(output / 'log')
    with (experiment_folders({output: parameters}, options.overwrite) as unused,
          progress_bar(parameters.plant.duration * len(replay.runs)) as bar):
        result, metrics = perform(options, parameters, output, bar, unused, drive)
    if result.outcome != 'interrupted' and not result.reason:
        result = result._replace(reason=compare_replay(replay, output, options.namespace))
    return _tell(result, metrics, parameters, options)


def _alike(chosen: Configuration, first: Configuration) -> Configuration:
    """Return a configuration with the curve and the start of the first one."""
    return chosen._replace(
        reference_cart=chosen.reference_cart._replace(curve=first.reference_cart.curve),
        plant=chosen.plant._replace(initial_pose=first.plant.initial_pose),
    )


def _folders(files: Sequence[str]) -> list[str]:
    """Return the name of each run's folder within the output; raise ParameterError where it would not be one of it."""
    names = distinct([printable(Path(file).stem) for file in files])
    odd = [f"--compare {file}: its run would be written to '{name}', which has another use; rename the file"
           for file, name in zip(files, names, strict=True) if name in ('', '.', '..', *WRITTEN)]
    if odd:
        raise ParameterError(odd)
    return names


def _compare(options: argparse.Namespace, output: Path) -> int:
    """Run several configurations one after the other, and report them together."""
    # imported late: bad usage is reported at once
    from mobile_robot_control.cli.report import refuse_too_many, report  # noqa: PLC0415

    refuse_too_many(len(options.compare))
    names = _folders(options.compare)
    configured = [_configured(options, [file]) for file in options.compare]
    chosen = {name: _alike(parameters, configured[0]) for name, parameters in zip(names, configured, strict=True)}
    check_environment(output / names[0] / 'log')
    reasons: list[str] = []
    done: list[tuple[str, Path]] = []
    folders = {output / name: parameters for name, parameters in chosen.items()}
    with (experiment_folders(folders, options.overwrite, options.robot) as unused,
          progress_bar(options.duration * len(chosen)) as bar):
        for name, parameters in chosen.items():
            bar.set_description(name)
            result, _ = perform(options, parameters, output / name, bar, unused)
            done.append((name, output / name))
            if result.reason:
                reasons.append(f'{name}: {result.outcome}: {result.reason}')
            if options.stop.requested:
                reasons.append(f'{name}: interrupted')
                break
    for reason in reasons:
        print(f'experiment: {reason}', file=sys.stderr)
    print(f'experiment: drawing the report over {len(done)} runs', file=sys.stderr)
    unreadable = report(done, output, options.namespace, quiet=True)
    print(f'all runs and the report over them: {printable(str(output.resolve()))}')
    return 1 if reasons or unreadable else 0


_main = make_main('experiment', _parse, _run)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code, also where to leave DDS hangs, as it may where many processes end."""
    return leave_dds(int(_main(arguments)))


if __name__ == '__main__':
    sys.exit(main())
