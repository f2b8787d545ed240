"""
Time-optimal timing: the fastest motion along a path within all limits.

At a point of the path with curvature κ and κ' = dκ/ds, the square x = v² of the speed and the acceleration a along the
path determine every limited quantity: ω = κ v, dω/dt = κ a + κ' x and, by Eq. (13)-(14) of the chapter, the wheel
torques. Each limit is a row c1 a + c2 x + c3 v <= c0. Between two points a is constant and x is linear in the length;
the rows of both ends must hold.

A backward pass computes at each point the largest speed from which the rest of the path is feasible; a forward pass
below it accelerates at the limit. Friction makes rows nonlinear in x, unlike in TOPP-RA (H. Pham and Q.-C. Pham, A New
Approach to Time-Optimal Path Parameterization based on Reachability Analysis, 2018); otherwise this is its method. A
row is quadratic in v at either end, and its largest root is exact.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.model.robot import angular_inertia, half_separation, linear_inertia
from mobile_robot_control.reference.path_parameters import Drive, Timing

Floats = NDArray[np.float64]
_EXACT, _CLOSE = 1e-9, 1e-7
"""Shares of a limit by which the passes exceed it: the second more than the first, which has set its speeds."""
_ROUNDED, _LAST_BITS = 1e-12, 2e-15
"""Bounds of a row's rounding errors: absolute, and relative to its largest term."""
_HALVINGS = 50
_BACK = 0.99
_ACTIVE = 0.99
"""Share of a limit from which it counts as active."""


class Intervals(NamedTuple):
    """
    A path of N intervals.

    Attributes
    ----------
    length : array of float, shape (N,)
        Of each interval [m].
    curvature : array of float, shape (N, 2)
        At the start and the end of each [1/m].
    sharpness : array of float, shape (N, 2)
        dκ/ds there, within the interval [1/m²].
    speed : array of float, shape (N + 1,)
        Speed limit at each point, in addition to those of Timing; inf for none [m/s].
    travel : float
        1 along a path; 0 for a turn on the spot, whose length is its angle [rad] and whose curvature is 1 or -1.

    """

    length: Floats
    curvature: Floats
    sharpness: Floats
    speed: Floats
    travel: float = 1.0


class LimitRow(NamedTuple):
    """A limit c1 a + c2 x + c3 v <= c0 at both ends of each interval: its name, and arrays of shape (N, 2)."""

    name: str
    c1: Floats
    c2: Floats
    c3: Floats
    c0: Floats


class Profile(NamedTuple):
    """
    The fastest motion along a path.

    Attributes
    ----------
    speed : array of float, shape (N + 1,)
        At each point [m/s].
    acceleration : array of float, shape (N,)
        Along the path, in each interval [m/s²].
    limit : list of str
        The active limit of each interval; '' for none.

    """

    speed: Floats
    acceleration: Floats
    limit: list[str]


class StuckError(ValueError):
    """No motion keeps the limits; `interval` is the number of the interval where it ends."""

    def __init__(self, interval: int, reason: str) -> None:
        super().__init__(reason)
        self.interval = interval


def _both_ways(
    name: str, c1: Floats, c2: Floats, c3: Floats, limit: float, friction: Floats | float = 0.0
) -> list[LimitRow]:
    """Return the rows of |c1 a + c2 x + c3 v + friction| <= limit, as shares of the limit."""
    # a wheel that reverses within an interval has both frictions there
    return [LimitRow(name, sign * c1 / limit, sign * c2 / limit, sign * c3 / limit,
                     1.0 - np.max(sign * friction * np.ones_like(c1), axis=1, keepdims=True) / limit * np.ones_like(c1))
            for sign in (1.0, -1.0)]


def _torque_rows(grid: Intervals, timing: Timing, drive: Drive) -> list[LimitRow]:
    """Return the rows of both wheels' torques: Eq. (13)-(14), solved for the torques, with dry friction."""
    robot, rows = drive.robot, []
    r, half, share = robot.wheel_radius, half_separation(robot), timing.torque_fraction
    for side in (1.0, -1.0):
        # the wheel turns by 1/r (1 + side R κ) along the path
        rim = grid.travel + side * half * grid.curvature
        friction = drive.coulomb * np.sign(rim)
        c1 = (grid.travel * linear_inertia(robot) + side * half * angular_inertia(robot) * grid.curvature) / r
        c2 = side * half * angular_inertia(robot) * grid.sharpness / r
        c3 = robot.viscous_friction * rim / r
        if timing.max_wheel_torque:
            rows += _both_ways('wheel torque', c1, c2, c3, share * timing.max_wheel_torque, friction)
        if drive.stall_torque:
            # the torque of a motor falls with its speed, and its braking torque grows
            line = share * drive.stall_torque
            less = line * rim / (r * drive.no_load_speed)
            rows += _both_ways('torque-speed line', c1, c2, c3 + less, line, friction)
    return rows


