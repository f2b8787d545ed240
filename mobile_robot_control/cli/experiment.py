"""The command `experiment`: the four nodes as processes over DDS, recorded, measured and drawn."""

import argparse
import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from mobile_robot_control.cli.arguments import command, configuration, parser, positive, written
from mobile_robot_control.configuration import Configuration
from mobile_robot_control.parameters import ParameterError
from mobile_robot_control.ros.executables import Stop

_MADE_BY_US = ('bag', 'log', 'parameters.yaml', 'metrics.json', 'report.html', 'report.json', 'figures')


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    made = parser('experiment', __doc__.partition(': ')[2])
    made.add_argument('--duration', type=positive, required=True, metavar='S', help='simulated time [s]')
    made.add_argument('--output', required=True, metavar='DIR', help='folder for bag, metrics and pictures')
    made.add_argument('--overwrite', action='store_true', help='replace an experiment that DIR already holds')
    made.add_argument('--composed', action='store_true', help='all four nodes in one process')
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
    (output / 'parameters.yaml').write_text(written(parameters), encoding='utf-8')


def _run(options: argparse.Namespace, stop: Stop) -> int:
    parameters = configuration(options, options.namespace, [f'plant.duration:={options.duration!r}'])
    if not parameters.plant.shared.lockstep:
        raise ParameterError(["lockstep = false: an experiment needs lockstep; add -p '/**.lockstep:=true', "
                              'or start the nodes by themselves'])
    output = Path(options.output)
    _prepare(output, options.overwrite, parameters)
    # imported late: bad usage is told at once
    from mobile_robot_control.cli import conduct  # noqa: PLC0415
    from mobile_robot_control.cli.evaluate import evaluate  # noqa: PLC0415

    conducted = conduct.conduct(
        parameters, output, options.namespace, composed=options.composed, patience=options.patience, stop=stop
    )
    metrics = evaluate(output, options.namespace, conducted.outcome)
    print(json.dumps(metrics, indent=2))
    if conducted.reason:
        print(f'experiment: {conducted.reason}', file=sys.stderr)
    print(f'bag, metrics and report: {output.resolve()}')
    return 0 if conducted.outcome in ('completed', 'interrupted') else 1


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
