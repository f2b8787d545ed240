"""What the robots of this package do, measured by the commands themselves, as Markdown tables for docs/robots.md."""

import hashlib
import json
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from command_output import output_of
from page_part import PagePart, table_row

from mobile_robot_control.settings.configure import configure, shipped_robots
from mobile_robot_control.settings.files import load

PART = PagePart('results')
_NO_SLIP = ('-p', 'plant.odometry.slip:=0.0')
_STUDY = '--runs 300 --seed 1'
VARIED = {
    'create3': '--variation 0.5 --longest-delay 8',
    'kobuki': '--variation 0.5 --longest-delay 8',
    'jackal': '--variation 0.5 --longest-delay 8',
    'turtlebot3_burger': '--variation 0.5 --longest-delay 2',
    'turtlebot3_burger_base': '--variation 0.5 --longest-delay 8',
    'turtlebot3_waffle': '--variation 0.5 --longest-delay 8',
    'turtlebot4': '--variation 0.5 --longest-delay 8',
}
"""Options of the study by robot, where what it varies is a placeholder: lag, dead zone and dead time, or friction."""


def results_fingerprint(robots: Mapping[str, Path]) -> str:
    """Return a few digits that change with the file of any robot, and with the options of the studies."""
    content = b''.join(file.read_bytes() for file in robots.values())
    return hashlib.sha256(content + repr((_STUDY, VARIED)).encode()).hexdigest()[:12]


def lap_command(robot: str, file: Path) -> str:
    """Return the shell command that drives one lap of the robot's curve."""
    period = configure(load([file])).reference_cart.curve.placement.period
    return f'simulate --robot {robot} --duration {period:g} --json'


def study_command(robot: str) -> str:
    """Return the shell command that studies a robot, without its place to write to."""
    return ' '.join(filter(None, (f'study --robot {robot} {_STUDY}', VARIED.get(robot, ''))))


def _lap(robot: str, file: Path, *more: str) -> dict[str, Any]:
    """Drive a lap; return its metrics."""
    metrics: dict[str, Any] = json.loads(output_of(lap_command(robot, file), *more))
    return metrics


def _studied(robot: str) -> dict[str, Any]:
    """Study a robot; return the numbers of its controller, as in study.json."""
    with tempfile.TemporaryDirectory() as folder:
        output_of(study_command(robot), '--output', folder)
        found: dict[str, dict[str, Any]] = json.loads((Path(folder) / 'study.json').read_text())['controllers']
    numbers, = found.values()
    return numbers


def _centimetres(length: float | None) -> str:
    return '–' if length is None else f'{100.0 * length:.2f} cm'


def _margins(loop: Mapping[str, float | None] | None) -> str:
    """Return gain and delay margin of a loop; the studies search delays up to 20 periods at least."""
    if loop is None:
        return '–'
    gain, delay = loop['gain'], loop['delay']
    return (f'{"more than 20" if gain is None else f"{gain:.2f}"}, '
            f'{"more than 20 periods" if delay is None else f"{1e3 * delay:.0f} ms"}')


_HEAD = ('robot', 'lap', 'RMS error', 'largest error', 'RMS error without slip', 'success', '95 % interval',
         'late error, median', 'late error, 95 % quantile',
         'velocity loop: gain and delay margin', 'position loop: gain and delay margin')


def result_cells(
    robot: str, lap: Mapping[str, Any], no_slip: Mapping[str, Any], study: Mapping[str, Any]
) -> list[str]:
    """
    Return the row of a robot.

    Parameters
    ----------
    robot : str
        Its name.
    lap, no_slip : mapping
        What `mrc simulate --json` prints of a lap, and of one in which odometry does not slip.
    study : mapping
        The numbers of its controller in study.json.

    """
    low, high = (100.0 * bound for bound in study['success_interval'])
    late = study['metrics']['late_max_position_error']
    return [robot, f'{lap["duration"]:g} s', _centimetres(lap['rms_position_error']),
            _centimetres(lap['max_position_error']), _centimetres(no_slip['rms_position_error']),
            f'{study["successes"]} of {study["runs"]}',
            f'{low:.2f} to {high:.2f} %', _centimetres(late['median']), _centimetres(late['95_percent']),
            _margins(study['margins']['velocity_loop']), _margins(study['margins']['position_loop'])]


def _lines(robots: Mapping[str, Path]) -> Iterator[str]:
    """Yield the lines of the tables: what is measured, and the commands that measure it."""
    rows = [result_cells(robot, _lap(robot, file), _lap(robot, file, *_NO_SLIP), _studied(robot))
            for robot, file in robots.items()]
    yield from (table_row(_HEAD), f'|{"---|" * len(_HEAD)}', *map(table_row, rows))
    yield from ('', '| robot | commands |', '|---|---|')
    for robot, file in robots.items():
        yield f'| {robot} | `mrc {lap_command(robot, file)}` and `mrc {study_command(robot)} --output DIR` |'


def results_markdown(robots: Mapping[str, Path]) -> str:
    """Measure the robots; return Markdown tables between marks, with the fingerprint of their files."""
    return PART.marked(results_fingerprint(robots), _lines(robots))


if __name__ == '__main__':
    PART.write(sys.argv[1:], results_markdown(shipped_robots()))
