"""Waypoints of a path, from a table or a YAML file; nothing is guessed, and errors name the line."""

import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import atan2, hypot
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import LARGEST
from mobile_robot_control.system.files import FileKind, read_bounded
from mobile_robot_control.system.texts import shortened

WAYPOINTS = FileKind('file of waypoints', 1 << 24)
YAML_SUFFIXES = ('.yaml', '.yml')
"""Suffixes of YAML files; all others are tables."""
MOST, LONGEST = 100_000, 10_000.0
"""Most waypoints of a path, and its longest way through them [m]."""
SAME = 1e-6
"""[m]: nearer waypoints count as equal."""
_TURN = 0.1
"""[rad]: equal waypoints whose headings differ by more ask for a turn on the spot."""
_DIRECTIONS = {'1': 1, '+1': 1, 'forward': 1, 'forwards': 1, '-1': -1, 'backward': -1, 'backwards': -1}
"""What a text in a column `direction` means."""
_MEANINGS = {
    **dict.fromkeys(('x', 'x_m'), 'x'), **dict.fromkeys(('y', 'y_m'), 'y'),
    **dict.fromkeys(('speed', 'velocity', 'vx_mps'), 'speed'),
    **dict.fromkeys(('heading', 'yaw', 'theta', 'psi_rad'), 'heading'), 'direction': 'direction',
    # of racing lines and recordings: they follow from the positions, or are not needed
    **dict.fromkeys(('s', 's_m', 'kappa_radpm', 'ax_mps2', 't', 'time', 'stamp'), ''),
}
"""What a column or a key means; '' for nothing that is needed."""
_GEOGRAPHIC = ('lat', 'lon', 'latitude', 'longitude')
_REMEDY = 'write x,y; or x,y,speed with these names above the columns'
_WRONG, _UNKNOWN = 'wrong', 'unknown'
"""The only key of a row with a wrong number of fields, and of an entry with a key that is not understood."""
_NO_ENTRY = 'is no [x, y], {x: ..., y: ..., speed: ...} or {position: {x: ..., y: ...}}; write one of these'


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
    repeated : int
        Number of points that were equal to the one before, and are left out.
    frame : str
        Frame that the source names; '' for none.
    headings : tuple of float or None
        Heading at each on arrival [rad], None for unknown ones; () if none is known.
    turns : tuple of float
        Turn on the spot at each, by the headings of its repetitions [rad]; () if there is none.
    directions : tuple of int
        1 forwards, -1 backwards from each point on, 0 if the source does not say; () if it never does.

    """

    points: tuple[tuple[float, float], ...]
    speeds: tuple[float, ...]
    places: tuple[str, ...]
    repeated: int = 0
    frame: str = ''
    headings: tuple[float | None, ...] = ()
    turns: tuple[float, ...] = ()
    directions: tuple[int, ...] = ()

    def part(self, first: int, last: int) -> 'Waypoints':
        """Return the waypoints from one number to another."""
        kept = slice(first, last + 1)
        return Waypoints(self.points[kept], self.speeds[kept], self.places[kept])


NO_WAYPOINTS = Waypoints((), (), ())

_Row = tuple[int, Mapping[str, Any]]
"""The line of an entry, and its texts by meaning; {} for what is no entry."""


def read_waypoints(file: str | Path) -> Waypoints:
    """
    Read a file of waypoints: a table with named columns, or a list in YAML.

    Parameters
    ----------
    file : path
        A table has columns between commas, semicolons, tabs or blanks, empty lines, and comments after '#'. Its header
        may stand in a comment; without one there are two columns, x and y. A YAML file, named .yaml or .yml, is a list
        of `[x, y]`, `{x: ..., y: ..., speed: ...}` or poses, by itself, under `waypoints` or by names; or a
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
    source = str(file)
    try:
        text = read_bounded(Path(file), WAYPOINTS).decode('utf-8-sig')
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or 'not a text in UTF-8'
        raise ParameterError([f'{source}: cannot be read ({reason}); name a file of waypoints']) from error
    frame = ''
    if Path(file).suffix in YAML_SUFFIXES:
        rows, frame = _yaml_rows(text, source)
    else:
        rows = list(_table_rows(text, source))
    return checked_waypoints([(f'{source}:{line}', row) for line, row in rows], source)._replace(frame=frame)


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


def table_of(waypoints: Waypoints) -> str:
    """Return the points and headings of waypoints as a table, with the same numbers to the last bit."""
    rows, count = ['x,y,heading'], len(waypoints.points)
    for (x, y), heading, turn in zip(waypoints.points, waypoints.headings or [None] * count,
                                     waypoints.turns or [0.0] * count, strict=True):
        # a turn by more than π takes several rows
        parts = math.ceil(abs(turn)) if heading is not None else 0
        rows += [f'{x!r},{y!r},{"" if heading is None else repr(heading + (turn * n / parts if n else 0.0))}'
                 for n in range(parts + 1)]
    return '\n'.join([*rows, ''])


def _fields(line: str) -> list[str]:
    """Return the fields of a line of a table."""
    parts = re.split(r'[,;]' if re.search('[,;]', line) else r'\t' if '\t' in line.strip() else r'\s+', line.strip())
    return [part.strip() for part in parts]


