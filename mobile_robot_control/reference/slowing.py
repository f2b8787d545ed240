"""
A stop along a motion without a plan: the time along it slows down until the cart stands.

With a rate r of that time, velocities are r v and accelerations r² a + r' v. Each limit of `timing` is a row
|c + d r'| <= l, since wheel torques are linear in the accelerations (Eq. (13)-(14) of the chapter); together they bound
the fall of the rate. An unchanged rate below 1 keeps every limit that the motion keeps.
"""

import math
from bisect import bisect_right
from collections.abc import Iterator

from mobile_robot_control.model.robot import angular_inertia, half_separation, linear_inertia
from mobile_robot_control.quantities import NO_ACCELERATION, BodyAcceleration, BodyVelocity, Reference
from mobile_robot_control.reference.motion import PathMotion
from mobile_robot_control.reference.path_parameters import PathRequest
from mobile_robot_control.reference.stopping import moves

_DT, _LATER = 0.005, 0.02
"""[s] from one change of the rate's fall to the next: at first, and in a stop that takes long."""
_LONG = 3.0
"""[s] after which it does."""


class Slowed:
    """
    A motion that slows down as fast as the limits allow, until the cart stands.

    Parameters
    ----------
    motion : PathMotion
        The motion so far.
    begin : float
        Time along it at which the stop begins [s].
    request : PathRequest
        With the limits.
    rate : float
        Of the time along the motion then: below 1 for a cart that continues after a wait.

    Attributes
    ----------
    motion : PathMotion
        As given.
    period : float
        Duration of the stop [s].

    """

    size, closed = 1.0, False

    def __init__(self, motion: PathMotion, begin: float, request: PathRequest, rate: float = 1.0) -> None:
        self.motion, self.period = motion, 0.0
        self._times: list[float] = []
        # place along the motion [s], rate and its change [1/s]
        self._rows: list[tuple[float, float, float]] = []
        place = begin
        while place < motion.period and rate > 0.0 and moves(_slowed(motion.accelerated(place), rate, 0.0)):
            dt = _DT if self.period < _LONG else _LATER
            fall = _steepest(motion.accelerated(place), rate, request)
            # both ends of the interval keep every row
            after = max(0.0, rate + fall * dt)
            fall = max(fall, _steepest(motion.accelerated(place + 0.5 * (rate + after) * dt), after, request))
            if fall * dt <= -rate:
                fall = max(fall, -rate / _DT)
                dt = -rate / fall
            self._times.append(self.period)
            self._rows.append((place, rate, fall))
            self.period += dt
            place, rate = place + dt * (rate + 0.5 * fall * dt), rate + fall * dt
        # of a cart that stands already, and of a time that is rounded to before the stop
        self._times, self._rows = self._times or [0.0], self._rows or [(begin, 0.0, 0.0)]
        # a cart that drove backwards stands with -0.0 m/s
        self._end = _slowed(motion.accelerated(place), 0.0, 0.0)

    def place(self, time: float) -> float:
        """Return the time along the motion at a time since the start of the stop, within it [s]."""
        return self._at(time)[0]

    def reference(self, time: float) -> Reference:
        """Return the reference at a time since the start of the stop [s], without its acceleration."""
        return self.accelerated(time)._replace(acceleration=NO_ACCELERATION)

    def accelerated(self, time: float) -> Reference:
        """Return the reference at a time since the start of the stop [s], with its acceleration."""
        if time >= self.period:
            return self._end
        place, rate, fall = self._at(time)
        return _slowed(self.motion.accelerated(place), rate, fall)

    def _at(self, time: float) -> tuple[float, float, float]:
        n = max(0, bisect_right(self._times, time) - 1)
        place, rate, fall = self._rows[n]
        dt = time - self._times[n]
        return place + dt * (rate + 0.5 * fall * dt), rate + fall * dt, fall


def _slowed(reference: Reference, rate: float, fall: float) -> Reference:
    """Return a reference whose time runs at a rate that changes [1/s]."""
    (v, omega), (a, alpha) = reference.velocity, reference.acceleration
    return Reference(reference.pose, BodyVelocity(rate * v, rate * omega),
                     BodyAcceleration(rate * rate * a + fall * v, rate * rate * alpha + fall * omega))


def _steepest(reference: Reference, rate: float, request: PathRequest) -> float:
    """Return the steepest fall of the rate within the limits at a point of the motion, at most 0 [1/s]."""
    bounds = [min((-limit - constant) / per, (limit - constant) / per)
              for constant, per, limit in _rows(reference, rate, request) if per]
    return min(0.0, max(bounds, default=-math.inf))


def _rows(reference: Reference, rate: float, request: PathRequest) -> Iterator[tuple[float, float, float]]:
    """Yield the limits |c + d r'| <= l at a point of the motion as (c, d, l)."""
    timing, drive, robot = request.timing, request.drive, request.drive.robot
    (v, omega), square = reference.velocity, rate * rate
    a, alpha = square * reference.acceleration.linear, square * reference.acceleration.angular
    if timing.max_linear_acceleration:
        yield a, v, timing.max_linear_acceleration
    if timing.max_angular_acceleration:
        yield alpha, omega, timing.max_angular_acceleration
    r, half, share = robot.wheel_radius, half_separation(robot), timing.torque_fraction
    for side in (half, -half):
        rim = v + side * omega
        # Eq. (13)-(14), solved for the torque of a wheel, with dry friction
        torque = ((linear_inertia(robot) * a + side * angular_inertia(robot) * alpha
                   + robot.viscous_friction * rate * rim) / r + math.copysign(drive.coulomb, rim))
        per = (linear_inertia(robot) * v + side * angular_inertia(robot) * omega) / r
        if timing.max_wheel_torque:
            yield torque, per, share * timing.max_wheel_torque
        if drive.stall_torque:
            line = share * drive.stall_torque
            # the braking torque of a motor grows with its speed
            yield torque + line * rate * rim / (r * drive.no_load_speed), per, line
