"""Files of trajectories: tables, YAML, WPILib's and Choreo's JSON; nothing is guessed, and errors name the place."""

import json
import math
import os
from collections.abc import Mapping, Sequence
from decimal import Decimal, InvalidOperation
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import LARGEST
from mobile_robot_control.reference.trajectory_parameters import TimedPoints
from mobile_robot_control.reference.waypoint_files import YAML_SUFFIXES, read_text, rows_of
from mobile_robot_control.reference.waypoints import DIRECTIONS, LONGEST, MOST, UNKNOWN, WRONG
from mobile_robot_control.system.texts import shortened

_REMEDY = 'write t,x,y and optionally heading,v with these names above the columns'
_LEAST = 4
"""Fewest points of a trajectory."""
_STANDING = 1e-3
"""[m/s]: a smaller velocity counts as none."""
Row = tuple[str, Mapping[str, Any]]
"""The place of a point in its source, and its numbers or texts by meaning: time, x, y, heading, speed."""


def read_trajectory(file: str | Path) -> TimedPoints:
    """
    Read a file of points with times.

    Parameters
    ----------
    file : path
        A table or YAML as for `read_waypoints`, with a column t; WPILib's array of states; a trajectory of Choreo.

    Raises
    ------
    ParameterError
        With file and place.

    """
    source, content = str(file), read_text(file)
    is_yaml, begin = Path(file).suffix in YAML_SUFFIXES, content.lstrip()[:1]
    if begin == '<':
        raise ParameterError([f'{source}: is XML; {_REMEDY}'])
    if begin in ('{', '[') and not is_yaml:
        return checked_trajectory(_json_rows(content, source), source)
    rows, frame, ignored = rows_of(content, source, is_yaml, timed=True)
    return checked_trajectory([(f'{source}:{line}', row) for line, row in rows], source)._replace(
        frame=frame, ignored=tuple(f'{source}: the column {shortened(name, 40)} is not used' for name in ignored))


def read_trajectory_once(file: str) -> TimedPoints:
    """Read a file as `read_trajectory` does; read it again only after a change."""
    try:
        status = os.stat(file)
    except (OSError, ValueError):
        return read_trajectory(file)
    return _read_version(file, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=8)
def _read_version(file: str, _changed: int, _size: int) -> TimedPoints:
    return read_trajectory(file)


def _json_rows(content: str, source: str) -> list[Row]:
    """Return the rows of a text in JSON."""
    try:
        tree: Any = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise ParameterError([f'{source}: is no JSON ({error}); {_REMEDY}']) from None
    samples = _choreo(tree, source) if isinstance(tree, Mapping) else tree
    if not isinstance(samples, list) or not all(isinstance(one, Mapping) for one in samples):
        raise ParameterError([f'{source}: holds no states with times; give the array of states of WPILib, a trajectory '
                              f'of Choreo, or {_REMEDY}'])
    return [(f'{source}: state {number}', _state(one)) for number, one in enumerate(samples)]


def _choreo(tree: Mapping[str, Any], source: str) -> Any:
    """Return the samples of a trajectory of Choreo; raise ParameterError for what has none, or those of a swerve."""
    anchors = tree.get('waypoints')
    if isinstance(anchors, list) and any(isinstance(one, Mapping) and 'anchor' in one for one in anchors):
        raise ParameterError([f'{source}: is a path of PathPlanner, which has no times: generate its trajectory, or '
                              "give its positions as a table to curve = 'path'"])
    inner = tree.get('trajectory')
    samples = inner.get('samples') if isinstance(inner, Mapping) else tree.get('samples')
    if samples == []:
        raise ParameterError([f'{source}: has no samples; generate the trajectory in Choreo first'])
    if isinstance(samples, list) and any(
            isinstance(one, Mapping) and {'vx', 'vy', 'velocityX', 'velocityY'} & {*one} for one in samples):
        raise ParameterError([f'{source}: is of a swerve drive (vx, vy), which moves sideways; generate it for a '
                              'differential drive'])
    return samples


def _state(state: Mapping[str, Any]) -> dict[str, Any]:
    """Return a state of WPILib or of Choreo by meaning."""
    named: dict[str, Any] = {}
    pose = state.get('pose')
    if isinstance(pose, Mapping):
        place, turn = pose.get('translation'), pose.get('rotation')
        named |= place if isinstance(place, Mapping) else {}
        named |= {'heading': turn['radians']} if isinstance(turn, Mapping) and 'radians' in turn else {}
    named |= {name: state[name] for name in ('x', 'y', 'heading') if name in state}
    named |= {'time': state.get('time', state.get('t', ''))}
    named |= {'speed': state['velocity']} if 'velocity' in state else {}
    sides = [state.get(name) for name in ('vl', 'vr')]
    if all(isinstance(side, int | float) for side in sides):
        named['speed'] = 0.5 * (sides[0] + sides[1])  # type: ignore[operator]
    return {name: named[name] for name in ('time', 'x', 'y', 'heading', 'speed') if name in named}