def _names(fields: Sequence[str]) -> list[str]:
    """Return the names of columns, without their units."""
    return [re.sub(r'\s*[(\[].*', '', field).strip().lower() for field in fields]


def _table_rows(text: str, source: str) -> Iterator[_Row]:
    """Yield line number and texts of each row of a table."""
    meanings: list[str] = []
    begun = False
    for number, line in enumerate(text.splitlines(), start=1):
        content, _, comment = line.partition('#')
        fields = _fields(content)
        if not any(fields):
            names = _names(_fields(comment))
            if not begun and ({'x', 'y'} <= {_MEANINGS.get(name) for name in names} or {*names} & {*_GEOGRAPHIC}):
                meanings = _understood(names, f'{source}:{number}')
            continue
        header = not begun and not any(map(_is_number, fields))
        begun = True
        if header:
            meanings = _understood(_names(fields), f'{source}:{number}')
            continue
        columns = meanings or ['x', 'y']
        row = {name: field for name, field in zip(columns, fields, strict=False) if name}
        yield number, row if {'x', 'y'} <= {*row} and not any(fields[len(columns):]) else {_WRONG: ','.join(fields)}


def _understood(names: Sequence[str], place: str) -> list[str]:
    """Return the meanings of named columns."""
    if {*names} & {*_GEOGRAPHIC}:
        raise ParameterError([f'{place}: {",".join(names)} are geographic coordinates; convert them to x,y in metres, '
                              'in the odometry frame'])
    unknown = [name for name in names if name not in _MEANINGS]
    if unknown:
        raise ParameterError([f"{place}: the column '{shortened(unknown[0], 40)}' is not understood; leave it out, or "
                              'name it x, y, speed, heading or direction'])
    meanings = [_MEANINGS[name] for name in names]
    for meaning in ('x', 'y'):
        count = meanings.count(meaning)
        if count != 1:
            told = f'{count} columns are' if count else 'no column is'
            raise ParameterError([f'{place}: {told} named {meaning}; {_REMEDY}'])
    return meanings


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _yaml_rows(text: str, source: str) -> tuple[list[_Row], str]:
    """Return line number and texts of each entry of a YAML text, and the frame that it names."""
    try:
        trees = [tree for tree in yaml.compose_all(text, yaml.SafeLoader) if not _is_empty(tree)]
    except (yaml.YAMLError, RecursionError) as error:
        mark = getattr(error, 'problem_mark', None)
        at = f':{mark.line + 1}' if mark else ''
        raise ParameterError([f'{source}{at}: is no YAML ({getattr(error, "problem", None) or "nested too deep"}); '
                              'write a list of [x, y]']) from None
    if len(trees) > 1:
        raise ParameterError([f'{source}:{trees[1].start_mark.line + 1}: holds {len(trees)} paths; keep one of them'])
    tree: Any = trees[0] if trees else None
    frame = ''
    if isinstance(tree, yaml.MappingNode):
        parts = _parts(tree)
        header = parts.get('header')
        frame = _parts(header)['frame_id'].value if header is not None and 'frame_id' in _parts(header) else ''
        if 'waypoints' in parts or 'poses' in parts:
            tree = parts.get('waypoints', parts.get('poses'))
        elif all(isinstance(part, yaml.MappingNode) for part in parts.values()):
            return [(part.start_mark.line + 1, _entry(part)) for part in parts.values()], frame
    if not isinstance(tree, yaml.SequenceNode):
        raise ParameterError([f"{source}: holds no list of waypoints; write '- [x, y]' lines, or these under "
                              "'waypoints:'"])
    return [(entry.start_mark.line + 1, _entry(entry)) for entry in tree.value], frame


def _is_empty(tree: Any) -> bool:
    return tree is None or (isinstance(tree, yaml.ScalarNode) and tree.value in ('', 'null', '~'))


def _parts(node: Any) -> dict[str, Any]:
    """Return the parts of a mapping by their names."""
    return {getattr(key, 'value', ''): value for key, value in getattr(node, 'value', ())} if isinstance(
        node, yaml.MappingNode) else {}


def _entry(node: Any) -> dict[str, Any]:
    """Return the texts of an entry by meaning; {} for what is none."""
    if isinstance(node, yaml.SequenceNode):
        fields = [getattr(field, 'value', '') for field in node.value]
        return dict(zip(('x', 'y'), fields, strict=True)) if len(fields) == 2 else {_WRONG: ','.join(map(str, fields))}
    parts = _parts(node)
    if 'pose' in parts:
        return _entry(parts['pose'])
    found: dict[str, Any] = {}
    if 'position' in parts:
        position = parts.pop('position')
        axes = ([*_parts(position).items()] if isinstance(position, yaml.MappingNode) else
                [*zip('xyz', getattr(position, 'value', ()), strict=False)])
        found |= {name: getattr(value, 'value', '') for name, value in axes if name in ('x', 'y')}
        turn = [getattr(_parts(parts.pop('orientation', None)).get(name), 'value', '') for name in 'xyzw']
        if all(map(_is_number, turn)):
            x, y, z, w = map(float, turn)
            found['heading'] = atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        parts.pop('header', None)
    for name, value in parts.items():
        if name not in _MEANINGS:
            return {_UNKNOWN: name}
        found[_MEANINGS[name]] = getattr(value, 'value', '')
    return found if {'x', 'y'} <= {*found} else {}


