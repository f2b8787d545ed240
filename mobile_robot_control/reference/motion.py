"""The motion along a path: its stretches and the turns on the spot between them, one after another."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from functools import lru_cache
from itertools import accumulate, pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import dist
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import NO_ACCELERATION, BodyAcceleration, BodyVelocity, Pose, Reference
from mobile_robot_control.reference.path_parameters import PathRequest
from mobile_robot_control.reference.path_shape import Floats
from mobile_robot_control.reference.planned_path import PlannedPath, Timed, timed
from mobile_robot_control.reference.stretches import Route, pieces, polyline, route_of
from mobile_robot_control.reference.timing import Intervals, Profile, StuckError, fastest

_INTERVALS = 64
"""Of a turn on the spot."""
_NO_TURN = 1e-9
"""[rad]: a smaller turn is none."""
_INSTANT = 1e-9
"""[s]"""
_OTHER_WAY = math.radians(45.0)
"""Largest difference of a turn by headings from one that leads from stretch to stretch."""


class Turn(Timed):
    """
    A turn on the spot.

    Parameters
    ----------
    pose : Pose
        At its start.
    angle : float
        [rad], positive counter-clockwise.
    profile : Profile
        Fastest motion in equal intervals of the angle.
    speed_factor : float
        Speed as a share of it.

    Attributes
    ----------
    angle : float
        As given.

    """

    length, size, closed = 0.0, 1.0, False

    def __init__(self, pose: Pose, angle: float, profile: Profile, speed_factor: float) -> None:
        count = len(profile.acceleration)
        super().__init__(np.full(count, abs(angle) / count), profile, speed_factor)
        self._pose, self.angle = pose, angle

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], with its acceleration."""
        turned, velocity, acceleration = self._at(min(max(time, 0.0), self.period))
        pose = self._pose._replace(heading=wrap_angle(self._pose.heading + turned))
        if not 0.0 <= time < self.period:
            return Reference(pose, BodyVelocity(0.0, 0.0), NO_ACCELERATION)
        return Reference(pose, BodyVelocity(0.0, velocity), BodyAcceleration(0.0, acceleration))

    def left(self, time: float) -> float:
        """Return the angle after a time since the start, without its sign [rad]."""
        return abs(self.angle - self._at(min(max(time, 0.0), self.period))[0])

    def _at(self, time: float) -> tuple[float, float, float]:
        """Return the angle since the start [rad], its rate and the rate of that."""
        n, sign = self.interval(time), math.copysign(1.0, self.angle)
        dt, speed, acceleration = time - float(self.times[n]), float(self.speeds[n]), float(self.accelerations[n])
        turned = self.angle * n / len(self.accelerations) + sign * dt * (speed + 0.5 * acceleration * dt)
        return turned, sign * max(0.0, speed + acceleration * dt), sign * acceleration


class Pause(NamedTuple):
    """A rest at a pose, for a period [s], of a cart that drove backwards before it, or forwards."""

    pose: Pose
    period: float
    backward: bool = False
    length: float = 0.0
    limit: tuple[str, ...] = ('',)

    @property
    def times(self) -> Floats:
        """Of its start and its end [s]."""
        return np.array([0.0, self.period])

    def accelerated(self, _time: float) -> Reference:
        """Return the reference at rest."""
        return Reference(self.pose, BodyVelocity(-0.0 if self.backward else 0.0, 0.0), NO_ACCELERATION)

    def reference(self, time: float) -> Reference:
        """Return the reference at rest."""
        return self.accelerated(time)


