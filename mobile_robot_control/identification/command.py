"""
The command `identify`: find the parameters of a robot, with intervals, in bags of its motion.

Bags of `cmd_vel` and `odom` give the base of a robot that takes velocities (docs/base.md). Bags with efforts
in `joint_states` give mass, inertia and friction of a robot that takes torques; if such a robot takes
`cmd_vel`, add `-p plant.drive:=velocity`. The model is the plant's own, driven by the recorded commands. It
needs the extra `fast`.

Each number has a 95 % interval that allows for correlated residuals. Limits and dead zones are written where the
recording shows them. A model fitted without the last fifth of each bag predicts it, and the error judges it: below
10 % of the motion, and with a twist of odom that agrees with its poses, it is good, up to 30 % usable; a worse one
is written with --accept alone. Intervals of a model that fails a test are wider by its error. Numbers that the
recording leaves open are named with what to record, and not written.

- `base.dead_time` includes the latency of odometry, unless --same-clock separates them, and a lag too short to show.
- A pose from outside, `ground_truth` in any frame, gives `odometry.radius_error`, `odometry.separation_error` and
  `odometry.slip`; without one, `wheel_gain` and `turn_gain` are those that odometry shows.
- Torques tell `A + B`, `A - B` and friction; mass and inertia follow from these with the given `wheel_inertia`
  and `com_offset`. A lost effort is unknown: behind it the motion goes on from a velocity of its own. With
  `wheel_torques`, the torques asked for, efforts also tell gain, lag and delay of the motors.

For example:
  mrc identify runs/fast/bag --output my_robot.yaml --report runs/identified
  mrc identify runs/fast/bag --check

Files written:
  FILE.yaml            the numbers found, for every node and command; its section `identify` has `names`,
                       `values` and `covariance`, row by row
  FILE.STACK.yaml      with --export: the numbers that nav2 or ros2_control take, with intervals and meaning
  identification.html  with --report: the page, with the values of --compare beside those found
  identification.json  with --report: the same numbers

Exit codes:
  0  done
  1  nothing can be identified, with the reason, or the model is not usable
  2  bad usage, or a bag that cannot be read
"""

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Annotated, NamedTuple

from mobile_robot_control.cli import make_main, make_parser, request_of
from mobile_robot_control.identification.export import STACKS, export_text
from mobile_robot_control.identification.page import answer, identification_page, regime_lines
from mobile_robot_control.identification.request import IdentificationRequest, identified, read_inputs
from mobile_robot_control.identification.result import (
    UNUSABLE,
    Identification,
    Parameter,
    UnidentifiableError,
    compared,
    parameter_text,
)
from mobile_robot_control.parameters.declaration import Field, ParameterError, flatten
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.system.files import check_place, write_atomically
from mobile_robot_control.system.progress import tqdm
from mobile_robot_control.system.texts import printable


class _Files(NamedTuple):
    """Where the result goes."""

    output: Annotated[str | None, Field('', 'parameter file to write; required without --check')] = None
    report: Annotated[str | None, Field('', 'folder for identification.html and identification.json')] = None
    compare: Annotated[str | None, Field('', 'parameter file or name of a robot to compare with on the page')] = None
    accept: Annotated[bool, Field('', 'write the file of a model that misses more than 30 % of the motion, too, '
                                      'without intervals')] = False
    export: Annotated[str | None, Field('', 'also write the numbers that another stack takes, by its names, beside the '
                                            'output', choices=STACKS)] = None
    check: Annotated[bool, Field('', 'only say what the bags lack, and what to record')] = False


def parser() -> argparse.ArgumentParser:
    """Make the parser of `identify`."""
    return make_parser('identify', __doc__, IdentificationRequest, _Files, positional=('bags',))