def _rows(grid: Intervals, timing: Timing, drive: Drive) -> list[LimitRow]:
    """Return all limits that involve the acceleration."""
    ones, none = np.ones_like(grid.curvature), np.zeros_like(grid.curvature)
    rows = []
    if timing.max_linear_acceleration:
        rows += _both_ways('linear acceleration', grid.travel * ones, none, none, timing.max_linear_acceleration)
    if timing.max_angular_acceleration:
        rows += _both_ways('angular acceleration', grid.curvature, grid.sharpness, none,
                           timing.max_angular_acceleration)
    return rows + _torque_rows(grid, timing, drive)


def _speed_limits(grid: Intervals, timing: Timing, drive: Drive) -> dict[str, Floats]:
    """Return the largest speed under each limit without acceleration, at both ends of each interval [m/s]."""
    bend = np.abs(grid.curvature)
    rim = grid.travel + half_separation(drive.robot) * bend
    limits = {'waypoint speed': np.stack([grid.speed[:-1], grid.speed[1:]], axis=1)}
    with np.errstate(divide='ignore', over='ignore'):
        if timing.max_linear_velocity:
            limits['linear velocity'] = timing.max_linear_velocity / np.full_like(bend, grid.travel)
        if timing.max_angular_velocity:
            limits['angular velocity'] = timing.max_angular_velocity / bend
        if timing.max_lateral_acceleration:
            limits['lateral acceleration'] = np.sqrt(timing.max_lateral_acceleration / (grid.travel * bend))
        if timing.max_wheel_velocity:
            limits['wheel velocity'] = timing.max_wheel_velocity * drive.robot.wheel_radius / rim
    return limits


Quadratic = tuple[float, float, float]
"""A limit a y² + b y + c <= 0 of a speed y."""


def _largest(rows: list[Quadratic], top: float) -> tuple[float, int]:
    """Return the largest speed up to `top` within all rows, -1.0 if there is none, and the row that bounds it."""
    y, touched, again = top, -1, True
    while again:
        again = False
        for number, (a, b, c) in enumerate(rows):
            beyond = (a * y + b) * y + c
            # short intervals have large coefficients, which cancel
            if beyond <= _ROUNDED or beyond <= _LAST_BITS * abs(a) * y * y:
                continue
            y = _root_below(a, b, c, y)
            if y < 0.0:
                return -1.0, number
            touched, again = number, True
    return y, touched


def _root_below(a: float, b: float, c: float, y: float) -> float:
    """Return the largest root of a y² + b y + c below a y at which it is positive; -1.0 if there is none."""
    discriminant = b * b - 4.0 * a * c
    if discriminant < 0.0:
        return -1.0
    q = -0.5 * (b + math.copysign(math.sqrt(discriminant), b))
    roots = [root for root in ((q / a) if a else -1.0, (c / q) if q else 0.0) if 0.0 <= root < y]
    return max(roots, default=-1.0)


