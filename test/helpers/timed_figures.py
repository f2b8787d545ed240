"""References with times: exact ones, and their points in files."""

import math
from typing import NamedTuple

import numpy as np

from mobile_robot_control.quantities import NO_ACCELERATION, BodyVelocity, Pose, Reference
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.reference.path_parameters import Drive, Timing
from mobile_robot_control.reference.trajectory_parameters import TimedPoints, TrajectoryParameters, TrajectoryRequest

_DS = 1e-4
_REACH = np.arange(-1.0, 5.0, _DS)
_CURVATURE = 1.5 * np.sin(1.7 * _REACH) + 0.8 * np.cos(0.9 * _REACH)
_HEADING = np.cumsum(_CURVATURE) * _DS
_X, _Y = np.cumsum(np.cos(_HEADING)) * _DS, np.cumsum(np.sin(_HEADING)) * _DS


def _eased(share):
    """Return a place from 0 to 1, at rest at both ends, and its rate."""
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2), 30.0 * share**2 * (1.0 - share)**2


class Lemniscate:
    """A lap of the lemniscate, from rest if it is eased."""

    def __init__(self, eased=False):
        self.eased, self.period = eased, 20.8 if eased else 16.0

    def reference(self, time):
        """Return the reference at a time."""
        place, rate = _eased(time / self.period) if self.eased else (time / self.period, 1.0)
        pose, velocity, rest = reference_at(CURVES['lemniscate'], place * self.period, Placement(period=self.period))
        return Reference(pose, BodyVelocity(velocity.linear * rate, velocity.angular * rate), rest)


class Moves(NamedTuple):
    """Moves along a curve by lengths, negative backwards, each in its time: with cusps, and rests of length 0."""

    moves: tuple = ((1.5, 5.0), (0.0, 1.0), (1.0, 4.0), (-1.2, 4.5), (1.8, 6.0), (0.0, 0.7), (-0.6, 3.0))

    @property
    def period(self):
        """Of all moves."""
        return math.fsum(seconds for _, seconds in self.moves)

    def reference(self, time):
        """Return the reference at a time."""
        along, rate = 0.0, 0.0
        for length, seconds in self.moves:
            share = min(time / seconds, 1.0)
            place, rate = _eased(share)
            along, rate = along + length * place, rate * length / seconds
            if time <= seconds:
                break
            time -= seconds
        x, y, heading, curvature = (float(np.interp(along, _REACH, values)) for values in (
            _X, _Y, _HEADING, _CURVATURE))
        return Reference(Pose(x, y, heading), BodyVelocity(rate, rate * curvature), NO_ACCELERATION)


class Sampled(NamedTuple):
    """A motion that is known at equal times."""

    step: float
    poses: list
    velocities: list

    @property
    def period(self):
        """Of the whole."""
        return self.step * (len(self.poses) - 1)

    def reference(self, time):
        """Return the pose and velocity at the nearest time."""
        number = round(time / self.step)
        return Reference(self.poses[number], self.velocities[number], NO_ACCELERATION)


def times_of(figure, rate):
    """Return the times of a file, at a rate and at the end."""
    return [n / rate for n in range(math.ceil(figure.period * rate - 1e-6))] + [figure.period]


def points_of(figure, rate, heading=False):
    """Return the points of a figure at a rate, rounded to millimetres."""
    times = times_of(figure, rate)
    poses = [figure.reference(time).pose for time in times]
    return TimedPoints(tuple(times), tuple((round(pose.x, 3), round(pose.y, 3)) for pose in poses),
                       tuple(f't.csv:{n}' for n in range(2, len(times) + 2)),
                       tuple(round(pose.heading, 3) for pose in poses) if heading else ())


def timed(points, timing=None, **parameters):
    """Return the request to plan a trajectory."""
    return TrajectoryRequest(points, TrajectoryParameters(**parameters), timing or Timing(), Drive())


def table(points):
    """Return points as the text of a table."""
    return 't,x,y\n' + ''.join(f'{time:.6f},{x:.3f},{y:.3f}\n' for time, (x, y) in zip(
        points.times, points.points, strict=True))
