"""The stretches of a path, forwards or backwards, between the points where it turns back or on the spot."""

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import pairwise
from typing import Any, NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import atan2, dist
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.path_fit import MissedError, TurnsBackError, fitted, is_dense, turning_points
from mobile_robot_control.reference.path_parameters import REFUSE, REVERSE, PathRequest
from mobile_robot_control.reference.path_shape import Point, Span, control_points, spans_of
from mobile_robot_control.reference.polyline import Follower
from mobile_robot_control.reference.waypoints import SAME, Waypoints

PARTS, _FINE = 4, 32
"""Segments of a polyline for each span of a path, and where the place of a rest is sought."""
_ALONG = math.radians(45.0)
"""Largest difference of a heading from the path's, or from its opposite."""


class Stretch(NamedTuple):
    """
    A stretch of a path, from rest to rest.

    Attributes
    ----------
    request : PathRequest
        With the waypoints of the stretch alone.
    spans : list of Span
        Its shape.
    numbers : list of int
        The waypoint whose speed limit holds in each span.
    control : list of ((float, float), int)
        Control points of the spans, each with the number of that waypoint.
    backward : bool
        Whether the robot drives backwards.
    turn : float
        Turn on the spot before it, as the headings say [rad]; 0 if they do not.

    """

    request: PathRequest
    spans: list[Span]
    numbers: list[int]
    control: list[tuple[Point, int]]
    backward: bool = False
    turn: float = 0.0

    @property
    def headings(self) -> tuple[float, float]:
        """Heading of the robot at the start and at the end [rad]."""
        round_ = math.pi if self.backward else 0.0
        start, end = self.spans[0].at(0.0), self.spans[-1].at(1.0)
        return (wrap_angle(atan2(start.dy, start.dx) + round_),
                wrap_angle(atan2(end.dy, end.dx) + round_))


class Route(NamedTuple):
    """
    All stretches of a path.

    Attributes
    ----------
    stretches : list of Stretch
        In their order.
    heading : float or None
        To which the robot turns at the end [rad]; None for no turn.
    ignored : tuple of str
        Headings that are not used, in words.

    """

    stretches: list[Stretch]
    heading: float | None = None
    ignored: tuple[str, ...] = ()


def points_of(request: PathRequest) -> list[Point]:
    """Return the points of a path; a closed one does not end where it begins."""
    points = list(request.waypoints.points)
    return points[:-1] if request.path.closed and dist(points[0], points[-1]) < SAME else points


def is_fitted(request: PathRequest) -> bool:
    """Return whether a path is smoothed within its tolerance."""
    return request.path.tolerance > 0.0 and is_dense(request.waypoints.points)


def route_of(request: PathRequest, facing: float | None = None, *, drives: bool = False) -> Route:
    """
    Divide a path into its stretches.

    Parameters
    ----------
    request : PathRequest
        The path.
    facing : float or None
        Heading of the cart at the start [rad]; None without a cart.
    drives : bool
        Whether it is on its way, by a path that may be the same one, whose directions it keeps.

    Raises
    ------
    ParameterError
        If it turns back or on the spot where `path.turn_back` refuses that, or lacks the heading of `goal_heading`.

    """
    path, goal = request.path, _goal(request) if request.path.goal_heading else None
    if path.turn_back == REFUSE:
        _refuse_turns(request)
        if path.closed and request.waypoints.waits:
            # a lap with a rest begins and ends with one
            request = _opened(request, path.laps)
        return Route([_whole(request)], goal)
    if path.closed:
        if not request.waypoints.waits and not _splits(_opened(request, 1)):
            with suppress(TurnsBackError):
                return Route([_stretch(request)], goal)
        request = _opened(request, path.laps)
    waypoints, ignored = request.waypoints, list[str]()
    between = [0, *_splits(request), len(waypoints.points) - 1]
    divided = [one for ends in pairwise(between) for one in _divided(request, *ends)]
    stretches = [stretch._replace(turn=waypoints.turns[first] if waypoints.turns else 0.0)
                 for first, _, stretch in divided]
    if path.turn_back == REVERSE:
        unused = _equal_headings_unused(waypoints, stretches, facing, drives)
        stretches = [stretch._replace(backward=_is_backward(request, stretch, (first, last), unused, ignored))
                     for (first, last, _), stretch in zip(divided, stretches, strict=True)]
    if goal is None and waypoints.turns and waypoints.turns[-1]:
        arrival = waypoints.headings[-1]
        if arrival is not None and abs(wrap_angle(arrival - stretches[-1].headings[1])) <= _ALONG:
            goal = arrival + waypoints.turns[-1]
        else:
            ignored.append(f'the headings at {waypoints.places[-1]} contradict the path, and are not used')
    return Route(stretches, goal, tuple(ignored))


