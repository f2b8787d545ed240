"""The plan of a path: its fastest motion at every point, with the wheels' motion and the active limit."""

from bisect import bisect_right
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.control.compensation import inverse_dynamics
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.quantities import Reference
from mobile_robot_control.reference.motion import PathMotion
from mobile_robot_control.reference.stretches import Stretch, polyline, route_of
from mobile_robot_control.settings.nodes import Configuration, course_of, path_of
from mobile_robot_control.settings.provenance import provenance

Floats = NDArray[np.float64]
_FINE, _BESIDE = 32, 16
"""Segments of a span, and spans before and after a waypoint, to measure how far it is from a path."""


class Plan(NamedTuple):
    """
    The fastest motion along a path, at n of its points.

    Attributes
    ----------
    time : array of float, shape (n,)
        Since the start [s].
    pose : array of float, shape (n, 3)
        x, y [m] and heading [rad].
    velocity, acceleration : array of float, shape (n, 2)
        v and ω [m/s], [rad/s]; their rates of change from there on [m/s²], [rad/s²].
    wheel_velocity, wheel_torque : array of float, shape (n, 2)
        Of the right and the left wheel [rad/s], [N m]; torques by Eq. (13)-(14), with dry friction.
    limit : list of str, n of them
        The active limit from there to the next point; '' for none.
    duration, length : float
        [s], [m].
    waypoints : array of float, shape (m, 2)
        As given, repeated ones left out [m].
    repeated : int
        Number of those.
    deviation : float
        Largest distance of a waypoint from the path [m].
    ignored : tuple of str
        Headings, columns and times of waypoints that are not used, in words.
    limits : dict of str to float
        The parameters `timing`, by name.
    active : dict of str to float
        Share of the duration in which a limit is active, by its name; the largest first.
    provenance : dict of str to object
        The call, versions and parameters that produced it.

    """

    time: Floats
    pose: Floats
    velocity: Floats
    acceleration: Floats
    wheel_velocity: Floats
    wheel_torque: Floats
    limit: list[str]
    duration: float
    length: float
    waypoints: Floats
    repeated: int
    deviation: float
    ignored: tuple[str, ...]
    limits: dict[str, float]
    active: dict[str, float]
    provenance: dict[str, Any]

    def __repr__(self) -> str:
        most = ', '.join(f'{name} {share:.0%}' for name, share in list(self.active.items())[:3] if name)
        return f'<Plan: {self.length:.3g} m in {self.duration:.4g} s; active: {most}>'


def _deviation(stretch: Stretch) -> float:
    """Return the largest distance of a waypoint from a stretch, near the span that it belongs to [m]."""
    path, numbers = stretch.request.path, [number for _, number in stretch.control]
    lap = stretch.spans[:len(stretch.spans) // path.laps]
    way = np.array(polyline(lap, _FINE))
    starts, legs = way[:-1], np.diff(way, axis=0)
    squares = (legs * legs).sum(axis=1)
    largest = 0.0
    for n, point in enumerate(stretch.request.waypoints.points):
        span = bisect_right(numbers, n) - 1
        around = range((span - _BESIDE) * _FINE, (span + _BESIDE) * _FINE)
        near = [at % len(legs) for at in around if path.closed or 0 <= at < len(legs)]
        away, leg = np.array(point) - starts[near], legs[near]
        along = np.clip((away * leg).sum(axis=1) / squares[near], 0.0, 1.0)
        largest = max(largest, float(np.hypot(*(away - along[:, None] * leg).T).min()))
    return largest


def plan_of(configuration: Configuration, command_line: str = '') -> Plan:
    """Plan the path in a configuration with a cart on a path."""
    cart, path = configuration.reference_cart, course_of(configuration.reference_cart)
    assert isinstance(path, PathMotion)  # noqa: S101 (for mypy: it drives a path)
    limit = [*path.limit, '']
    # the last point, at rest, belongs to the motion that ends there
    times = path.times.copy()
    times[-1] = np.nextafter(times[-1], 0.0)
    references = [path.accelerated(time) for time in times.tolist()]
    robot, coulomb = cart.shared.robot, cart.friction.coulomb
    request = path_of(cart)
    assert request  # noqa: S101 (for mypy: it drives a path)
    waypoints = request.waypoints.points

    def torques(reference: Reference) -> list[float]:
        wheels = wheel_velocity(reference.velocity, robot)
        smooth = inverse_dynamics(reference.velocity, reference.acceleration, robot)
        return [torque + coulomb * float(np.sign(turn)) for torque, turn in zip(smooth, wheels, strict=True)]

    return Plan(
        time=path.times, pose=np.array([reference.pose for reference in references]),
        velocity=np.array([reference.velocity for reference in references]),
        acceleration=np.array([reference.acceleration for reference in references]),
        wheel_velocity=np.array([wheel_velocity(reference.velocity, robot) for reference in references]),
        wheel_torque=np.array([torques(reference) for reference in references]), limit=limit, duration=path.period,
        length=path.length, waypoints=np.array(waypoints), repeated=request.waypoints.repeated,
        deviation=max(map(_deviation, route_of(request).stretches)), ignored=path.ignored, limits=flatten(cart.timing),
        active=path.shares(), provenance=provenance(command_line, configuration))