class MotionPart(Protocol):
    """A part of a motion: its period [s], the times of its points and the limits between them, and its length [m]."""

    @property
    def period(self) -> float:
        """[s]."""

    @property
    def length(self) -> float:
        """[m]."""

    @property
    def times(self) -> Floats:
        """Of its points [s]."""

    @property
    def limit(self) -> Sequence[str]:
        """The active limit of each interval."""

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], with its acceleration."""


Part = PlannedPath | Turn | Pause


def turn(pose: Pose, angle: float, request: PathRequest, start: float = 0.0) -> Turn:
    """
    Plan the fastest turn on the spot within the limits of a request.

    Parameters
    ----------
    pose : Pose
        At its start.
    angle : float
        [rad], positive counter-clockwise.
    request : PathRequest
        With the limits.
    start : float
        Angular speed at its start [rad/s].

    Raises
    ------
    ParameterError
        If no motion keeps the limits.

    """
    sides = np.full((_INTERVALS, 2), math.copysign(1.0, angle))
    grid = Intervals(np.full(_INTERVALS, abs(angle) / _INTERVALS), sides, np.zeros_like(sides),
                     np.full(_INTERVALS + 1, np.inf), travel=0.0)
    try:
        profile = fastest(grid, request.timing, request.drive, start / request.timing.speed_factor)
    except StuckError as error:
        raise ParameterError([f'no turn on the spot at ({pose.x:.3g}, {pose.y:.3g}) keeps the limits of timing '
                              f'({error}); raise them']) from None
    return Turn(pose, angle, profile, request.timing.speed_factor)


class PathMotion:
    """
    Parts of a motion, one after another, each from rest to rest; the first one may begin in motion.

    Parameters
    ----------
    parts : sequence of MotionPart
        At least one.
    ignored : tuple of str
        What of the waypoints is not used, such as headings, in words.

    Attributes
    ----------
    parts, ignored : tuple
        As given.
    begins : list of float
        Start of each part [s].
    period, length : float
        Of the whole motion [s], [m].
    times : array of float
        Of the points of all parts [s].
    limit : list of str
        The active limit of each interval; '' for none.

    """

    size, closed = 1.0, False

    def __init__(self, parts: Sequence[MotionPart], ignored: tuple[str, ...] = ()) -> None:
        self.parts: tuple[Any, ...] = tuple(parts)
        self.ignored = ignored
        *self.begins, self.period = accumulate((part.period for part in parts), initial=0.0)
        self.length = math.fsum(part.length for part in parts)
        self.limit = [name for part in parts for name in part.limit]
        self.times: Floats = np.concatenate(
            [part.times[:-1] + begin for part, begin in zip(parts, self.begins, strict=True)] + [[self.period]])

    def reference(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], without its acceleration; before and after, at rest."""
        return self.accelerated(time)._replace(acceleration=NO_ACCELERATION)

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], with its acceleration."""
        n = self._number(time)
        reference: Reference = self.parts[n].accelerated(time - self.begins[n])
        if any(reference.velocity) or not 0.0 < time < self.period:
            return reference
        # between two parts: the cart does not stand there, as one that waits does
        following = self._number(time + _INSTANT)
        at_start = following > n or time - self.begins[n] < _INSTANT
        if at_start:
            reference = self.parts[following].accelerated(_INSTANT)
        return reference

    def rest(self, time: float) -> 'Rest':
        """Return the motion after a time since the start [s]."""
        n = self._number(time)
        return Rest(self.parts[n:], time - self.begins[n])

    def left(self, time: float) -> float:
        """Return the way after a time since the start [m]."""
        first, *later = self.rest(time).parts
        ahead = first.remaining(time - self.begins[self._number(time)]) if isinstance(first, PlannedPath) else ()
        return math.fsum(dist(*two) for two in pairwise(polyline(ahead))) + math.fsum(part.length for part in later)

    def _number(self, time: float) -> int:
        return max(0, bisect_right(self.begins, time) - 1)

    def shares(self) -> dict[str, float]:
        """Return the share of the time in which each limit is active, the largest first; '' stands for none."""
        spans = np.diff(self.times)
        shares = {name: float(math.fsum(span for span, active in zip(spans, self.limit, strict=True) if active == name))
                  / self.period for name in set(self.limit)}
        return dict(sorted(shares.items(), key=lambda one: (-one[1], one[0])))


class Rest(NamedTuple):
    """The parts of a motion from a time on, since the start of the first one [s]."""

    parts: tuple[Part, ...]
    time: float


def parts_of(route: Route, first: int = 0, heading: float | None = None) -> list[Part]:
    """
    Time the stretches of a route from one on, and the turns before and after them.

    Parameters
    ----------
    route : Route
        The stretches.
    first : int
        Number of the first one.
    heading : float or None
        Of the robot before it [rad]; None if it stands at its start.

    Raises
    ------
    ParameterError
        If no motion keeps the limits; it names the waypoint.

    """
    parts: list[Part] = []
    for stretch in route.stretches[first:]:
        start, end = stretch.headings
        x, y = stretch.spans[0].at(0.0)[:2]
        before = wrap_angle(start - stretch.turn) if heading is None else heading
        angle = _by_headings(wrap_angle(start - before), stretch.turn)
        if abs(angle) > _NO_TURN:
            parts.append(turn(Pose(x, y, before), angle, stretch.request))
        if not parts and first == 0 and stretch.request.waypoints.waits[:1] > (0.0,):
            parts.append(Pause(Pose(x, y, start), stretch.request.waypoints.waits[0], stretch.backward))
        for spans, numbers, wait in pieces(stretch):
            parts.append(timed(stretch.request, spans, numbers, backward=stretch.backward))
            if wait:
                parts.append(Pause(parts[-1].accelerated(parts[-1].period).pose, wait, stretch.backward))
        heading = end
    if route.heading is not None and heading is not None and abs(wrap_angle(route.heading - heading)) > _NO_TURN:
        last = route.stretches[-1]
        x, y = last.spans[-1].at(1.0)[:2]
        parts.append(turn(Pose(x, y, heading), wrap_angle(route.heading - heading), last.request))
    return parts


def _by_headings(shortest: float, told: float) -> float:
    """Return a turn by the angle that the headings tell, if it leads to the same heading as the shortest one [rad]."""
    apart = told - shortest
    laps = round(apart / (2.0 * math.pi))
    return shortest + 2.0 * math.pi * laps if abs(apart - 2.0 * math.pi * laps) <= _OTHER_WAY and told else shortest


@lru_cache(maxsize=8)
def plan(request: PathRequest) -> PathMotion:
    """
    Plan a path.

    Raises
    ------
    ParameterError
        If the path has a cusp, or no motion along it keeps the limits; it names the waypoint.

    """
    path, waypoints = request.path, request.waypoints
    length = math.fsum(dist(*two) for two in pairwise(waypoints.points))
    if length < path.tolerance:
        raise ParameterError([f'{waypoints.places[0]}: the whole path is {length:.3g} m long, less than path.tolerance '
                              f'= {path.tolerance:g} m; are its coordinates metres?'])
    route = route_of(request)
    planned = PathMotion(parts_of(route), (*waypoints.ignored, *route.ignored))
    if waypoints.duration:
        planned.ignored += (f'{waypoints.places[0]}: the times of the waypoints span {waypoints.duration:.4g} s, and '
                            f'are not used: the path is driven in {planned.period:.4g} s',)
    return planned