def checked_waypoints(rows: Sequence[tuple[str, Mapping[str, Any] | Sequence[Any]]], source: str) -> Waypoints:
    """
    Convert rows to waypoints.

    Parameters
    ----------
    rows : sequence of (str, mapping or sequence)
        Origin of each, and its x, y [m], speed [m/s], heading [rad] and direction by name, of which the last three may
        be absent; or x, y and speed in this order.
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
    headings: list[float | None] = []
    turns: list[float] = []
    directions: list[int] = []
    heading: float | None = None
    repeated = 0
    for place, row in rows:
        fields = row if isinstance(row, Mapping) else dict(zip(('x', 'y', 'speed'), row, strict=False))
        wrong = _row_violation(fields)
        if wrong:
            violations.setdefault(wrong.rule, []).append(f'{place}: {wrong.told}{wrong.rule}')
            continue
        x, y = float(fields['x']), float(fields['y'])
        limit, before, heading = fields.get('speed', ''), heading, _heading(fields)
        direction = _DIRECTIONS.get(str(fields.get('direction', '')).strip().lower(), 0)
        if points and hypot(x - points[-1][0], y - points[-1][1]) < SAME:
            if before is not None and heading is not None:
                turns[-1] += wrap_angle(heading - before)
            repeated += 1
            if limit != '':
                speeds[-1] = float(limit)
            directions[-1] = direction or directions[-1]
            continue
        points.append((x, y))
        headings.append(heading)
        turns.append(0.0)
        directions.append(direction or (directions[-1] if directions else 0))
        speeds.append(float(limit) if limit != '' else speeds[-1] if speeds else math.inf)
        places.append(place)
    if not violations and len(points) < 2:
        raise ParameterError([f'{source}: has {len(points)} waypoint{"" if len(points) == 1 else "s"}; a path needs '
                              'two or more'])
    if len(points) > MOST:
        raise ParameterError([f'{source}: has {len(points)} waypoints, and more than {MOST} are too many; leave some '
                              'out'])
    length = math.fsum(hypot(x - before_x, y - before_y) for (before_x, before_y), (x, y) in pairwise(points))
    if length > LONGEST:
        raise ParameterError([f'{source}: is {length:.0f} m long, and more than {LONGEST:g} m are too long; drive '
                              'it in parts, or are its coordinates no metres?'])
    if violations:
        raise ParameterError(first + (f' (and {len(others)} more of this kind)' if others else '')
                             for first, *others in list(violations.values())[:10])
    turns = [turn if abs(turn) > _TURN else 0.0 for turn in turns]
    return Waypoints(tuple(points), tuple(speeds), tuple(places), repeated,
                     headings=tuple(headings) if any(one is not None for one in headings) else (),
                     turns=tuple(turns) if any(turns) else (), directions=tuple(directions) if any(directions) else ())


def _heading(fields: Mapping[str, Any]) -> float | None:
    """Return the heading of a row [rad]."""
    heading = fields.get('heading', '')
    return float(heading) if heading != '' else None


class _Violation(NamedTuple):
    """The fault of a row: the text at fault, and the rule, alike for all rows that break it."""

    told: str
    rule: str


def _row_violation(fields: Mapping[str, Any]) -> _Violation | None:
    """Describe the fault in the fields of a waypoint."""
    if not fields:
        return _Violation('', _NO_ENTRY)
    if _WRONG in fields:
        row = str(fields[_WRONG])
        return _Violation(f"'{shortened(row, 60)}'", f' has {row.count(",") + 1} fields; {_REMEDY}')
    if _UNKNOWN in fields:
        return _Violation('', f"has '{shortened(str(fields[_UNKNOWN]), 40)}', which is not understood; leave it out")
    told = "'" + ','.join(shortened(str(field), 20) for field in fields.values()) + "'"
    given = {name: fields[name] for name in ('x', 'y', 'speed', 'heading')
             if name in fields and (name in ('x', 'y') or fields[name] != '')}
    try:
        numbers = {name: float(value) for name, value in given.items()}
    except (TypeError, ValueError):
        return _Violation(told, f' is no {",".join(given)} in numbers')
    rule = ''
    if not all(map(math.isfinite, numbers.values())):
        rule = ' is not finite; write numbers'
    elif max(abs(numbers['x']), abs(numbers['y'])) > LARGEST:
        rule = f' lies beyond {LARGEST:g} m'
    elif numbers.get('speed', 1.0) <= 0.0:
        told, rule = f'speed = {numbers["speed"]:g} m/s', '; write more than 0, or leave it out'
    elif str(fields.get('direction', '') or '1').strip().lower() not in _DIRECTIONS:
        told, rule = f'direction = {shortened(str(fields["direction"]), 20)}', '; write 1 or -1'
    return _Violation(told, rule) if rule else None
