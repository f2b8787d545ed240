"""Files of waypoints, tables and YAML; nothing is guessed, and errors name the line."""

import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from mobile_robot_control.elementary import atan2
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.waypoint_columns import column_of, is_unit, refuse_degrees
from mobile_robot_control.reference.waypoints import REMEDY, UNKNOWN, WRONG, Waypoints, checked_waypoints
from mobile_robot_control.system.files import FileKind, read_bounded
from mobile_robot_control.system.texts import shortened

WAYPOINTS = FileKind('file of waypoints', 1 << 24)
YAML_SUFFIXES = ('.yaml', '.yml')
"""Suffixes of YAML files; all others are tables."""
_GEOGRAPHIC = ('lat', 'lon', 'latitude', 'longitude')
_TABLE = 'a table of x,y in metres, in the odometry frame, with these names above the columns'
_FORMATS = {
    '<': f'is XML, as GPX and KML are; convert its positions to {_TABLE}',
    '{': f'is JSON, as GeoJSON and the paths of WPILib and PathPlanner are; convert its positions to {_TABLE}',
    '[': f'is JSON; convert its positions to {_TABLE}, or name a list of [x, y] .yaml',
}
"""What a file is that begins with a character, and the remedy."""

Row = tuple[int, Mapping[str, Any]]
"""The line of an entry, and its texts by meaning; {} for what is no entry."""


def read_waypoints(file: str | Path) -> Waypoints:
    """
    Read a file of waypoints: a table with named columns, or a list in YAML.

    Parameters
    ----------
    file : path
        A table has columns between commas, semicolons, tabs or blanks, empty lines, and comments after '#'. Its header
        may stand in a comment; without one there are two columns, x and y. A YAML file, named .yaml or .yml, is a list
        of `[x, y]`, `{x: ..., y: ..., speed: ...}` or poses, or these by names, by itself or under `waypoints`; or a
        `nav_msgs/msg/Path`, as `ros2 topic echo` prints it.

    Returns
    -------
    Waypoints
        Without repeated neighbours. A speed holds from its waypoint until the next waypoint with a speed.

    Raises
    ------
    ParameterError
        With file and line.

    """
    source, content = str(file), read_text(file)
    is_yaml, begin = Path(file).suffix in YAML_SUFFIXES, content.lstrip()[:1]
    if begin in _FORMATS and not (is_yaml and begin != '<'):
        raise ParameterError([f'{source}: {_FORMATS[begin]}'])
    rows, frame, ignored = rows_of(content, source, is_yaml)
    waypoints = checked_waypoints([(f'{source}:{line}', row) for line, row in rows], source)
    refuse_degrees(waypoints)
    return waypoints._replace(frame=frame, duration=_duration(rows), ignored=tuple(
        f'{source}: the column {shortened(name, 40)} is not used' for name in ignored))


def read_text(file: str | Path) -> str:
    """Return the text of a file of waypoints; raise ParameterError if it has none."""
    try:
        return read_bounded(Path(file), WAYPOINTS).decode('utf-8-sig')
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or 'not a text in UTF-8'
        raise ParameterError([f'{file}: cannot be read ({reason}); name a file of waypoints']) from error


def rows_of(content: str, source: str, is_yaml: bool, timed: bool = False) -> tuple[list[Row], str, list[str]]:
    """Return the rows of a text, the frame that it names, and its columns that are not used."""
    ignored: list[str] = []
    if is_yaml:
        return *_yaml_rows(content, source, timed), ignored
    return list(_table_rows(content, source, ignored, timed)), '', ignored


def _duration(rows: Sequence[Row]) -> float:
    """Return the time from the first row to the last [s]; 0 without two times that are numbers."""
    times = [str(row.get('time', '')) for row in (rows[0][1], rows[-1][1])]
    if not all(map(_is_number, times)):
        return 0.0
    passed = float(times[1]) - float(times[0])
    return passed if math.isfinite(passed) else 0.0


def read_waypoints_once(file: str) -> Waypoints:
    """Read a file of waypoints as `read_waypoints` does; read it again only after a change."""
    try:
        status = os.stat(file)
    except (OSError, ValueError):
        return read_waypoints(file)
    return _read_version(file, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=8)
def _read_version(file: str, _changed: int, _size: int) -> Waypoints:
    return read_waypoints(file)


def _fields(line: str) -> list[str]:
    """Return the fields of a line of a table; a unit in brackets belongs to the name before it."""
    parts = re.split(r'[,;]' if re.search('[,;]', line) else r'\t' if '\t' in line.strip() else r'\s+(?![(\[])',
                     line.strip())
    return [part.strip(' \t"\'') for part in parts]


def _table_rows(table: str, source: str, ignored: list[str], timed: bool) -> Iterator[Row]:
    """Yield line number and texts of each row of a table; add the columns that are not used."""
    meanings: list[str] = []
    names: list[str] = []
    headed = begun = False
    for number, line in enumerate(table.splitlines(), start=1):
        content, _, comment = line.partition('#')
        fields, place = _fields(content), f'{source}:{number}'
        header = _fields(comment) if not any(fields) else [] if begun or any(map(_is_number, fields)) else fields
        if not header:
            begun = True
            columns = meanings or ['x', 'y']
            row = {name: field for name, field in zip(columns, fields, strict=False) if name}
            yield number, row if {'x', 'y'} <= {*row} and not any(fields[len(columns):]) else {WRONG: ','.join(fields)}
        elif begun:
            continue
        elif len(header) == len(names) and all(map(is_unit, header)):
            # a line of units below the names
            _understood([f'{name} [{unit.strip("()[]")}]' for name, unit in zip(names, header, strict=True)], place,
                        timed)
        elif any(fields) or (not headed and _names_columns(header, timed)):
            names, headed = header, any(fields)
            meanings, ignored[:] = _understood(header, place, timed)


