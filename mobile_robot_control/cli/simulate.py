"""The command `simulate`: the four nodes' closed loop in one process, without ROS."""

import argparse
import json
import sys
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from typing import Any

from tqdm import tqdm

from mobile_robot_control.cli.arguments import command, configuration, parser, positive, writable_file, written
from mobile_robot_control.configuration import Configuration
from mobile_robot_control.recording import table
from mobile_robot_control.simulation.closed_loop import Sample, is_complete, rollout
from mobile_robot_control.simulation.metrics import RunMeter, summary


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    made = parser('simulate', __doc__.partition(': ')[2])
    made.add_argument('--duration', type=positive, required=True, metavar='S', help='simulated time [s]')
    made.add_argument('--output', metavar='FILE.csv',
                      help='write one row a velocity step; FILE.parameters.yaml and FILE.metrics.json go with it')
    made.add_argument('--json', action='store_true', help='print the metrics as one JSON object')
    return made.parse_args(arguments)


def simulate(parameters: Configuration, duration: float, samples: Iterable[Sample]) -> dict[str, Any]:
    """
    Let a rollout run to its end and give its metrics.

    Parameters
    ----------
    parameters : Configuration
        Checked.
    duration : float
        Asked for [s].
    samples : iterable of Sample
        Of :func:`rollout`.

    Returns
    -------
    dict of str to object
        As `simulate --json` prints it.

    """
    shared = parameters.plant.shared
    meter = RunMeter(1.0 / shared.velocity_rate, 1.0 / shared.position_rate)
    for sample in samples:
        meter.add(sample)
    complete = meter.last is not None and is_complete(meter.last, duration, shared.velocity_rate)
    return summary(meter.run('completed' if complete else 'diverged'))


def _run(options: argparse.Namespace) -> int:
    parameters = configuration(options)
    with ExitStack() as stack:
        samples: Iterable[Sample] = rollout(parameters, options.duration)
        if options.output:
            path = writable_file(options.output)
            file = stack.enter_context(path.open('w', encoding='utf-8', newline=''))
            samples = table.write(samples, file)
            plant = parameters.plant._replace(duration=options.duration)
            path.with_suffix('.parameters.yaml').write_text(written(parameters._replace(plant=plant)), encoding='utf-8')
            path.with_suffix('.metrics.json').unlink(missing_ok=True)
        steps = round(options.duration * parameters.plant.shared.velocity_rate) + 1
        # disable=None shows the bar on a terminal only
        metrics = simulate(parameters, options.duration, tqdm(samples, total=steps, disable=None, leave=False))
    if options.output:
        path.with_suffix('.metrics.json').write_text(json.dumps(metrics, indent=2) + '\n', encoding='utf-8')
    print(json.dumps(metrics) if options.json else '\n'.join(f'{name}: {value}' for name, value in metrics.items()))
    if metrics['outcome'] != 'completed':
        print(f'simulate: the motion diverged at t = {metrics["duration"]} s; lower the gains or raise the rates',
              file=sys.stderr)
        return 1
    return 0


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
    options = _parse(arguments)
    return command('simulate', lambda: _run(options))


if __name__ == '__main__':
    sys.exit(main())
