"""Waypoints of a path, from a CSV or YAML file; errors name the line."""

import math
import os
from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import LARGEST
from mobile_robot_control.system.files import FileKind, read_bounded
from mobile_robot_control.system.texts import shortened

WAYPOINTS = FileKind('file of waypoints', 1 << 24)
YAML_SUFFIXES = ('.yaml', '.yml')
"""Suffixes of YAML files; all others are CSV."""
MOST = 50_000
"""Most waypoints of a path."""
_SAME = 1e-6
"""[m]: nearer waypoints count as equal."""
_NO_ENTRY = 'is no [x, y], [x, y, speed] or {x: ..., y: ..., speed: ...}; write one of these'
_AGAIN = 'is the waypoint before it; leave it out'


class Waypoints(NamedTuple):
    """
    The points of a path.

    Attributes
    ----------
    points : tuple of (float, float)
        Positions in the odometry frame, in their order [m].
    speeds : tuple of float
        Upper limit of the speed from each point on; inf for none [m/s].
    places : tuple of str
        Origin of each in its source, for messages.

    """

    points: tuple[tuple[float, float], ...]
    speeds: tuple[float, ...]
    places: tuple[str, ...]


def read_waypoints(file: str | Path) -> Waypoints:
    """
    Read a file of waypoints: CSV with `x,y` or `x,y,speed`, or a list of such in YAML.

    Parameters
    ----------
    file : path
        A CSV file may have a header, empty lines, and comments after '#'. A YAML file, named .yaml or .yml, is a list
        of `[x, y]`, `[x, y, speed]` or `{x: ..., y: ..., speed: ...}`, by itself or under `waypoints`.

    Returns
    -------
    Waypoints
        Without repeated neighbours. A speed holds from its waypoint until the next waypoint with a speed.

    Raises
    ------
    ParameterError
        With file and line.

    """
    source = str(file)
    try:
        text = read_bounded(Path(file), WAYPOINTS).decode('utf-8-sig')
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or 'not a text in UTF-8'
        raise ParameterError([f'{source}: cannot be read ({reason}); name a file of waypoints']) from error
    rows = _yaml_rows(text, source) if Path(file).suffix in YAML_SUFFIXES else _csv_rows(text)
    return checked_waypoints([(f'{source}:{line}', row) for line, row in rows], source)


def read_waypoints_once(file: str) -> Waypoints:
    """Read a file of waypoints as `read_waypoints` does; read it again only after a change."""
    try:
        found = os.stat(file)
    except (OSError, ValueError):
        return read_waypoints(file)
    return _read_version(file, found.st_mtime_ns, found.st_size)


@lru_cache(maxsize=8)
def _read_version(file: str, _changed: int, _size: int) -> Waypoints:
    return read_waypoints(file)


def _csv_rows(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield line number and fields of each row of a CSV text, without its header."""
    begun = False
    for number, line in enumerate(text.splitlines(), start=1):
        fields = [field.strip() for field in line.partition('#')[0].replace(';', ',').split(',')]
        if not any(fields):
            continue
        header = not begun and any(field and not _is_number(field) for field in fields)
        begun = True
        if not header:
            yield number, fields


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _yaml_rows(text: str, source: str) -> list[tuple[int, list[Any]]]:
    """Return line number and fields of each entry of a YAML text."""
    try:
        tree = yaml.compose(text, yaml.SafeLoader)
    except (yaml.YAMLError, RecursionError) as error:
        mark = getattr(error, 'problem_mark', None)
        at = f':{mark.line + 1}' if mark else ''
        raise ParameterError([f'{source}{at}: is no YAML ({getattr(error, "problem", None) or "nested too deep"}); '
                              'write a list of [x, y]']) from None
    if isinstance(tree, yaml.MappingNode):
        tree = next((value for key, value in tree.value if getattr(key, 'value', '') == 'waypoints'), None)
    if not isinstance(tree, yaml.SequenceNode):
        raise ParameterError([f"{source}: holds no list of waypoints; write '- [x, y]' lines, or these under "
                              "'waypoints:'"])
    return [(entry.start_mark.line + 1, _yaml_fields(entry)) for entry in tree.value]


def _yaml_fields(entry: Any) -> list[Any]:
    if isinstance(entry, yaml.SequenceNode):
        return [getattr(field, 'value', '') for field in entry.value]
    if isinstance(entry, yaml.MappingNode):
        by_name = {getattr(key, 'value', ''): getattr(value, 'value', '') for key, value in entry.value}
        if set(by_name) <= {'x', 'y', 'speed'} and {'x', 'y'} <= set(by_name):
            return [by_name[name] for name in ('x', 'y', 'speed') if name in by_name]
    return []


def checked_waypoints(rows: Sequence[tuple[str, Sequence[Any]]], source: str) -> Waypoints:
    """
    Convert rows of two or three fields to waypoints.

    Parameters
    ----------
    rows : sequence of (str, sequence)
        Origin of each, and its fields.
    source : str
        The common source.

    Raises
    ------
    ParameterError
        With the first violation of each kind.

    """
    violations: dict[str, list[str]] = {}
    points: list[tuple[float, float]] = []
    speeds: list[float] = []
    places: list[str] = []
    for place, row in rows:
        if not row:
            violations.setdefault(_NO_ENTRY, []).append(f'{place}: {_NO_ENTRY}')
            continue
        fields = list(row[:2]) + [field for field in row[2:] if field != '']
        wrong = _row_violation(fields)
        if wrong:
            violations.setdefault(wrong.rule, []).append(f'{place}: {wrong.told}{wrong.rule}')
            continue
        x, y, *limit = map(float, fields)
        if points and math.hypot(x - points[-1][0], y - points[-1][1]) < _SAME:
            violations.setdefault(_AGAIN, []).append(f'{place}: ({x:g}, {y:g}) {_AGAIN}')
        points.append((x, y))
        speeds.append(limit[0] if limit else speeds[-1] if speeds else math.inf)
        places.append(place)
    if not violations and len(points) < 2:
        raise ParameterError([f'{source}: has {len(points)} waypoint{"" if len(points) == 1 else "s"}; a path needs '
                              'two or more'])
    if len(points) > MOST:
        raise ParameterError([f'{source}: has {len(points)} waypoints, and more than {MOST} are too many; leave some '
                              'out'])
    if violations:
        raise ParameterError(first + (f' (and {len(others)} more of this kind)' if others else '')
                             for first, *others in list(violations.values())[:10])
    return Waypoints(tuple(points), tuple(speeds), tuple(places))


class _Violation(NamedTuple):
    """The fault of a row: the text at fault, and the rule, alike for all rows that break it."""

    told: str
    rule: str


def _row_violation(fields: Sequence[Any]) -> _Violation | None:
    """Describe the fault in the fields of a waypoint."""
    told = ','.join(shortened(str(field), 20) for field in fields)
    if len(fields) not in (2, 3):
        return _Violation(f"'{shortened(told, 60)}'", f' has {len(fields)} fields; write x,y or x,y,speed')
    try:
        numbers = [float(field) for field in fields]
    except (TypeError, ValueError):
        return _Violation(f"'{told}'", ' is no x,y or x,y,speed in numbers')
    if not all(map(math.isfinite, numbers)):
        return _Violation(f"'{told}'", ' is not finite; write numbers')
    if max(map(abs, numbers[:2])) > LARGEST:
        return _Violation(f"'{told}'", f' lies beyond {LARGEST:g} m')
    if len(numbers) == 3 and numbers[2] <= 0.0:
        return _Violation(f'speed = {numbers[2]:g} m/s', '; write more than 0, or leave it out')
    return None
