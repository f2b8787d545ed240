"""The sections of a trajectory: where it rests, turns on the spot, turns back, and drives between."""

import math
from bisect import bisect_right
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import atan2
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.smoothing import Floats, Samples, Spline, shares, smooth
from mobile_robot_control.reference.trajectory_parameters import TimedPoints

SHORTEST = 2.0 * math.pi
_GAIN = 0.2
"""[m/s²]: a wave in time whose amplitude is the tolerance accelerates by this."""
_REST = 0.5
"""[s] within the tolerance of one place: a rest ..."""
_NEAR = 0.6
"""Tolerances about its middle in which it begins and ends."""
TURN = 0.03
"""... and so is a shorter time in which the heading changes by this [rad]."""
_ASIDE = 5.0
"""Tolerances from a place to where the directions before and after it are taken."""
_GAP = 0.3
"""[s] between two stops at one place that are one."""
_CORNER = 0.3
"""[rad]: a larger change of the direction at a rest is a turn."""
_GRID = 0.02
"""[s] between places where the speed is looked for a point at which the motion turns back."""
_HALVINGS = 60


class Stop(NamedTuple):
    """
    Where the cart stands, for an instant or longer.

    Attributes
    ----------
    begin, end : float
        [s].
    at : (float, float)
        Position [m].
    back : bool
        Whether the motion turns back here.
    turn : float
        Angle of a turn on the spot by the headings [rad]; 0 for none, nan where the source does not tell.

    """

    begin: float
    end: float
    at: tuple[float, float]
    back: bool = False
    turn: float = 0.0

    @property
    def divides(self) -> bool:
        """Whether the path has a corner or a cusp here."""
        return self.back or self.turn != 0.0


def shortest_wave(tolerance: float) -> float:
    """Return the shortest wave in time of a motion with errors of a size [m] that is followed [s]."""
    return SHORTEST * math.sqrt(tolerance / _GAIN)


def smooth_positions(times: Floats, points: Floats, tolerance: float, finer: bool = True) -> Spline:
    """Return the positions of samples as a smooth function of the time, with shorter waves where they ask for them."""
    def misses(spline: Spline) -> Floats:
        return lengths(spline.at(times) - points) / tolerance

    return smooth(Samples(times, points, shares(times)), shortest_wave(tolerance), (), misses, finer)


def lengths(vectors: Floats) -> Floats:
    """Return the lengths of vectors, shape (n, 2)."""
    found: Floats = np.sqrt(vectors[:, 0] * vectors[:, 0] + vectors[:, 1] * vectors[:, 1])
    return found


def stops_of(timed: TimedPoints, positions: Spline, tolerance: float) -> list[Stop]:
    """Return all stops of a trajectory, in their order; the first and the last may lie at its ends."""
    points = np.array(timed.points)
    rests = list(_rests(timed, points, tolerance))
    merged: list[Stop] = []
    for stop in sorted([*_described(timed, points, rests, tolerance), *_cusps(timed, positions, rests, tolerance)]):
        if merged and _is_near(merged[-1], stop, tolerance):
            before = merged[-1]
            longer = max(before, stop, key=lambda either: either.end - either.begin)
            merged[-1] = Stop(before.begin, max(before.end, stop.end), longer.at, before.back != stop.back,
                              before.turn or stop.turn)
        else:
            merged.append(stop)
    return merged


def _is_near(before: Stop, after: Stop, tolerance: float) -> bool:
    """Return whether two stops are one, between which the cart does not get away."""
    dx, dy = after.at[0] - before.at[0], after.at[1] - before.at[1]
    return after.begin - before.end < _GAP and dx * dx + dy * dy < 4.0 * tolerance * tolerance