def _run(options: argparse.Namespace) -> int:
    request, files = request_of(IdentificationRequest, options), request_of(_Files, options)
    if files.check:
        return _check(request)
    if files.output is None:
        raise ParameterError(['--output is missing: name the parameter file to write, such as my_robot.yaml'])
    output = Path(files.output)
    for file in (output, *([Path(files.report) / 'identification.html'] if files.report else ())):
        check_place(file)
    other = None if files.compare is None else ParameterSources(files.compare).configuration()
    with tqdm(desc='identify', disable=None, leave=False, bar_format='{desc}: {n} steps [{elapsed}]{postfix}') as bar:
        try:
            result = identified(request, options.command_line, bar.update, lambda done, total: bar.set_postfix_str(
                f'read {done / max(1, total):.0%}'))
        except UnidentifiableError as error:
            for reason in error.reasons:
                print(f'identify: {printable(reason)}', file=sys.stderr)
            return 1
    is_written = files.accept or result.judgement.grade != UNUSABLE
    if is_written:
        output.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(output, parameter_text(result))
        if files.export is not None:
            exported = output.with_suffix(f'.{files.export}{output.suffix}')
            write_atomically(exported, export_text(result, files.export))
            print(f'{files.export}: {printable(str(exported.resolve()))}')
    if files.report is not None:
        folder = Path(files.report)
        folder.mkdir(parents=True, exist_ok=True)
        other_values = {} if other is None else flatten(other.plant.model) | {
            f'robot.{name}': value for name, value in flatten(other.plant.shared.robot).items()}
        title = f'Identified: {", ".join(Path(bag).name for bag in request.bags)}'
        write_atomically(folder / 'identification.html', identification_page(
            result, title, compared(result, other_values), files.compare or ''))
        write_atomically(folder / 'identification.json', json.dumps(_values(result), indent=2) + '\n')
        print(f'page: {printable(str((folder / "identification.html").resolve()))}')
    for line in _lines(result):
        print(printable(line))
    if not is_written:
        print(f'identify: the model is not usable, and {printable(str(output))} is not written; record another bag, or '
              'add --accept', file=sys.stderr)
        return 1
    print(f'parameters: {printable(str(output.resolve()))}')
    return 0


def _check(request: IdentificationRequest) -> int:
    """Print what bags lack; 1 where nothing can be identified from them."""
    inputs = read_inputs(request)
    lacks = inputs.lacks
    for told in (*lacks, *inputs.problems):
        print(printable(str(told)))
    if not (lacks or inputs.problems):
        print('nothing is missing')
    return 1 if any(lack.is_vital for lack in lacks) else 0


def _lines(result: Identification) -> list[str]:
    """Return a result as lines: the answer, each number, and what is not known."""
    numbers = [f'  {one.name} = {one.value:.4g} {one.unit}'.rstrip() + (
        f' ({one.low:.4g} to {one.high:.4g})' if math.isfinite(one.low) else '')
        for one in (*result.parameters, *result.reported)]
    measured = ', '.join(f'{name} {value:.4g}' if isinstance(value, float) else f'{name} {value}'
                         for name, value in result.facts.items())
    return [answer(result), *regime_lines(result.judgement), *numbers, f'recorded: {measured}',
            *(f'not told: {text}' for text in result.open), *(f'the model lacks: {text}' for text in result.lacking)]


def _values(result: Identification) -> dict[str, object]:
    """Return a result ready for JSON."""
    def listed(parameters: tuple[Parameter, ...]) -> list[dict[str, object]]:
        return [{'name': one.name, 'value': one.value, 'unit': one.unit,
                 'interval': [one.low, one.high] if math.isfinite(one.low) else None} for one in parameters]

    judgement = result.judgement._asdict() | {'error': result.judgement.error}
    return {'drive': result.drive, 'judgement': judgement, 'parameters': listed(result.parameters),
            'reported': listed(result.reported), 'names': result.names, 'covariance': result.covariance.tolist(),
            'facts': result.facts, 'rms_error': {name: list(value) for name, value in result.errors.items()},
            'open': result.open, 'lacking': result.lacking, 'notes': result.notes, 'provenance': result.provenance}


main = make_main(parser, _run)

if __name__ == '__main__':
    sys.exit(main())
