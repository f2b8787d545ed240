"""
A base that is not of this package, in simulated time: takes velocity commands and gives odometry, both late and seldom.

A model of its own: small Euler steps, and none of the package's formulas.
"""

import math
from collections import deque
from typing import NamedTuple

STEP = 0.001
"""[s]"""


_LEVER = 0.175
"""[m] from the middle to a wheel."""


class Base(NamedTuple):
    """What the base is like: rates [Hz], times [s], velocities [m/s]; the right wheel's excess size, as a share."""

    command_rate: float = 20.0
    odom_rate: float = 30.0
    latency: float = 0.06
    lag: float = 0.15
    dead_zone: float = 0.05
    fastest: float = 0.7
    unlike: float = 0.0


class StandIn:
    """
    A base at rest at a pose; `step` moves it by `STEP`.

    Attributes
    ----------
    pose : tuple of float
        True one.
    commanded : tuple of float
        The newest command, set from outside.
    odometry : deque
        Samples (time, pose, twist); the first is the newest that has arrived.

    """

    def __init__(self, base, pose):
        self.base, self.pose = base, tuple(pose)
        self.k, self.v, self.omega = 0, 0.0, 0.0
        self.commanded = self._taken = (0.0, 0.0)
        self.odometry = deque([(0.0, self.pose, (0.0, 0.0))])

    def sample(self):
        """Sample odometry where it is due, and let what is late enough arrive."""
        time = self.k * STEP
        if _due(self.k, self.base.odom_rate):
            self.odometry.append((time, self.pose, (self.v, self.omega)))
        while len(self.odometry) > 1 and self.odometry[1][0] + self.base.latency <= time:
            self.odometry.popleft()

    def move(self):
        """Take the command where it is due, and move."""
        base = self.base
        if _due(self.k, base.command_rate):
            v, omega = self.commanded
            # each wheel turns as if both were alike
            self._taken = (v + 0.5 * base.unlike * _LEVER * omega, omega + 0.5 * base.unlike * v / _LEVER)
        asked = max(-base.fastest, min(base.fastest, self._taken[0]))
        if abs(asked) < base.dead_zone:
            asked = 0.0
        self.v += STEP / base.lag * (asked - self.v)
        self.omega += STEP / base.lag * (self._taken[1] - self.omega)
        x, y, heading = self.pose
        heading += STEP * self.omega
        self.pose = (x + STEP * self.v * math.cos(heading), y + STEP * self.v * math.sin(heading), heading)
        self.k += 1


def drive(base, control, start, seconds, rate=50.0):
    """
    Drive a base; return its true poses by time, one for each step of the controller.

    ``control(time, stamp, pose, velocity) -> (v, omega)`` is called at the controller's rate with the newest odometry
    that has arrived, and its stamp.
    """
    robot = StandIn(base, start)
    truth = []
    for k in range(round(seconds / STEP)):
        time = k * STEP
        robot.sample()
        if _due(k, rate):
            truth.append((time, robot.pose))
            robot.commanded = control(time, *robot.odometry[0])
        robot.move()
    return truth


def _due(k, rate):
    """Return whether a tick of a rate [Hz] falls into a step."""
    return math.floor((k + 1) * STEP * rate + 1e-9) > math.floor(k * STEP * rate + 1e-9) or k == 0