def _names_columns(fields: Sequence[str], timed: bool) -> bool:
    """Return whether a line, perhaps in a comment, names the columns of a path."""
    meanings = [column_of(field, timed) for field in fields]
    return {'x', 'y'} <= {one.meaning for one in meanings} or any(one.name in _GEOGRAPHIC for one in meanings)


def _understood(fields: Sequence[str], place: str, timed: bool) -> tuple[list[str], list[str]]:
    """Return the meanings of named columns, '' for one that is not used, and those of which their owner hears that."""
    columns = [column_of(field, timed) for field in fields]
    if any(one.name in _GEOGRAPHIC for one in columns):
        raise ParameterError([f'{place}: {",".join(one.name for one in columns)} are geographic coordinates; convert '
                              'them to x,y in metres, in the odometry frame'])
    faults = [one.fault for one in columns if one.fault]
    if faults:
        raise ParameterError([f'{place}: the column {faults[0]}'])
    meanings = [one.meaning for one in columns]
    for meaning in ('x', 'y'):
        count = meanings.count(meaning)
        if count != 1:
            told = f'{count} columns are' if count else 'no column is'
            raise ParameterError([f'{place}: {told} named {meaning}; {REMEDY}'])
    return meanings, [field for field, one in zip(fields, columns, strict=True) if one.is_told]


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True


def _yaml_rows(content: str, source: str, timed: bool) -> tuple[list[Row], str]:
    """Return line number and texts of each entry of a YAML text, and the frame that it names."""
    try:
        trees = [tree for tree in yaml.compose_all(content, yaml.SafeLoader) if not _is_empty(tree)]
    except (yaml.YAMLError, RecursionError) as error:
        mark = getattr(error, 'problem_mark', None)
        at = f':{mark.line + 1}' if mark else ''
        raise ParameterError([f'{source}{at}: is no YAML ({getattr(error, "problem", None) or "nested too deep"}); '
                              'write a list of [x, y]']) from None
    if len(trees) > 1:
        raise ParameterError([f'{source}:{trees[1].start_mark.line + 1}: holds {len(trees)} paths; keep one of them'])
    tree: Any = trees[0] if trees else None
    parts = _parts(tree)
    frame = getattr(_parts(parts.get('header', tree)).get('frame_id'), 'value', '')
    tree = parts.get('waypoints', parts.get('poses', tree))
    named = _parts(tree)
    if named and all(isinstance(part, yaml.MappingNode | yaml.SequenceNode) for part in named.values()) and not any(
            column_of(name, timed).meaning for name in named):
        entries = list(named.values())
    elif isinstance(tree, yaml.SequenceNode):
        entries = tree.value
    else:
        raise ParameterError([f"{source}: holds no list of waypoints; write '- [x, y]' lines, or these under "
                              "'waypoints:'"])
    return [(entry.start_mark.line + 1, _entry(entry, timed)) for entry in entries], frame


def _is_empty(tree: object) -> bool:
    return tree is None or (isinstance(tree, yaml.ScalarNode) and tree.value in ('', 'null', '~'))


def _parts(node: object) -> dict[str, Any]:
    """Return the parts of a mapping by their names."""
    return {str(getattr(key, 'value', '')): value for key, value in getattr(node, 'value', ())} if isinstance(
        node, yaml.MappingNode) else {}


def _entry(node: object, timed: bool) -> dict[str, Any]:
    """Return the texts of an entry by meaning; {} for what is none."""
    if isinstance(node, yaml.SequenceNode):
        fields = [getattr(field, 'value', '') for field in node.value]
        return dict(zip(('x', 'y'), fields, strict=True)) if len(fields) == 2 else {WRONG: ','.join(map(str, fields))}
    parts = _parts(node)
    if 'pose' in parts:
        header = parts.get('header') if timed else None
        return _entry(parts['pose'], timed) | _stamped(header)
    fields_by_meaning: dict[str, Any] = {}
    if 'position' in parts:
        position = parts.pop('position')
        axes = ([*_parts(position).items()] if isinstance(position, yaml.MappingNode) else
                [*zip('xyz', getattr(position, 'value', ()), strict=False)])
        fields_by_meaning |= {name: getattr(value, 'value', '') for name, value in axes if name in ('x', 'y')}
        turn = [getattr(_parts(parts.pop('orientation', None)).get(name), 'value', '') for name in 'xyzw']
        if all(map(_is_number, turn)):
            x, y, z, w = map(float, turn)
            fields_by_meaning['heading'] = atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        parts.pop('header', None)
    for name, value in parts.items():
        column = column_of(name, timed)
        if column.fault:
            return {UNKNOWN: column.fault}
        fields_by_meaning[column.meaning] = getattr(value, 'value', '')
    return fields_by_meaning if {'x', 'y'} <= {*fields_by_meaning} else {}


def _stamped(header: object) -> dict[str, Any]:
    """Return the time of a header as of an entry; {} without one."""
    stamp = _parts(_parts(header).get('stamp'))
    sec, nanosec = (getattr(stamp.get(name), 'value', '') for name in ('sec', 'nanosec'))
    # a sum of floats would lose the last digits of a wall clock
    return {'time': f'{int(sec)}.{int(nanosec):09d}'} if sec.isdecimal() and nanosec.isdecimal() else {}
