"""A path with its timing: the reference at every time of it."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose, Reference
from mobile_robot_control.reference.path_grid import Floats, PathGrid, lay_grid
from mobile_robot_control.reference.path_shape import Span, bend
from mobile_robot_control.reference.timing import Drive, Grid, Profile, Timing, fastest


class Moment(NamedTuple):
    """
    Where a path is at the start of an interval, and how it goes on.

    Attributes
    ----------
    span : int
        Number of the span.
    u : float
        Where in it.
    u1, u2, u3 : float
        The way in the span after a length of the path, ``u + length (u1 + length (u2 + length u3))`` [1/m], [1/m²],
        [1/m³].
    speed, acceleration : float
        Along the path [m/s], [m/s²].

    """

    span: int
    u: float
    u1: float
    u2: float
    u3: float
    speed: float
    acceleration: float


class PlannedPath:
    """
    A path with its timing.

    Parameters
    ----------
    spans : sequence of Span
        Its shape.
    grid : PathGrid
        Of these.
    profile : Profile
        Its motion.
    speed_factor : float
        Speed as a share of that motion's.

    Attributes
    ----------
    times : array of float, shape (N + 1,)
        At which each point is reached [s].
    duration, length : float
        [s], [m].

    """

    def __init__(self, spans: Sequence[Span], grid: PathGrid, profile: Profile, speed_factor: float) -> None:
        self.grid, self.limit = grid, profile.limit
        self.speeds = profile.speed * speed_factor
        self.accelerations = profile.acceleration * speed_factor * speed_factor
        self.times: Floats = np.concatenate(
            [[0.0], np.cumsum(2.0 * grid.length / (self.speeds[1:] + self.speeds[:-1]))])
        self.duration, self.length = float(self.times[-1]), float(grid.length.sum())
        self._spans = list(spans)
        self._times: list[float] = self.times.tolist()
        self._moments = [Moment(*row) for row in zip(
            grid.span.tolist(), grid.u[:, 0].tolist(), *(each.tolist() for each in _way(grid)),
            self.speeds[:-1].tolist(), self.accelerations.tolist(), strict=True)]

    def at(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], with its acceleration; it stands before and after."""
        within = 0.0 <= time < self.duration
        time = min(max(time, 0.0), self.duration)
        n = min(bisect_right(self._times, time) - 1, len(self._moments) - 1)
        span, u, u1, u2, u3, speed, acceleration = self._moments[n]
        dt = time - self._times[n]
        length = dt * (speed + 0.5 * acceleration * dt)
        point = self._spans[span].at(u + length * (u1 + length * (u2 + length * u3)))
        pose = Pose(point.x, point.y, math.atan2(point.dy, point.dx))
        _, curvature, sharpness = bend(point)
        v = max(0.0, speed + acceleration * dt) if within else 0.0
        a = acceleration if within else 0.0
        return Reference(pose, BodyVelocity(v, curvature * v),
                         # dω/dt = κ dv/dt + dκ/ds v²
                         BodyAcceleration(a, curvature * a + sharpness * v * v))


def _way(grid: PathGrid) -> tuple[Floats, Floats, Floats]:
    """Return the cubics of u over the length of the path that have its values and rates at both ends of intervals."""
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
        Of each span; inf where there is none [m/s].
    start : float
        Speed at its start [m/s].

    """
    grid = lay_grid(list(spans))
    speed = np.full(len(grid.length) + 1, np.inf)
    if speed_limits is not None:
        by_interval = np.asarray(speed_limits)[grid.span]
        speed = np.minimum(np.append(by_interval, np.inf), np.append(np.inf, by_interval))
    profile = fastest(Grid(grid.length, grid.curvature, grid.sharpness, speed), timing, drive,
                      start / timing.speed_factor)
    return PlannedPath(spans, grid, profile, timing.speed_factor)
