"""Waypoints of a path, checked; errors name their origin."""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import hypot
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import LARGEST
from mobile_robot_control.system.texts import shortened

MOST, LONGEST = 100_000, 10_000.0
"""Most waypoints of a path, and its longest way through them [m]."""
LONGEST_WAIT = 3600.0
"""[s] of a rest at a waypoint."""
SAME = 1e-6
"""[m]: nearer waypoints count as equal."""
_TURN = 0.1
"""[rad]: equal waypoints whose headings differ by more ask for a turn on the spot."""
DIRECTIONS = {'1': 1, '+1': 1, 'forward': 1, 'forwards': 1, '-1': -1, 'backward': -1, 'backwards': -1}
"""What a text in a column `direction` means."""
REMEDY = 'write x,y; or x,y,speed with these names above the columns'
WRONG, UNKNOWN = 'wrong', 'unknown'
"""The only key of a row with a wrong number of fields, and of an entry with a key at fault."""
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
    waits : tuple of float
        Rest at each [s]; () if there is none.
    duration : float
        Of the way by the times in the source, which are not used [s]; 0 without times.
    ignored : tuple of str
        What the source also says and is not used, in words.

    """

    points: tuple[tuple[float, float], ...]
    speeds: tuple[float, ...]
    places: tuple[str, ...]
    repeated: int = 0
    frame: str = ''
    headings: tuple[float | None, ...] = ()
    turns: tuple[float, ...] = ()
    directions: tuple[int, ...] = ()
    waits: tuple[float, ...] = ()
    duration: float = 0.0
    ignored: tuple[str, ...] = ()

    def part(self, first: int, last: int) -> 'Waypoints':
        """Return the waypoints from one number to another."""
        kept = slice(first, last + 1)
        return Waypoints(self.points[kept], self.speeds[kept], self.places[kept], waits=self.waits[kept])


NO_WAYPOINTS = Waypoints((), (), ())

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


def checked_waypoints(rows: Sequence[tuple[str, Mapping[str, Any] | Sequence[Any]]], source: str) -> Waypoints:
    """
    Convert rows to waypoints.

    Parameters
    ----------
    rows : sequence of (str, mapping or sequence)
        Origin of each, and its x, y [m], speed [m/s], heading [rad], direction and wait [s] by name, of which the last
        four may be absent; or x, y and speed in this order.
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
    waits: list[float] = []
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
        direction = DIRECTIONS.get(str(fields.get('direction', '')).strip().lower(), 0)
        if points and hypot(x - points[-1][0], y - points[-1][1]) < SAME:
            if before is not None and heading is not None:
                turns[-1] += wrap_angle(heading - before)
            repeated += 1
            if limit != '':
                speeds[-1] = float(limit)
            directions[-1] = direction or directions[-1]
            waits[-1] += float(fields.get('wait') or 0.0)
            continue
        points.append((x, y))
        headings.append(heading)
        turns.append(0.0)
        directions.append(direction or (directions[-1] if directions else 0))
        speeds.append(float(limit) if limit != '' else speeds[-1] if speeds else math.inf)
        places.append(place)
        waits.append(float(fields.get('wait') or 0.0))
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
                     turns=tuple(turns) if any(turns) else (), directions=tuple(directions) if any(directions) else (),
                     waits=tuple(waits) if any(waits) else ())


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
    if WRONG in fields:
        row = str(fields[WRONG])
        return _Violation(f"'{shortened(row, 60)}'", f' has {row.count(",") + 1} fields; {REMEDY}')
    if UNKNOWN in fields:
        return _Violation('', f'the key {fields[UNKNOWN]}')
    told = "'" + ','.join(shortened(str(field), 20) for field in fields.values()) + "'"
    written = {name: fields[name] for name in ('x', 'y', 'speed', 'heading', 'wait')
               if name in fields and (name in ('x', 'y') or fields[name] != '')}
    try:
        numbers = {name: float(value) for name, value in written.items()}
    except (TypeError, ValueError):
        return _Violation(told, f' is no {",".join(written)} in numbers')
    rule = ''
    if not all(map(math.isfinite, numbers.values())):
        rule = ' is not finite; write numbers'
    elif max(abs(numbers['x']), abs(numbers['y'])) > LARGEST:
        rule = f' lies beyond {LARGEST:g} m'
    elif numbers.get('speed', 1.0) < 0.0:
        told, rule = f'speed = {numbers["speed"]:g} m/s', ('; write more than 0, and for backwards a column direction '
                                                           'with -1, which path.turn_back: reverse obeys')
    elif numbers.get('speed', 1.0) == 0.0:
        told, rule = 'speed = 0 m/s', '; write more than 0, or leave it out, and for a rest a column wait [s]'
    elif not 0.0 <= numbers.get('wait', 0.0) <= LONGEST_WAIT:
        told, rule = f'wait = {numbers["wait"]:g} s', f'; write a rest from 0 to {LONGEST_WAIT:g} s'
    elif str(fields.get('direction', '') or '1').strip().lower() not in DIRECTIONS:
        told, rule = f'direction = {shortened(str(fields["direction"]), 20)}', '; write 1 or -1'
    return _Violation(told, rule) if rule else None