class _Passes:
    """The passes over the intervals of a grid."""

    def __init__(self, rows: list[LimitRow], length: Floats, tops: Floats) -> None:
        # by interval, the rows of its start (c1 / 2h, c2, c3, c0) and of its end
        per = 0.5 / length
        by_row = [np.stack([row.c1[:, end] * per, row.c2[:, end], row.c3[:, end], row.c0[:, end]], axis=1)
                  for end in (0, 1) for row in rows]
        self._rows: list[list[list[float]]] = np.stack(by_row, axis=1).tolist() if rows else [[]] * len(length)
        self._half = len(rows)
        self.tops: list[float] = tops.tolist()

    def _before(self, n: int, after: float) -> tuple[float, int]:
        """Return the largest speed at the start of an interval for a speed at its end, and the row that bounds it."""
        square, half = after * after, self._half
        rows = [(c2 - e, c3, e * square - c0 - _EXACT) for e, c2, c3, c0 in self._rows[n][:half]]
        rows += [(-e, 0.0, (e + c2) * square + c3 * after - c0 - _EXACT) for e, c2, c3, c0 in self._rows[n][half:]]
        return _largest(rows, self.tops[n])

    def _after(self, n: int, before: float, slack: float) -> float:
        """Return the largest speed at the end of an interval for a speed at its start; -1.0 if there is none."""
        square, half = before * before, self._half
        rows = [(e, 0.0, (c2 - e) * square + c3 * before - c0 - slack) for e, c2, c3, c0 in self._rows[n][:half]]
        rows += [(e + c2, c3, -e * square - c0 - slack) for e, c2, c3, c0 in self._rows[n][half:]]
        return _largest(rows, self.tops[n + 1])[0]

    def _gains_by_less(self, n: int, row: int, after: float) -> bool:
        """Return whether a slower end allows a faster start of an interval, by the row that bounds the start."""
        e, c2, c3, _ = self._rows[n][row]
        return e > 0.0 if row < self._half else 2.0 * (e + c2) * after + c3 > 0.0

    def _controllable(self, n: int) -> float:
        """Return the largest speed at the start of an interval for which its end can be within its top."""
        if self._after(n, self.tops[n], _EXACT) >= 0.0:
            return self.tops[n]
        low, high = 0.0, self.tops[n + 1]
        speed, row = self._before(n, high)
        if speed >= 0.0 and not self._gains_by_less(n, row, high):
            return speed
        # at the best end speed, a row that demands less meets one that demands more
        best = self._before(n, low)[0]
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            speed, row = self._before(n, middle)
            best = max(best, speed)
            if speed < 0.0 or self._gains_by_less(n, row, middle):
                high = middle
            else:
                low = middle
        return best

    def run(self, start: float) -> list[float]:
        """Return the speed at every point, from one at the start to 0 at the end [m/s]."""
        count = len(self._rows)
        self.tops[count] = 0.0
        for n in range(count - 1, -1, -1):
            self.tops[n] = self._controllable(n)
            if self.tops[n] < 0.0:
                raise StuckError(n, 'the torque limit is not above the friction')
        if start > self.tops[0] * (1.0 + _CLOSE) + _CLOSE:
            raise StuckError(0, f'{start:.3g} m/s at its start is too fast, {self.tops[0]:.3g} m/s the most')
        speeds, n = [min(start, self.tops[0])], 0
        while n < count:
            following = self._after(n, speeds[n], _CLOSE)
            if following >= 0.0:
                speeds.append(following)
                n += 1
            elif n == 0:
                raise StuckError(0, 'no acceleration keeps the limits at the start')
            else:
                # nonlinear rows may leave a gap below a controllable speed: arrive slower
                self.tops[n] = _BACK * speeds.pop()
                n -= 1
        return speeds


def _active(
    rows: list[LimitRow], limits: dict[str, Floats], speeds: Floats, acceleration: Floats
) -> list[str]:
    """Return the limit that each interval uses most, '' if none is active."""
    ends = np.stack([speeds[:-1], speeds[1:]], axis=1)
    used = [(name, np.max(ends / limit, axis=1)) for name, limit in limits.items()]
    for row in rows:
        share = row.c1 * acceleration[:, None] + row.c2 * ends * ends + row.c3 * ends + 1.0 - row.c0
        used.append((row.name, np.max(share, axis=1)))
    shares = np.stack([share for _, share in used])
    most = np.argmax(shares, axis=0)
    return [used[n][0] if shares[n, k] >= _ACTIVE else '' for k, n in enumerate(most.tolist())]


def fastest(grid: Intervals, timing: Timing, drive: Drive, start: float = 0.0) -> Profile:
    """
    Return the fastest motion along a path, to rest, within all limits; `speed_factor` is not applied.

    Parameters
    ----------
    grid : Intervals
        The path.
    timing : Timing
        At least a limit of the speed, and one of the acceleration or the torque.
    drive : Drive
        For the torques.
    start : float
        Speed at its start [m/s].

    Raises
    ------
    StuckError
        If no speed keeps the limits.

    """
    limits, rows = _speed_limits(grid, timing, drive), _rows(grid, timing, drive)
    least: Any = np.min(np.stack(list(limits.values())), axis=0)
    tops = np.append(least[:, 0], least[-1, 1])
    tops[1:] = np.minimum(tops[1:], least[:, 1])
    speeds = np.array(_Passes(rows, grid.length, tops).run(start))
    acceleration = (speeds[1:] * speeds[1:] - speeds[:-1] * speeds[:-1]) / (2.0 * grid.length)
    return Profile(speeds, acceleration, _active(rows, limits, speeds, acceleration))
