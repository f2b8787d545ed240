"""
The correction of odometry by a localisation: its use by the cart, and a drawn one for simulated runs.

A correction is the pose of the frame of odometry in the frame of the path, such as `map`.
"""

import math
import random
from collections.abc import Iterator
from typing import Annotated, NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import dist, normal, sin_cos
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import NANOSECONDS, Pose

SAME = Pose(0.0, 0.0, 0.0)
"""The correction of two frames that are one."""
_MEAN = 1.0
"""[s] over which corrections are averaged, and least time from one lead to the next."""
_LEAST = (0.005, 0.01)
"""[m], [rad] by which a correction moves the cart before it leads over."""
_SWINGS = 5
"""Swings in turn that are told."""
_JUMP = (0.03, 0.05)
"""[m], [rad] between a correction and the mean of those before it from which on it stands alone."""


class Localisation(NamedTuple):
    """The localisation of a simulated run, and the longest silence of a real one."""

    timeout: Annotated[
        float, Field('s', 'wall clock: age of the correction from path_frame to odometry from which on the cart waits',
                     above=0.0)
    ] = 2.0
    rate: Annotated[
        float, Field('Hz', 'rate of drawn corrections; 0 takes them from /tf', minimum=0.0, maximum=1e3)
    ] = 0.0
    jump: Annotated[
        float, Field('m', 'distance by which each drawn correction moves the cart, in any direction: larger moves it '
                     'farther', minimum=0.0)
    ] = 0.0
    turn: Annotated[
        float, Field('rad', 'angle by which each drawn correction turns the cart, to either side: larger turns it '
                     'farther', minimum=0.0)
    ] = 0.0
    drift: Annotated[
        float, Field('m/√s', 'standard deviation of the drift of odometry that drawn corrections follow, after 1 s: '
                     'larger drifts faster', minimum=0.0)
    ] = 0.0
    noise: Annotated[
        float, Field('m', 'standard deviation of x and y of a drawn correction: larger scatters more', minimum=0.0)
    ] = 0.0
    seed: Annotated[int, Field('', 'of drawn corrections', minimum=0)] = 0


class CorrectionSchedule(NamedTuple):
    """
    The schedule of corrections that move a course.

    Attributes
    ----------
    localisation : Localisation
        With a rate.
    tick : int
        Between two steps of the cart [ns].
    horizon : int
        Steps ahead with a reference: a correction leads over behind them.

    """

    localisation: Localisation
    tick: int
    horizon: int


def composed(outer: Pose, inner: Pose) -> Pose:
    """Return a pose in the outer frame, given in one that has a pose there."""
    sin, cos = sin_cos(outer.heading)
    return Pose(outer.x + cos * inner.x - sin * inner.y, outer.y + sin * inner.x + cos * inner.y,
                wrap_angle(outer.heading + inner.heading))


def inverse(pose: Pose) -> Pose:
    """Return the pose of the outer frame in the one that has a pose there."""
    sin, cos = sin_cos(pose.heading)
    return Pose(-cos * pose.x - sin * pose.y, sin * pose.x - cos * pose.y, wrap_angle(-pose.heading))


def apart(one: Pose, other: Pose) -> tuple[float, float]:
    """Return distance [m] and angle [rad] between two poses."""
    return dist(one[:2], other[:2]), abs(wrap_angle(one.heading - other.heading))


def _exceeds(found: tuple[float, float], bounds: tuple[float, float]) -> bool:
    return found[0] > bounds[0] or found[1] > bounds[1]


class Corrections:
    """
    Chooses the corrections that the cart uses: the mean of a second, where it has moved the cart enough.

    Attributes
    ----------
    used : Pose or None
        The one in use; None before the first.

    """

    def __init__(self) -> None:
        self.used: Pose | None = None
        self._window: list[tuple[int, Pose]] = []
        self._led = 0

    @property
    def newest(self) -> Pose | None:
        """The newest one; None before the first."""
        return self._window[-1][1] if self._window else None

    def note_correction(self, stamp: int, correction: Pose, at: Pose) -> None:
        """Note a correction with a stamp [ns] not before that of the last one, for a robot at a pose of odometry."""
        if self._window and _exceeds(apart(composed(correction, at), composed(self._mean(), at)), _JUMP):
            self._window.clear()
        self._window = [(time, one) for time, one in self._window if time > stamp - _MEAN * NANOSECONDS]
        self._window.append((stamp, correction))

    def _mean(self) -> Pose:
        poses = [one for _, one in self._window]
        if len(poses) == 1:
            return poses[0]
        first, count = poses[0], len(poses)
        return Pose(math.fsum(one.x for one in poses) / count, math.fsum(one.y for one in poses) / count, wrap_angle(
            first.heading + math.fsum(wrap_angle(one.heading - first.heading) for one in poses) / count))

    def due(self, now: int, at: Pose) -> Pose | None:
        """Return the correction to use from now [ns] on for a cart at a pose of odometry; None if it stays."""
        if not self._window:
            return None
        mean = self._mean()
        if self.used is not None and (now - self._led < _MEAN * NANOSECONDS or not _exceeds(
                apart(composed(mean, at), composed(self.used, at)), _LEAST)):
            return None
        self._led = now
        # rounded, so that a message that is written again has the same heading to the last bit
        return mean._replace(heading=round(mean.heading, 9))


class Swings:
    """Tells corrections that jump to and fro between two values, as of two publishers, from noise and from steps."""

    def __init__(self) -> None:
        self._last: Pose | None = None
        self._before: Pose | None = None
        self._count = 0

    def note_correction(self, correction: Pose) -> bool:
        """Receive a correction; return whether it jumps back, as several before it."""
        last, self._last = self._last, correction
        if last is None or not _exceeds(apart(last, correction), _JUMP):
            return False
        returns = self._before is not None and not _exceeds(apart(self._before, correction), _JUMP)
        self._before, self._count = last, self._count + 1 if returns else 0
        return self._count >= _SWINGS


class RandomCorrections:
    """
    Draws corrections at the ticks of a cart, each about the cart.

    Parameters
    ----------
    localisation : Localisation
        With a rate.

    """

    def __init__(self, localisation: Localisation) -> None:
        self._given, self._random = localisation, random.Random(localisation.seed)  # noqa: S311 (a simulation)
        self._number, self._true = 0, SAME

    def until(self, now: int, at: Pose) -> Iterator[tuple[int, Pose]]:
        """Yield stamps [ns] and corrections up to now [ns], for a cart at a pose of odometry; the first one is SAME."""
        parameters, draw = self._given, self._random
        while (stamp := round(self._number / parameters.rate * NANOSECONDS)) <= now:
            if self._number:
                here, (sine, cosine) = composed(self._true, at), sin_cos(draw.uniform(-math.pi, math.pi))
                spread = parameters.drift / math.sqrt(parameters.rate)
                moved = Pose(here.x + parameters.jump * cosine + spread * _normal(draw),
                             here.y + parameters.jump * sine + spread * _normal(draw),
                             wrap_angle(here.heading + draw.choice((-1.0, 1.0)) * parameters.turn))
                self._true = composed(moved, inverse(at))
            self._number += 1
            yield stamp, self._true._replace(x=self._true.x + parameters.noise * _normal(draw),
                                             y=self._true.y + parameters.noise * _normal(draw))


def _normal(draw: random.Random) -> float:
    return normal(1.0 - draw.random(), draw.random())
