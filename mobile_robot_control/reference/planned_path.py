"""A path with its timing: the reference at each time."""

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import NO_ACCELERATION, BodyAcceleration, BodyVelocity, Pose, Reference
from mobile_robot_control.reference.path_fit import TurnsBackError, fitted, is_dense
from mobile_robot_control.reference.path_parameters import Drive, PathRequest, Timing
from mobile_robot_control.reference.path_shape import (
    MOST_POINTS,
    Floats,
    PathGrid,
    Point,
    Span,
    TooSharpError,
    bend,
    control_points,
    lay_grid,
    spans_of,
)
from mobile_robot_control.reference.timing import Intervals, Profile, StuckError, fastest
from mobile_robot_control.reference.waypoints import SAME

_END = 1e-9
"""A rest of a span below this share counts as none."""


class ImpossibleError(ValueError):
    """No motion along a path keeps the limits; `span` is the number of the span where it ends."""

    def __init__(self, span: int, reason: str) -> None:
        super().__init__(reason)
        self.span = span


class PlannedPath:
    """
    A path with its timing.

    Parameters
    ----------
    spans : sequence of Span
        Shape of the path.
    grid : PathGrid
        Grid of the spans.
    profile : Profile
        Fastest motion on the grid.
    speed_factor : float
        Speed as a share of the fastest motion.

    Attributes
    ----------
    grid : PathGrid
        As given.
    times, speeds : array of float, shape (N + 1,)
        Time [s] and speed [m/s] at each point.
    accelerations : array of float, shape (N,)
        Along the path, in each interval [m/s²].
    limit : list of str
        The active limit of each interval; '' for none.
    period, length : float
        Of the whole path [s], [m].
    size : float
        A length as scale for distances from the path [m].
    closed : bool
        False: the path ends in a stop, wherever that is.

    """

    def __init__(self, spans: Sequence[Span], grid: PathGrid, profile: Profile, speed_factor: float) -> None:
        self.grid, self.limit = grid, profile.limit
        self.speeds = profile.speed * speed_factor
        self.accelerations = profile.acceleration * speed_factor * speed_factor
        self.times: Floats = np.concatenate(
            [[0.0], np.cumsum(2.0 * grid.length / (self.speeds[1:] + self.speeds[:-1]))])
        self.period, self.length = float(self.times[-1]), float(grid.length.sum())
        self.size, self.closed = 1.0, False
        # arrays, which can be sent to other processes without conversion
        self._spans = np.array([(*span.x, *span.y) for span in spans])
        self._rows = np.stack([grid.u[:, 0], *_way(grid), self.speeds[:-1], self.accelerations], axis=1)

    def shares(self) -> dict[str, float]:
        """Return the share of the time in which each limit is active, the largest first; '' stands for none."""
        spans = np.diff(self.times)
        found = {name: float(sum(span for span, active in zip(spans, self.limit, strict=True) if active == name))
                 / self.period for name in set(self.limit)}
        return dict(sorted(found.items(), key=lambda one: (-one[1], one[0])))

    def reference(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], without its acceleration; before and after, at rest."""
        return self.accelerated(time)._replace(acceleration=NO_ACCELERATION)

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], with its acceleration."""
        within = 0.0 <= time < self.period
        time = min(max(time, 0.0), self.period)
        n, u, dt, speed, acceleration = self._place(time)
        point = self._span(self.grid.span[n]).at(u)
        pose = Pose(point.x, point.y, math.atan2(point.dy, point.dx))
        _, curvature, sharpness = bend(point)
        v = max(0.0, speed + acceleration * dt) if within else 0.0
        a = acceleration if within else 0.0
        return Reference(pose, BodyVelocity(v, curvature * v),
                         # dω/dt = κ dv/dt + dκ/ds v²
                         BodyAcceleration(a, curvature * a + sharpness * v * v))


    def remaining(self, time: float) -> list[Span]:
        """Return the spans after a time since the start [s]; the first one begins at the position then."""
        n, u, *_ = self._place(min(max(time, 0.0), self.period))
        first, *others = range(self.grid.span[n], len(self._spans))
        begun = [self._span(first).after(u)] if 1.0 - u > _END else []
        return begun + [self._span(number) for number in others]

    def _span(self, number: int) -> Span:
        cubics: list[float] = self._spans[number].tolist()
        return Span(tuple(cubics[:4]), tuple(cubics[4:]))

    def _place(self, time: float) -> tuple[int, float, float, float, float]:
        """Return the interval at a time, the place in its span, the time since its start [s], and the motion."""
        n = min(int(np.searchsorted(self.times, time, side='right')) - 1, len(self._rows) - 1)
        u, u1, u2, u3, speed, acceleration = self._rows[n].tolist()
        dt = time - float(self.times[n])
        length = dt * (speed + 0.5 * acceleration * dt)
        # the cubic of u over the length
        return n, u + length * (u1 + length * (u2 + length * u3)), dt, speed, acceleration


def _way(grid: PathGrid) -> tuple[Floats, Floats, Floats]:
    """Return the cubics of u over the path's length with u and its rate at both ends of each interval."""
    h, du = grid.length, grid.u[:, 1] - grid.u[:, 0]
    before, after = grid.rate[:, 0], grid.rate[:, 1]
    mean = du / h
    return before, (3.0 * mean - 2.0 * before - after) / h, (before + after - 2.0 * mean) / (h * h)