def checked_trajectory(rows: Sequence[Row], source: str) -> TimedPoints:
    """
    Convert rows to points with times.

    Raises
    ------
    ParameterError
        With the place of the first fault.

    """
    if len(rows) > MOST:
        raise ParameterError([f'{source}: has {len(rows)} points, and more than {MOST} are too many; leave some out'])
    times: list[Decimal] = []
    points: list[tuple[float, float]] = []
    places: list[str] = []
    more: dict[str, list[float]] = {'heading': [], 'speed': []}
    for place, row in rows:
        numbers = _numbers(place, row)
        time, point = Decimal(str(row['time']).strip()), (numbers['x'], numbers['y'])
        if times and time <= times[-1]:
            if time == times[-1] and point == points[-1]:
                continue
            raise ParameterError([f'{place}: t = {time} s does not follow {times[-1]} s; leave it out, or give one run '
                                  'alone'])
        times.append(time)
        points.append(point)
        places.append(place)
        for name in more.keys() & numbers.keys():
            more[name].append(numbers[name])
    if len(points) < _LEAST:
        raise ParameterError([f'{source}: has {len(points)} points with times; a trajectory needs {_LEAST} or more'])
    length = math.fsum(math.sqrt((x - ahead) * (x - ahead) + (y - left) * (y - left))
                       for (x, y), (ahead, left) in pairwise(points))
    if length > LONGEST:
        raise ParameterError([f'{source}: is {length:.0f} m long, and more than {LONGEST:g} m are too long; are its '
                              'coordinates metres?'])
    for name, values in more.items():
        if values and len(values) < len(points):
            raise ParameterError([f'{source}: {len(points) - len(values)} points lack the {name} that others have; '
                                  'write it everywhere, or leave it out'])
    return TimedPoints(tuple(float(time - times[0]) for time in times), tuple(points), tuple(places),
                       tuple(more['heading']), tuple(map(_sign, more['speed'])))


def _sign(speed: float) -> int:
    return 0 if abs(speed) < _STANDING else 1 if speed > 0.0 else -1


def _numbers(place: str, row: Mapping[str, Any]) -> dict[str, float]:
    """Return the numbers of a row; raise ParameterError for a fault."""
    if WRONG in row:
        wrong = str(row[WRONG])
        raise ParameterError([f"{place}: '{shortened(wrong, 60)}' has {wrong.count(',') + 1} fields; {_REMEDY}"])
    if UNKNOWN in row:
        raise ParameterError([f'{place}: the key {row[UNKNOWN]}'])
    missing = [name for name in ('x', 'y', 'time') if row.get(name, '') == '']
    if missing:
        raise ParameterError([f"{place}: has no {' and no '.join(missing)}; {_REMEDY}, or drive it as curve = 'path'"])
    numbers: dict[str, float] = {}
    direction = str(row.get('direction', '')).strip().lower()
    if direction:
        if direction not in DIRECTIONS:
            raise ParameterError([f'{place}: direction = {shortened(direction, 20)}; write 1 or -1'])
        numbers['speed'] = float(DIRECTIONS[direction])
    for name in ('time', 'x', 'y', 'heading', 'speed'):
        written = row.get(name, '')
        if written == '':
            continue
        try:
            numbers[name] = float(Decimal(str(written).strip()))
        except InvalidOperation:
            raise ParameterError([f'{place}: {name} = {shortened(str(written), 20)} is no number; mend it']) from None
        if not math.isfinite(numbers[name]) or abs(numbers[name]) > LARGEST:
            raise ParameterError([f'{place}: {name} = {shortened(str(written), 20)} is not finite, or beyond '
                                  f'{LARGEST:g}; mend it'])
    return numbers


def table_of_trajectory(timed: TimedPoints) -> str:
    """Return points with times as a table, with the same numbers to the last bit."""
    signs = timed.signs
    rows = [','.join(['t', 'x', 'y', *(['heading'] if timed.headings else []), *(['v'] if signs else [])])]
    for number, (time, (x, y)) in enumerate(zip(timed.times, timed.points, strict=True)):
        rows.append(','.join(map(repr, [time, x, y, *timed.headings[number:number + 1], *signs[number:number + 1]])))
    return '\n'.join([*rows, ''])
