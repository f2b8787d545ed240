"""A path with its timing: the reference at each time."""

import math
from collections.abc import Sequence
from itertools import accumulate

import numpy as np

from mobile_robot_control.elementary import atan2, dist
from mobile_robot_control.model.kinematics import turned_round
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.quantities import NO_ACCELERATION, BodyAcceleration, BodyVelocity, Pose, Reference
from mobile_robot_control.reference.path_parameters import Drive, PathRequest, Timing
from mobile_robot_control.reference.path_shape import (
    MOST_POINTS,
    Floats,
    PathGrid,
    Span,
    TooSharpError,
    bend,
    lay_grid,
)
from mobile_robot_control.reference.timing import Intervals, Profile, StuckError, fastest

_END = 1e-9
"""A rest of a span below this share counts as none."""


class ImpossibleError(ValueError):
    """No motion along a path keeps the limits; `span` is the number of the span where it ends."""

    def __init__(self, span: int, reason: str) -> None:
        super().__init__(reason)
        self.span = span


class Timed:
    """
    A motion in intervals of constant acceleration, from its start to a rest.

    Parameters
    ----------
    length : array of float, shape (N,)
        Of each interval [m]; of a turn on the spot [rad].
    profile : Profile
        Fastest motion.
    speed_factor : float
        Speed as a share of it.

    Attributes
    ----------
    times, speeds : array of float, shape (N + 1,)
        Time [s] and speed [m/s], [rad/s] at each point.
    accelerations : array of float, shape (N,)
        In each interval [m/s²], [rad/s²].
    limit : list of str
        The active limit of each interval; '' for none.
    period : float
        Of the whole motion [s].

    """

    def __init__(self, length: Floats, profile: Profile, speed_factor: float) -> None:
        self.limit = profile.limit
        self.speeds = profile.speed * speed_factor
        self.accelerations = profile.acceleration * speed_factor * speed_factor
        self.times: Floats = np.array(
            list(accumulate((2.0 * length / (self.speeds[1:] + self.speeds[:-1])).tolist(), initial=0.0)))
        self.period = float(self.times[-1])

    def interval(self, time: float) -> int:
        """Return the interval at a time since the start [s]."""
        return min(int(np.searchsorted(self.times, time, side='right')) - 1, len(self.accelerations) - 1)

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], with its acceleration."""
        raise NotImplementedError

    def reference(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], without its acceleration; before and after, at rest."""
        return self.accelerated(time)._replace(acceleration=NO_ACCELERATION)


class PlannedPath(Timed):
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
    backward : bool
        Whether the robot drives it backwards; its linear velocity is then negative, also as -0.0 at rest.

    Attributes
    ----------
    grid, backward : PathGrid and bool
        As given.
    length : float
        Of the whole path [m].
    size : float
        A length as scale for distances from the path [m].
    closed : bool
        False: the path ends in a stop, wherever that is.

    """

    def __init__(
        self, spans: Sequence[Span], grid: PathGrid, profile: Profile, speed_factor: float, backward: bool = False
    ) -> None:
        super().__init__(grid.length, profile, speed_factor)
        self.grid, self.backward, self.length = grid, backward, math.fsum(grid.length.tolist())
        self.size, self.closed = 1.0, False
        # arrays, which can be sent to other processes without conversion
        self._spans = np.array([(*span.x, *span.y) for span in spans])
        self._rows = np.stack([grid.u[:, 0], *way_of_grid(grid), self.speeds[:-1], self.accelerations], axis=1)

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], with its acceleration."""
        within = 0.0 <= time < self.period
        time = min(max(time, 0.0), self.period)
        n, u, dt, speed, acceleration = self._place(time)
        point = self._span(self.grid.span[n]).at(u)
        pose = Pose(point.x, point.y, atan2(point.dy, point.dx))
        _, curvature, sharpness = bend(point)
        v = max(0.0, speed + acceleration * dt) if within else 0.0
        a = acceleration if within else 0.0
        # dω/dt = κ dv/dt + dκ/ds v²
        forwards = Reference(pose, BodyVelocity(v, curvature * v),
                             BodyAcceleration(a, curvature * a + sharpness * v * v))
        return turned_round(forwards) if self.backward else forwards

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
        n = self.interval(time)
        u, u1, u2, u3, speed, acceleration = self._rows[n].tolist()
        dt = time - float(self.times[n])
        length = dt * (speed + 0.5 * acceleration * dt)
        # the cubic of u over the length
        return n, u + length * (u1 + length * (u2 + length * u3)), dt, speed, acceleration


def way_of_grid(grid: PathGrid) -> tuple[Floats, Floats, Floats]:
    """Return the cubics of u over the path's length with u and its rate at both ends of each interval."""
    h, du = grid.length, grid.u[:, 1] - grid.u[:, 0]
    before, after = grid.rate[:, 0], grid.rate[:, 1]
    mean = du / h
    return before, (3.0 * mean - 2.0 * before - after) / h, (before + after - 2.0 * mean) / (h * h)


def plan_spans(
    spans: Sequence[Span], timing: Timing, drive: Drive, speed_limits: Sequence[float] | None = None,
    start: float = 0.0, backward: bool = False,
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
    backward : bool
        Whether the robot drives it backwards.

    Raises
    ------
    TooSharpError
        If a bend needs too many points.
    ImpossibleError
        If no motion keeps the limits.

    """
    grid = lay_grid(list(spans))
    by_interval = np.full(len(grid.length), np.inf) if speed_limits is None else np.asarray(speed_limits)[grid.span]
    return plan_grid(spans, grid, timing, drive, by_interval, start, backward)


def plan_grid(
    spans: Sequence[Span], grid: PathGrid, timing: Timing, drive: Drive, speed_limits: Floats, start: float = 0.0,
    backward: bool = False,
) -> PlannedPath:
    """Time a path as `plan_spans` does, on a grid of its spans, with speed limits of the intervals [m/s]."""
    speed = np.minimum(np.append(speed_limits, np.inf), np.append(np.inf, speed_limits))
    try:
        profile = fastest(
            Intervals(grid.length, grid.curvature, grid.sharpness, speed), timing, drive, start / timing.speed_factor)
    except StuckError as error:
        raise ImpossibleError(int(grid.span[error.interval]), str(error)) from None
    return PlannedPath(spans, grid, profile, timing.speed_factor, backward)


def timed(
    request: PathRequest, spans: Sequence[Span], numbers: Sequence[int], start: float = 0.0, backward: bool = False
) -> PlannedPath:
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
    backward : bool
        Whether the robot drives it backwards.

    Raises
    ------
    ParameterError
        If the path has a cusp, or no motion along it keeps the limits; it names the waypoint.

    """
    waypoints, path = request.waypoints, request.path
    try:
        return plan_spans(
            spans, request.timing, request.drive, [waypoints.speeds[number] for number in numbers], start, backward)
    except TooSharpError as error:
        bend_at = spans[error.span].at(0.5)
        nearest = min(range(min(numbers), len(waypoints.points)),
                      key=lambda n: dist(waypoints.points[n], bend_at[:2]))
        raise ParameterError([
            f'{waypoints.places[nearest]}: the path turns back near this waypoint, a cusp that more than '
            f'{MOST_POINTS} points would be needed for; move it, raise path.tolerance = {path.tolerance:g} '
            f'm, or leave waypoints out']) from None
    except ImpossibleError as error:
        raise ParameterError([f'{waypoints.places[numbers[error.span]]}: no motion from here keeps the limits of '
                              f'timing ({error}); raise them']) from None
