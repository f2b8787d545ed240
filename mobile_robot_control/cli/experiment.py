"""The command `experiment`: the four nodes as processes over DDS, recorded, measured and drawn."""

import argparse
import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mobile_robot_control.cli.arguments import command, distinct, parser, positive, written
from mobile_robot_control.cli.outputs import whole
from mobile_robot_control.cli.progress import Progress
from mobile_robot_control.configuration import Configuration, configure
from mobile_robot_control.parameter_files import load
from mobile_robot_control.parameters import ParameterError
from mobile_robot_control.ros.executables import Stop

if TYPE_CHECKING:
    from mobile_robot_control.cli.conduct import Conducted

_MADE_BY_US = ('bag', 'log', 'parameters.yaml', 'metrics.json', 'report.html', 'report.json', 'figures')


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    made = parser('experiment', __doc__.partition(': ')[2])
    made.add_argument('--duration', type=positive, required=True, metavar='S', help='simulated time [s]')
    made.add_argument('--output', required=True, metavar='DIR', help='folder for bag, metrics and pictures')
    made.add_argument('--overwrite', action='store_true', help='replace an experiment that DIR already holds')
    made.add_argument('--composed', action='store_true', help='all four nodes in one process')
    made.add_argument('--compare', nargs='+', metavar='FILE', default=[],
                      help='several parameter files, one run after the other on the same curve from the same start, '
                      'and one report over all')
    made.add_argument('--no-report', action='store_false', dest='with_report', help='write the metrics alone')
    made.add_argument('--namespace', default='/', metavar='NS', help='in which the nodes run')
    made.add_argument('--patience', type=positive, default=20.0, metavar='S',
                      help='wall time without progress after which a run is given up')
    return made.parse_args(arguments)


def _prepare(output: Path, overwrite: bool, parameters: Configuration) -> None:
    """Make the folder ready; nothing that an experiment did not write is ever removed."""
    output.mkdir(parents=True, exist_ok=True)
    earlier = [output / name for name in _MADE_BY_US if (output / name).exists()]
    if earlier and not overwrite:
        raise ParameterError([f'{output}: holds an experiment already; name another folder, or add --overwrite'])
    for path in earlier:
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    (output / 'log').mkdir()
    with whole(output / 'parameters.yaml') as file:
        file.write_text(written(parameters), encoding='utf-8')


def _configured(options: argparse.Namespace, extra_files: Sequence[str] = ()) -> Configuration:
    parameters = configure(load([*options.params_files, *extra_files],
                                [*options.overrides, f'plant.duration:={options.duration!r}'], options.namespace))
    if not parameters.plant.shared.stamped_cmd_vel:
        raise ParameterError(["stamped_cmd_vel = false: an experiment's topics are joined by their stamps; "
                              "add -p '/**.stamped_cmd_vel:=true'"])
    return parameters


def _perform(
    options: argparse.Namespace, parameters: Configuration, output: Path, stop: Stop, progress: Progress
) -> tuple['Conducted', dict[str, Any]]:
    """Run, record and evaluate one configuration; the reason says all that went wrong."""
    # imported late: bad usage is told at once
    from mobile_robot_control.cli import conduct  # noqa: PLC0415
    from mobile_robot_control.cli.evaluate import evaluate  # noqa: PLC0415

    conducted = conduct.conduct(parameters, output, options.namespace, composed=options.composed,
                                patience=options.patience, stop=stop, progress=progress)
    evaluated = evaluate(output, options.namespace, conducted.outcome, quiet=bool(options.compare),
                         with_report=options.with_report)
    reasons = [*filter(None, [conducted.reason]), *evaluated.unwritten]
    return conducted._replace(reason='\nexperiment: '.join(reasons)), evaluated.metrics


def _run(options: argparse.Namespace, stop: Stop) -> int:
    output = Path(options.output)
    if options.compare:
        return _compare(options, output, stop)
    parameters = _configured(options)
    _prepare(output, options.overwrite, parameters)
    with Progress(options.duration) as progress:
        conducted, metrics = _perform(options, parameters, output, stop, progress)
    print(json.dumps(metrics, indent=2))
    if conducted.reason:
        print(f'experiment: {conducted.reason}', file=sys.stderr)
    print(f'bag, metrics and report: {output.resolve()}')
    return 1 if conducted.reason else 0


def _alike(chosen: Configuration, first: Configuration) -> Configuration:
    """Give a configuration the curve and the start of the first one."""
    return chosen._replace(
        reference_cart=chosen.reference_cart._replace(curve=first.reference_cart.curve),
        plant=chosen.plant._replace(initial_pose=first.plant.initial_pose),
    )


def _compare(options: argparse.Namespace, output: Path, stop: Stop) -> int:
    """Run several configurations one after the other, and report them together."""
    # imported late: bad usage is told at once
    from mobile_robot_control.cli.report import refuse_too_many, report  # noqa: PLC0415

    refuse_too_many(len(options.compare))
    names = distinct([Path(file).stem for file in options.compare])
    configured = [_configured(options, [file]) for file in options.compare]
    chosen = {name: _alike(parameters, configured[0]) for name, parameters in zip(names, configured, strict=True)}
    for name, parameters in chosen.items():
        _prepare(output / name, options.overwrite, parameters)
    reasons: list[str] = []
    done: list[tuple[str, Path]] = []
    with Progress(options.duration * len(chosen)) as progress:
        for name, parameters in chosen.items():
            progress.name(name)
            conducted, _ = _perform(options, parameters, output / name, stop, progress)
            done.append((name, output / name))
            if conducted.reason:
                reasons.append(f'{name}: {conducted.outcome}: {conducted.reason}')
            if stop.requested:
                break
    for reason in reasons:
        print(f'experiment: {reason}', file=sys.stderr)
    unreadable = report(done, output, options.namespace, quiet=True)
    print(f'all runs and the report over them: {output.resolve()}')
    return 1 if reasons or unreadable else 0


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
    stop = Stop()
    options = _parse(arguments)
    return command('experiment', lambda: _run(options, stop))


if __name__ == '__main__':
    sys.exit(main())