def _rests(timed: TimedPoints, points: Floats, tolerance: float) -> Iterator[tuple[int, int]]:
    """Yield the numbers of the first and the last point of each rest."""
    times, count, reach = timed.times, len(points), tolerance * (1.0 + 1e-9)
    xs, ys = points[:, 0].tolist(), points[:, 1].tolist()
    first = 0
    while first < count:
        last = first
        while last + 1 < count and (xs[last + 1] - xs[first]) * (xs[last + 1] - xs[first]) + (
                ys[last + 1] - ys[first]) * (ys[last + 1] - ys[first]) <= reach * reach:
            last += 1
        begin, end = _trimmed(xs, ys, first, last, _NEAR * tolerance)
        if last > first and (times[last] - times[first] >= _REST or (
                timed.headings and abs(_turned(timed, first, last)) >= TURN)):
            yield begin, end
            first = last
        first += 1


def _trimmed(xs: list[float], ys: list[float], first: int, last: int, reach: float) -> tuple[int, int]:
    """Return the numbers of the first and the last point of a rest that lie within a reach of the middle one."""
    middle = (first + last) // 2
    near = [n for n in range(first, last + 1)
            if abs(xs[n] - xs[middle]) <= reach and abs(ys[n] - ys[middle]) <= reach]
    return near[0], near[-1]


def _turned(timed: TimedPoints, first: int, last: int) -> float:
    """Return the angle by which the heading turns between two points [rad]."""
    headings = timed.headings[first:last + 1]
    return math.fsum(wrap_angle(after - before) for before, after in pairwise(headings))