def _divided(request: PathRequest, first: int, last: int) -> Iterator[tuple[int, int, Stretch]]:
    """Yield the stretches between two waypoints, which turn back nowhere, each with its ends."""
    part = request._replace(waypoints=request.waypoints.part(first, last),
                            path=request.path._replace(closed=False, laps=1))
    try:
        yield first, last, _stretch(part)
    except TurnsBackError as error:
        if not 0 < error.number < last - first:
            raise ParameterError([_turns_back(part.waypoints, error.number, 'leave out what leads back')]) from None
        yield from _divided(request, first, first + error.number)
        yield from _divided(request, first + error.number, last)


def _turns_back(waypoints: Waypoints, number: int, remedy: str) -> str:
    x, y = waypoints.points[number]
    return f'{waypoints.places[number]}: the path turns back at ({x:.3g}, {y:.3g}); {remedy}'


_OR_TURN = 'set path.turn_back to turn or reverse, or leave out what leads back'


def _whole(request: PathRequest) -> Stretch:
    """Return a path that is one stretch; raise ParameterError if it turns back."""
    try:
        return _stretch(request)
    except TurnsBackError as error:
        raise ParameterError([_turns_back(request.waypoints, error.number, _OR_TURN)]) from None


def _refuse_turns(request: PathRequest) -> None:
    """Raise ParameterError if waypoints turn back, or on the spot but at the goal if its heading counts."""
    waypoints, points = request.waypoints, points_of(request)
    if not is_fitted(request):
        around = [points[-1], *points, points[0]] if request.path.closed else points
        for number in turning_points(around, 0.0):
            raise ParameterError([_turns_back(waypoints, number - request.path.closed, _OR_TURN)])
    for number, turn in enumerate(waypoints.turns[:-1] if request.path.goal_heading else waypoints.turns):
        if turn:
            x, y = waypoints.points[number]
            raise ParameterError([f'{waypoints.places[number]}: ({x:g}, {y:g}) turns on the spot; set path.turn_back = '
                                  'turn, or leave it out'])


def _goal(request: PathRequest) -> float:
    """Return the heading of the last waypoint [rad]."""
    waypoints = request.waypoints
    heading = waypoints.headings[-1] if waypoints.headings else None
    if heading is None:
        raise ParameterError([f'{waypoints.places[-1]}: has no heading, and path.goal_heading is true; write it, or '
                              'set that to false'])
    return heading + (waypoints.turns[-1] if waypoints.turns else 0.0)


def _opened(request: PathRequest, laps: int) -> PathRequest:
    """Return the request of a closed path as an open one of some laps, which ends where it begins."""
    waypoints, count = request.waypoints, len(points_of(request))
    order = [*range(count)] * laps + [0]

    def again(values: Any) -> Any:
        return tuple(values[n] for n in order) if values else ()

    return request._replace(path=request.path._replace(closed=False, laps=1), waypoints=waypoints._replace(
        points=again(waypoints.points), speeds=again(waypoints.speeds), places=again(waypoints.places),
        headings=again(waypoints.headings), turns=again(waypoints.turns), directions=again(waypoints.directions),
        waits=again(waypoints.waits)))


def _splits(request: PathRequest) -> list[int]:
    """Return the numbers of the waypoints between two stretches."""
    waypoints = request.waypoints
    splits = {*turning_points(waypoints.points, request.path.tolerance)}
    splits |= {number for number, turn in enumerate(waypoints.turns) if turn}
    if request.path.turn_back == REVERSE:
        splits |= {n for n, (before, after) in enumerate(pairwise(waypoints.directions), start=1) if before != after}
    return sorted(splits - {0, len(waypoints.points) - 1})


def _stretch(request: PathRequest) -> Stretch:
    """Return the whole path of a request as a stretch forwards."""
    control, path = _control_of(request), request.path
    spans = spans_of([point for point, _ in control], path.closed)
    # the span after each control point, and so the number of the waypoint before it
    numbers = [number for _, number in control][:len(spans)]
    return Stretch(request, path.laps * spans, path.laps * numbers, control)


def _control_of(request: PathRequest) -> list[tuple[Point, int]]:
    """
    Return the control points of a path, each with the number of the waypoint whose speed limit holds from it on.

    Dense waypoints are fitted. Raises TurnsBackError if these turn back, ParameterError if the path misses one.
    """
    waypoints, path, points = request.waypoints, request.path, points_of(request)
    if not is_fitted(request):
        return control_points(points, path.closed, path.rounding)
    try:
        control = fitted(points, path.closed, path.tolerance)
    except MissedError as error:
        number = error.number % len(points)
        x, y = points[number]
        raise ParameterError([f'{waypoints.places[number]}: the path would pass ({x:.3g}, {y:.3g}) at a distance of '
                              f'{error.distance:.3g} m, and path.tolerance = {path.tolerance:g} m; raise that, or move '
                              'the waypoints apart']) from None
    ends = [number for _, number in control[1:]] + [len(points) - 1]
    return [(point, min(range(first, end + 1), key=waypoints.speeds.__getitem__))
            for (point, first), end in zip(control, ends, strict=True)]


