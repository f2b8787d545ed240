"""
The limits of `timing` along a motion with times of its own: where it exceeds them, and the rate at which it keeps them.

At a rate r of the time along it, velocities are r v and accelerations r² a. Each limit is a row
|c2 r² + c1 r + c0| <= l at an instant; dry friction is c0.
"""

import math
from typing import NamedTuple

import numpy as np

from mobile_robot_control.model.robot import angular_inertia, half_separation, linear_inertia
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Reference
from mobile_robot_control.reference.motion import PathMotion
from mobile_robot_control.reference.path_parameters import Drive, Timing
from mobile_robot_control.reference.path_shape import Floats

BEYOND = 1.05
"""Share of a limit that counts as kept: a motion at the limit exceeds it by the errors of its points."""
_STEP, _LEAST = 0.01, 64
"""[s] between two instants, and their least number in each part."""


class _Row(NamedTuple):
    """A limit |c2 r² + c1 r + c0| <= 1 at each instant, and its unit."""

    name: str
    limit: float
    c2: Floats
    c1: Floats
    c0: Floats


class Excess(NamedTuple):
    """
    A limit that is exceeded.

    Attributes
    ----------
    name : str
        Of the limit.
    share : float
        By which it is used.
    limit : float
        In SI units.
    time : float
        [s]
    rate : float
        Of the time along the motion at which all limits are kept; 0 if there is none.

    """

    name: str
    share: float
    limit: float
    time: float
    rate: float


def _rows(values: Floats, timing: Timing, drive: Drive) -> list[_Row]:
    """Return the limits at instants of v, ω, and their rates of change, shape (n, 4)."""
    v, omega, a, alpha = values.T
    none = np.zeros_like(v)
    robot, rows = drive.robot, list[_Row]()

    def add(name: str, limit: float, c2: Floats = none, c1: Floats = none, c0: Floats = none) -> None:
        if limit:
            rows.append(_Row(name, limit, c2 / limit, c1 / limit, c0 / limit))

    add('max_linear_velocity', timing.max_linear_velocity, c1=v)
    add('max_angular_velocity', timing.max_angular_velocity, c1=omega)
    add('max_linear_acceleration', timing.max_linear_acceleration, a)
    add('max_angular_acceleration', timing.max_angular_acceleration, alpha)
    add('max_lateral_acceleration', timing.max_lateral_acceleration, v * omega)
    r, half, share = robot.wheel_radius, half_separation(robot), timing.torque_fraction
    for side in (half, -half):
        rim = v + side * omega
        add('max_wheel_velocity', timing.max_wheel_velocity, c1=rim / r)
        # Eq. (13)-(14), solved for the torque of a wheel, with dry friction
        force = (linear_inertia(robot) * a + side * angular_inertia(robot) * alpha) / r
        drag, friction = robot.viscous_friction * rim / r, drive.coulomb * np.sign(rim)
        add('max_wheel_torque', share * timing.max_wheel_torque, force, drag, friction)
        if drive.stall_torque:
            # the torque of a motor falls with its speed, and its braking torque grows
            line = share * drive.stall_torque
            add('stall_torque', line, force, drag + line * rim / (r * drive.no_load_speed), friction)
    return rows


def worst_excess(motion: PathMotion, timing: Timing, drive: Drive) -> Excess | None:
    """Return the limit that a motion exceeds most; None if it keeps all."""
    times = np.concatenate([begin + (np.arange(count) + 0.5) * (part.period / count) for part, begin, count in (
        (part, begin, max(_LEAST, math.ceil(part.period / _STEP)))
        for part, begin in zip(motion.parts, motion.begins, strict=False))])
    references = [motion.accelerated(time) for time in times.tolist()]
    values = np.array([(*one.velocity, *one.acceleration) for one in references])
    rows = _rows(values, timing, drive)
    used = [(float(share.max()), row, int(share.argmax())) for row in rows
            for share in (np.abs(row.c2 + row.c1 + row.c0),)]
    if not used:
        return None
    share, row, number = max(used, key=lambda one: one[0])
    if share <= BEYOND:
        return None
    return Excess(row.name, share, row.limit, float(times[number]), _rate(rows))


def _rate(rows: list[_Row]) -> float:
    """Return the largest rate up to 1 at which all rows hold; 0 if there is none."""
    low, high = (np.concatenate(parts) for parts in zip(*(
        _beyond(sign * row.c2, sign * row.c1, sign * row.c0 - 1.0) for row in rows for sign in (1.0, -1.0)),
        strict=True))
    rate = 1.0
    while rate > 0.0:
        inside = (low < rate) & (rate <= high)
        if not inside.any():
            break
        rate = max(0.0, float(low[inside].min()))
    return rate


def _beyond(a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats]:
    """Return the ends of the rates from 0 to 1 at which a r² + b r + c > 0; equal ones for none."""
    with np.errstate(divide='ignore', invalid='ignore'):
        root = np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0))
        q = -0.5 * (b + np.copysign(root, b))
        roots = np.where(a != 0.0, q / a, np.inf), np.where(q != 0.0, c / q, np.inf)
    first, second = np.minimum(*roots), np.maximum(*roots)
    crosses, none = b * b > 4.0 * a * c, np.zeros_like(a)
    # opening downwards it is positive between its roots, upwards outside of them
    outside_low = np.where(first > 0.0, np.where(c > 0.0, none, first), np.where(second > 0.0, second, np.inf))
    low = np.where(a < 0.0, first, outside_low)
    high = np.where(a < 0.0, second, np.inf)
    always = ~crosses & (c > 0.0)
    low, high = np.where(crosses, low, np.where(always, none, 2.0)), np.where(crosses, high, np.where(
        always, np.inf, 2.0))
    straight = a == 0.0
    low = np.where(straight, np.where(b > 0.0, -c / np.where(b == 0.0, 1.0, b), np.where(c > 0.0, 0.0, 2.0)), low)
    high = np.where(straight, np.inf, high)
    return np.maximum(low, 0.0), high


class Stretched:
    """
    A part of a motion whose time runs at a rate.

    Parameters
    ----------
    part : part of a motion
        To slow down.
    rate : float
        Up to 1.

    """

    size, closed = 1.0, False

    def __init__(self, part: object, rate: float) -> None:
        self._part, self._rate = part, rate
        self.period: float = part.period / rate  # type: ignore[attr-defined]
        self.length: float = part.length  # type: ignore[attr-defined]
        self.limit, self.times = [''], np.array([0.0, self.period])

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time since the start [s], with its acceleration."""
        rate = self._rate
        (pose, (v, omega), (a, alpha)) = self._part.accelerated(time * rate)  # type: ignore[attr-defined]
        return Reference(pose, BodyVelocity(rate * v, rate * omega), BodyAcceleration(rate * rate * a,
                                                                                      rate * rate * alpha))