def plan_spans(
    spans: Sequence[Span], timing: Timing, drive: Drive, speed_limits: Sequence[float] | None = None,
    start: float = 0.0,
) -> PlannedPath:
    """
    Time a path of spans.

    Parameters
    ----------
    spans : sequence of Span
        Its shape.
    timing : Timing
        Limits.
    drive : Drive
        The robot.
    speed_limits : sequence of float or None
        Of each span; inf for none [m/s].
    start : float
        Speed at its start [m/s].

    Raises
    ------
    TooSharpError
        If a bend needs too many points.
    ImpossibleError
        If no motion keeps the limits.

    """
    grid = lay_grid(list(spans))
    by_interval = np.full(len(grid.length), np.inf) if speed_limits is None else np.asarray(speed_limits)[grid.span]
    return plan_grid(spans, grid, timing, drive, by_interval, start)


def plan_grid(
    spans: Sequence[Span], grid: PathGrid, timing: Timing, drive: Drive, speed_limits: Floats, start: float = 0.0
) -> PlannedPath:
    """Time a path as `plan_spans` does, on a grid of its spans, with speed limits of the intervals [m/s]."""
    speed = np.minimum(np.append(speed_limits, np.inf), np.append(np.inf, speed_limits))
    try:
        profile = fastest(
            Intervals(grid.length, grid.curvature, grid.sharpness, speed), timing, drive, start / timing.speed_factor)
    except StuckError as error:
        raise ImpossibleError(int(grid.span[error.interval]), str(error)) from None
    return PlannedPath(spans, grid, profile, timing.speed_factor)


@lru_cache(maxsize=8)
def plan(request: PathRequest) -> PlannedPath:
    """
    Plan a path.

    Raises
    ------
    ParameterError
        If the path has a cusp, or no motion along it keeps the limits; it names the waypoint.

    """
    path, waypoints = request.path, request.waypoints
    length = sum(math.dist(*two) for two in pairwise(waypoints.points))
    if length < path.tolerance:
        raise ParameterError([f'{waypoints.places[0]}: the whole path is {length:.3g} m long, less than path.tolerance '
                              f'= {path.tolerance:g} m; are its coordinates metres?'])
    control = control_of(request)
    spans = spans_of([point for point, _ in control], path.closed)
    # the span after each control point, and so the number of the waypoint before it
    numbers = [number for _, number in control][:len(spans)]
    return timed(request, path.laps * spans, path.laps * numbers)


def points_of(request: PathRequest) -> list[Point]:
    """Return the points of a path; a closed one does not end where it begins."""
    points = list(request.waypoints.points)
    return points[:-1] if request.path.closed and math.dist(points[0], points[-1]) < SAME else points


def is_fitted(request: PathRequest) -> bool:
    """Return whether a path is smoothed within its tolerance."""
    return request.path.tolerance > 0.0 and is_dense(request.waypoints.points)


def control_of(request: PathRequest) -> list[tuple[Point, int]]:
    """
    Return the control points of a path, each with the number of the waypoint whose speed limit holds from it on.

    Dense waypoints are fitted. Raises ParameterError if these turn back.
    """
    waypoints, path, points = request.waypoints, request.path, points_of(request)
    if not is_fitted(request):
        return control_points(points, path.closed, path.rounding)
    try:
        found = fitted(points, path.closed, path.tolerance)
    except TurnsBackError as error:
        x, y = points[error.number]
        raise ParameterError([f'{waypoints.places[error.number]}: the path turns back at ({x:.3g}, {y:.3g}); leave out '
                              'what leads back']) from None
    ends = [number for _, number in found[1:]] + [len(points) - 1]
    return [(point, min(range(first, end + 1), key=waypoints.speeds.__getitem__))
            for (point, first), end in zip(found, ends, strict=True)]


def timed(request: PathRequest, spans: Sequence[Span], numbers: Sequence[int], start: float = 0.0) -> PlannedPath:
    """
    Time the spans of a request's path.

    Parameters
    ----------
    request : PathRequest
        The path.
    spans : sequence of Span
        Its shape.
    numbers : sequence of int
        The waypoint that each span follows.
    start : float
        Speed at its start [m/s].

    Raises
    ------
    ParameterError
        If the path has a cusp, or no motion along it keeps the limits; it names the waypoint.

    """
    waypoints, path = request.waypoints, request.path
    try:
        return plan_spans(
            spans, request.timing, request.drive, [waypoints.speeds[number] for number in numbers], start)
    except TooSharpError as error:
        bend_at = spans[error.span].at(0.5)
        nearest = min(range(min(numbers), len(waypoints.points)),
                      key=lambda n: math.dist(waypoints.points[n], bend_at[:2]))
        raise ParameterError([
            f'{waypoints.places[nearest]}: the path turns back near this waypoint, a cusp that more than '
            f'{MOST_POINTS} points would be needed for; move it, raise path.tolerance = {path.tolerance:g} '
            f'm, or leave waypoints out']) from None
    except ImpossibleError as error:
        raise ParameterError([f'{waypoints.places[numbers[error.span]]}: no motion from here keeps the limits of '
                              f'timing ({error}); raise them']) from None