def pieces(stretch: Stretch) -> list[tuple[list[Span], list[int], float]]:
    """Return spans and numbers of a stretch between its waypoints with a rest, and the rest after each [s]."""
    waypoints = stretch.request.waypoints
    if not any(waypoints.waits):
        return [(stretch.spans, stretch.numbers, 0.0)]
    way = polyline(stretch.spans, _FINE)
    follower, before, divided = Follower(way, 0.0), way[0], []
    begin = 0.0
    for waypoint, (point, wait) in enumerate(zip(waypoints.points, waypoints.waits, strict=True)):
        follower.distance(point, dist(before, point))
        before = point
        start, end = way[follower.place:follower.place + 2]
        dx, dy = end[0] - start[0], end[1] - start[1]
        share = min(max(((point[0] - start[0]) * dx + (point[1] - start[1]) * dy) / max(dx * dx + dy * dy, SAME * SAME),
                        0.0), 1.0)
        at = (follower.place + share) / _FINE
        if not wait or waypoint in (0, len(waypoints.points) - 1):
            continue
        divided.append(_between(stretch, begin, at, wait))
        begin = at
    divided.append(_between(stretch, begin, float(len(stretch.spans)), waypoints.waits[-1]))
    return divided


def _between(stretch: Stretch, start: float, end: float, wait: float) -> tuple[list[Span], list[int], float]:
    """Return the spans of a stretch between two places, their numbers, and the rest after them [s]."""
    # no rest of a span that is too short to have a direction
    first, last = int(start + SAME), math.ceil(end - SAME) - 1
    begin, until = max(0.0, start - first), min(1.0, end - last)
    spans = stretch.spans[first:last + 1]
    # from the end on: what is left of a span that is cut twice
    if until < 1.0:
        spans[-1] = spans[-1].until(until)
    if begin > 0.0:
        spans[0] = spans[0].after(begin / until if first == last else begin)
    return spans, stretch.numbers[first:last + 1], wait


def polyline(spans: Sequence[Span], parts: int = PARTS) -> list[Point]:
    """Return a polyline along spans, so many segments each."""
    points = [span.at(part / parts)[:2] for span in spans for part in range(parts)]
    return points + [span.at(1.0)[:2] for span in spans[-1:]]


def _equal_headings_unused(
    waypoints: Waypoints, stretches: Sequence[Stretch], facing: float | None, drives: bool
) -> str:
    """Return in words why headings that are all equal are not used; '' if they are, or differ."""
    common, *others = {*waypoints.headings} or {None}
    if common is None or others:
        return ''
    ways = [atan2(left - y, ahead - x) for stretch in stretches
            for (x, y), (ahead, left) in pairwise(polyline(stretch.spans)) if (x, y) != (ahead, left)]
    # a cart that already drives forwards against them would turn round halfway
    near = _is_along if drives else _is_on_axis
    aside = ('the path leads' if not all(_is_on_axis(way, common) for way in ways) else
             'the cart heads' if facing is not None and not near(facing, common) else '')
    return aside and (
        f'all headings are {common:.3g} rad, and are not used: {aside} aside of them by more than 45°; where the robot '
        "is to reverse, write its heading at each waypoint, or direction = -1 in a file's column")


def _is_along(direction: float, heading: float) -> bool:
    """Return whether a direction lies near a heading [rad]."""
    return abs(wrap_angle(direction - heading)) <= _ALONG


def _is_on_axis(direction: float, heading: float) -> bool:
    """Return whether a direction lies near a heading or its opposite [rad]."""
    return _is_along(direction, heading) or _is_along(direction + math.pi, heading)


def _is_backward(
    request: PathRequest, stretch: Stretch, ends: tuple[int, int], unused: str, ignored: list[str]
) -> bool:
    """Return whether the robot drives a stretch between two waypoints backwards; add headings that are not used."""
    waypoints, (first, last) = request.waypoints, ends
    if waypoints.directions and waypoints.directions[first]:
        return waypoints.directions[first] < 0
    apart = _apart(request, stretch, ends)
    if not apart or max(apart) <= _ALONG:
        return False
    if not unused and min(apart) >= math.pi - _ALONG:
        return True
    words = unused or (f'the headings from {waypoints.places[first]} to {waypoints.places[last]} contradict the path, '
                       'and are not used')
    ignored += [words] if words not in ignored else []
    return False


def _apart(request: PathRequest, stretch: Stretch, ends: tuple[int, int]) -> list[float]:
    """Return the differences of the headings of a stretch from that of the path [rad]; none if one is unknown."""
    waypoints, (first, last) = request.waypoints, ends
    headings = [heading for heading in waypoints.headings[first:last + 1] if heading is not None]
    if len(headings) <= last - first:
        return []
    if waypoints.turns:
        headings[0] += waypoints.turns[first]
    if request.path.goal_heading and last == len(waypoints.points) - 1:
        del headings[-1]
    way = polyline(stretch.spans)
    follower, before, apart = Follower(way, 0.0), way[0], []
    for heading, point in zip(headings, waypoints.points[first:], strict=False):
        follower.distance(point, dist(before, point))
        (x, y), (ahead, left) = way[follower.place:follower.place + 2]
        apart.append(abs(wrap_angle(heading - atan2(left - y, ahead - x))))
        before = point
    return apart
