"""
A base that is not of this package, in simulated time: takes velocity commands and gives odometry, both late and seldom.

A model of its own: small Euler steps, and none of the package's formulas.
"""

import math
from collections import deque
from typing import NamedTuple

STEP = 0.001
"""[s]"""


class Base(NamedTuple):
    """What the base is like: rates [Hz], times [s], velocities [m/s]."""

    command_rate: float = 20.0
    odom_rate: float = 30.0
    latency: float = 0.06
    lag: float = 0.15
    dead_zone: float = 0.05
    fastest: float = 0.7


def drive(base, control, start, seconds, rate=50.0):
    """
    Drive a base; return its true poses by time, one for each step of the controller.

    ``control(time, stamp, pose, velocity) -> (v, omega)`` is called at the controller's rate with the newest odometry
    that has arrived, and its stamp.
    """
    x, y, heading = start
    v = omega = 0.0
    commanded = taken = (0.0, 0.0)
    odometry = deque([(0.0, (x, y, heading), (0.0, 0.0))])
    truth = []
    for k in range(round(seconds / STEP)):
        time = k * STEP
        if _due(k, base.odom_rate):
            odometry.append((time, (x, y, heading), (v, omega)))
        while len(odometry) > 1 and odometry[1][0] + base.latency <= time:
            odometry.popleft()
        if _due(k, rate):
            truth.append((time, (x, y, heading)))
            commanded = control(time, *odometry[0])
        if _due(k, base.command_rate):
            taken = commanded
        asked = max(-base.fastest, min(base.fastest, taken[0]))
        if abs(asked) < base.dead_zone:
            asked = 0.0
        v += STEP / base.lag * (asked - v)
        omega += STEP / base.lag * (taken[1] - omega)
        heading += STEP * omega
        x += STEP * v * math.cos(heading)
        y += STEP * v * math.sin(heading)
    return truth


def _due(k, rate):
    """Return whether a tick of a rate [Hz] falls into a step."""
    return math.floor((k + 1) * STEP * rate + 1e-9) > math.floor(k * STEP * rate + 1e-9) or k == 0