def _described(
    timed: TimedPoints, points: Floats, rests: list[tuple[int, int]], tolerance: float
) -> Iterator[Stop]:
    """Yield the stops of rests."""
    for first, last in rests:
        middle = points[(first + last) // 2]
        before, after = (_direction(points, middle, end, step, tolerance) for end, step in ((first, -1), (last, 1)))
        turned = _turned(timed, first, last) if timed.headings else 0.0
        turn, back = turned if abs(turned) >= TURN else 0.0, False
        if before is not None and after is not None and not turn:
            corner = abs(wrap_angle(after - before - math.pi))
            back = corner > 0.5 * math.pi + 0.5
            turn = math.nan if corner > _CORNER and not back and not timed.headings else 0.0
        yield Stop(timed.times[first], timed.times[last], (float(middle[0]), float(middle[1])), back, turn)


def _direction(points: Floats, at: Floats, number: int, step: int, tolerance: float) -> float | None:
    """Return the direction from a place to the points before or after it [rad]; None if there are none."""
    while 0 <= number < len(points):
        dx, dy = (points[number] - at).tolist()
        if dx * dx + dy * dy >= (_ASIDE * tolerance) * (_ASIDE * tolerance):
            return atan2(dy, dx)
        number += step
    return None


def _cusps(timed: TimedPoints, positions: Spline, rests: list[tuple[int, int]], tolerance: float) -> Iterator[Stop]:
    """Yield the instants outside rests at which the motion turns back."""
    count = max(8, math.ceil(positions.end / _GRID))
    grid: Any = np.arange(count + 1.0) * (positions.end / count)
    speeds, places = lengths(positions.slope(grid)), positions.at(grid)
    low = np.flatnonzero((speeds[1:-1] <= speeds[:-2]) & (speeds[1:-1] < speeds[2:])) + 1
    passed = -1
    for number in low.tolist():
        time = float(grid[number])
        if number < passed or any(timed.times[first] <= time <= timed.times[last] for first, last in rests):
            continue
        ends = [_away(places, number, step, _ASIDE * tolerance) for step in (-1, 1)]
        if None in ends:
            continue
        before, after = (int(end) for end in ends if end is not None)
        before_tip, after_tip = places[before] - places[number], places[after] - places[number]
        sizes = lengths(np.array([before_tip, after_tip]))
        if before_tip[0] * after_tip[0] + before_tip[1] * after_tip[1] < 0.5 * float(sizes[0] * sizes[1]):
            continue
        passed = after
        axis = before_tip / sizes[0] + after_tip / sizes[1]
        at = _root(positions, float(grid[before]), float(grid[after]), axis)
        x, y = positions.at(np.array([at]))[0].tolist()
        yield Stop(at, at, (x, y), True)


def _away(places: Floats, number: int, step: int, distance: float) -> int | None:
    """Return the number of the first place at least a distance before or after one; None if there is none."""
    at = number + step
    while 0 <= at < len(places):
        if lengths((places[at] - places[number])[None])[0] >= distance:
            return at
        at += step
    return None


def _root(positions: Spline, low: float, high: float, axis: Floats) -> float:
    """Return the time between two at which the velocity along an axis vanishes."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        vx, vy = positions.slope(np.array([middle]))[0].tolist()
        if vx * axis[0] + vy * axis[1] < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


class Section(NamedTuple):
    """
    A part of a trajectory with one smooth path, between two points where it begins, ends, turns or turns back.

    Attributes
    ----------
    begin, end : float
        [s]
    stops : tuple of Stop
        At its ends, where there are any, and within it, where the cart stands and goes on along the path.
    backward : bool
        Whether the cart drives backwards.

    """

    begin: float
    end: float
    stops: tuple[Stop, ...]
    backward: bool


def sections_of(timed: TimedPoints, stops: list[Stop]) -> list[Section]:
    """
    Return the sections of a trajectory between its stops, in their order.

    Raises
    ------
    ParameterError
        If the motion turns back and its headings turn round, too, in no time.

    """
    end = timed.times[-1]
    if len(stops) == 1 and stops[0].begin <= 0.0 and stops[0].end >= end:
        return []
    divisions = [stop for stop in stops if stop.divides]
    # a rest at an end is outside of all sections
    first = stops[0] if stops and stops[0].begin <= 0.0 else None
    last = stops[-1] if stops and stops[-1].end >= end and stops[-1] is not first else None
    inner = [stop for stop in divisions if stop not in (first, last)]
    bounds = [first, *inner, last]
    sections: list[Section] = []
    for before, after in pairwise(bounds):
        start = before.end if before else 0.0
        finish = after.begin if after else end
        within = tuple(stop for stop in stops if start <= stop.begin and stop.end <= finish
                       and stop not in (before, after))
        around = tuple(stop for stop in (before, *within, after) if stop)
        sign = _sign(timed, start, finish)
        back = before is not None and before.back and bool(sections)
        if sign and back and (sign < 0) == sections[-1].backward:
            raise ParameterError([
                f'{place_at(timed, start)}: the motion turns back, and the headings say that the '
                'robot turns round there in no time; leave it the time to turn, or leave the headings out'])
        # where the source does not tell, it begins forwards, and turns round where it turns back
        backward = sign < 0 if sign else (bool(sections) and sections[-1].backward) != back
        sections.append(Section(start, finish, around, backward))
    return sections


def _sign(timed: TimedPoints, begin: float, end: float) -> int:
    """Return whether the cart drives forwards (1) or backwards (-1) in a section, 0 if the source does not tell."""
    inside = [n for n, time in enumerate(timed.times) if begin <= time <= end]
    if timed.headings:
        along = 0.0
        for number, after in pairwise(inside):
            (x, y), (ahead, left) = timed.points[number], timed.points[after]
            if (x, y) != (ahead, left):
                apart = abs(wrap_angle(atan2(left - y, ahead - x) - timed.headings[number]))
                along += (1.0 if apart < 0.5 * math.pi else -1.0) * math.sqrt(
                    (ahead - x) * (ahead - x) + (left - y) * (left - y))
        return 1 if along > 0.0 else -1 if along < 0.0 else 0
    votes = math.fsum(timed.signs[n] for n in inside) if timed.signs else 0.0
    return 1 if votes > 0.0 else -1 if votes < 0.0 else 0


def place_at(timed: TimedPoints, time: float) -> str:
    """Return the origin of the point at or before a time, and its position, for messages."""
    number = max(0, bisect_right(timed.times, time + 1e-9) - 1)
    x, y = timed.points[number]
    return f'{timed.places[number]}: at t = {time:.4g} s, at ({x:.3g}, {y:.3g})'
