"""What a column of a file of waypoints, or a key, means; its unit; and headings that are degrees."""

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import atan2
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.waypoints import Waypoints
from mobile_robot_control.system.texts import shortened

_MEANINGS = {
    'x': 'x', 'y': 'y', **dict.fromkeys(('speed', 'velocity', 'vx'), 'speed'),
    **dict.fromkeys(('heading', 'yaw', 'theta', 'psi'), 'heading'), 'direction': 'direction',
    **dict.fromkeys(('t', 'time', 'stamp'), 'time'), 'wait': 'wait',
    # of racing lines and recordings: they follow from the positions
    **dict.fromkeys(('s', 's_m', 'kappa', 'kappa_radpm', 'ax', 'ax_mps2'), ''),
}
"""What a column or a key means; '' for nothing that is needed."""
_TIMED_MEANINGS = {name: meaning for name, meaning in _MEANINGS.items() if name != 'wait'} | {
    'v': 'speed', 'linear_velocity': 'speed', **dict.fromkeys((
    'omega', 'w', 'angular_velocity', 'a', 'acceleration', 'linear_acceleration', 'alpha', 'angular_acceleration',
    'curvature'), '')}
"""What it means in a trajectory, whose velocities and accelerations follow from positions and times."""
_SIDEWAYS = ('vy', 'velocity_y', 'ay')
_WIDTH = re.compile(r'(w(_tr)?_(right|left)|width(_(right|left))?)(_m)?')
_UNITS = {
    **dict.fromkeys(('x', 'y'), ('m', 'metre', 'metres', 'meter', 'meters')),
    'speed': ('m/s', 'mps', 'm/sec', 'm s-1', 'm s^-1', 'ms-1'),
    'heading': ('rad', 'rads', 'radian', 'radians'),
    **dict.fromkeys(('time', 'wait'), ('s', 'sec', 'secs', 'second', 'seconds')),
}
"""The unit of a meaning that has one, in all its spellings."""
_FOREIGN = ('mm', 'cm', 'dm', 'km', 'ft', 'feet', 'in', 'inch', 'inches', 'yd', 'mi', 'px', 'deg', 'degs', 'degree',
            'degrees', '°', 'km/h', 'kmh', 'kph', 'kmph', 'mph', 'fps', 'ft/s', 'knots', 'mm/s', 'cm/s', 'ms', 'us',
            'µs', 'ns', 'min', 'h')
_TURN = 2.0 * math.pi
_NEAR = math.radians(45.0)
"""Largest difference of a heading from the path."""


class Column(NamedTuple):
    """
    What a name above a column says.

    Attributes
    ----------
    name : str
        Without its unit.
    meaning : str
        x, y, speed, heading, direction, wait, time, or '' for what is not used.
    fault : str
        Why it cannot be used, with the remedy; '' if it can.
    is_told : bool
        Whether its owner should hear that it is not used.

    """

    name: str
    meaning: str
    fault: str = ''
    is_told: bool = False


def column_of(header: str, timed: bool = False) -> Column:
    """Return what a name says, with its unit in brackets or as in `x_m`; in a trajectory, if timed."""
    meanings = _TIMED_MEANINGS if timed else _MEANINGS
    told = f"'{shortened(header, 40)}'"
    begin = min((at for at in map(header.find, '([') if at >= 0), default=len(header))
    name, unit = header[:begin].strip().lower(), header[begin:].strip(' ()[]').lower()
    base, _, suffix = name.rpartition('_')
    if not unit and base in meanings and name not in meanings and is_unit(suffix):
        name, unit = base, suffix
    if _WIDTH.fullmatch(name):
        return Column(name, '', is_told=True)
    if timed and name in _SIDEWAYS:
        return Column(name, '', f'{told} is of a robot that moves sideways, and one with two wheels does not; leave it '
                                'out, and take v or vx for the velocity along the heading')
    if name not in meanings:
        return Column(name, '', f'{told} is not understood; leave it out, or name it x, y, speed, heading or direction')
    meaning = meanings[name]
    units = _UNITS.get(meaning, ())
    if not units or not unit or unit in units:
        return Column(name, meaning)
    if meaning == 'time' and not timed:
        return Column(name, '', is_told=True)
    return Column(name, meaning, f'{told} has the unit {shortened(unit, 20)}; convert it to {units[0]}, and name it '
                                 f'{name} [{units[0]}]')


def is_unit(text: str) -> bool:
    """Return whether a text is a unit alone."""
    plain = text.strip('()[] ').lower()
    return plain != text.lower() or plain in _FOREIGN or any(plain in units for units in _UNITS.values())


def refuse_degrees(waypoints: Waypoints) -> None:
    """Raise ParameterError if headings beyond 2π are those of the path in degrees, and not in radians."""
    headings = waypoints.headings
    beyond = [n for n, heading in enumerate(headings) if heading is not None and abs(heading) > _TURN]
    if not beyond:
        return
    # the last one may be the heading of a goal
    for last in (len(headings), len(headings) - 1):
        if _fit(waypoints, last, math.pi / 180.0) and not _fit(waypoints, last, 1.0):
            n = beyond[0]
            raise ParameterError([f'{waypoints.places[n]}: heading = {headings[n]:g} exceeds 2π, and the headings are '
                                  'those of the path in degrees; convert them to rad'])


def _fit(waypoints: Waypoints, last: int, unit: float) -> bool:
    """Return whether the first headings, in a unit [rad], are those of the path, or of the path backwards."""
    return all(heading is None or min(_apart(waypoints.points, n, heading * unit)) <= _NEAR + 1e-9
               for n, heading in enumerate(waypoints.headings[:last]))


def _apart(points: Sequence[tuple[float, float]], n: int, heading: float) -> list[float]:
    """Return the differences of a heading from the path before, after and about a point, also backwards [rad]."""
    before, after = max(n - 1, 0), min(n + 1, len(points) - 1)
    ways = [atan2(points[end][1] - points[start][1], points[end][0] - points[start][0])
            for start, end in ((before, n), (n, after), (before, after)) if start != end]
    return [min(apart, math.pi - apart) for apart in (abs(wrap_angle(heading - way)) for way in ways)]
