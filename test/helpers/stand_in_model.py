"""Bases that take commands and give odometry late and seldom, by Euler steps and none of the package's formulas."""

import math
import random
from collections import deque
from typing import NamedTuple

# [s]; [m] from the middle to a wheel, and of a wheel
STEP, LEVER, RADIUS = 0.001, 0.175, 0.035


class Base(NamedTuple):
    """
    What a base is like, in SI units.

    `unlike`: by how much the right wheel is larger; `turn`: the share of a turn that skidding leaves; `lost`: of
    messages; with `ticks` of a wheel's revolution odometry reckons; `sent`: it is stamped when it is sent.
    """

    command_rate: float = 20.0
    odom_rate: float = 30.0
    latency: float = 0.06
    lag: float = 0.15
    dead_time: float = 0.0
    dead_zone: float = 0.05
    fastest: float = 0.7
    acceleration: float = math.inf
    unlike: float = 0.0
    turn: float = 1.0
    jitter: float = 0.0
    lost: float = 0.0
    ticks: int = 0
    sent: bool = False
    second_lag: float = 0.0
    quantum: float = 0.0
    scrub: float = 0.0
    skid: float = 0.0


class StandIn:
    """A base at its true `pose`; takes `commanded`; `odometry[0]`: the newest (stamp, pose, twist) that arrived."""

    def __init__(self, base, pose):
        self.base, self.pose = base, tuple(pose)
        self.k, self.v, self.omega, self._ramped = 0, 0.0, 0.0, 0.0
        self.commanded = (0.0, 0.0)
        self._taken, self._coming, self._first = (0.0, 0.0), deque(), (0.0, 0.0)
        self.odometry = deque([(0.0, self.pose, (0.0, 0.0))])
        self._sampled = deque()
        self._turned, self._counted, self._reckoned = [0.0, 0.0], [0, 0], self.pose
        self._random = random.Random(7)  # noqa: S311 (a simulation)

    def _late(self, time, latency):
        """Return when a message arrives; None where it is lost."""
        at = time + latency + self.base.jitter * self._random.random()
        return None if self._random.random() < self.base.lost else at

    def _odometer(self):
        """Return the pose and the twist that odometry shows."""
        if not self.base.ticks:
            return self.pose, (self.v, self.omega)
        tick = 2.0 * math.pi / self.base.ticks
        counts = [round(angle / tick) for angle in self._turned]
        right, left = (RADIUS * tick * (now - before) for now, before in zip(counts, self._counted, strict=True))
        self._counted = counts
        x, y, heading = self._reckoned
        along, turn = (right + left) / 2.0, (right - left) / (2.0 * LEVER)
        self._reckoned = (x + along * math.cos(heading + turn / 2.0), y + along * math.sin(heading + turn / 2.0),
                          heading + turn)
        return self._reckoned, (along * self.base.odom_rate, turn * self.base.odom_rate)

    def sample(self):
        """Sample odometry where it is due, and let what is late enough arrive."""
        time = self.k * STEP
        if _due(self.k, self.base.odom_rate):
            arrives, seen = self._late(time, self.base.latency), self._odometer()
            if arrives is not None:
                self._sampled.append((arrives, time, *seen))
        while self._sampled and self._sampled[0][0] <= time:
            arrives, stamp, pose, twist = self._sampled.popleft()
            self.odometry[0] = (time if self.base.sent else stamp, pose, twist)

    def move(self):
        """Take the command where it is due, and move."""
        base, time = self.base, self.k * STEP
        if _due(self.k, base.command_rate):
            arrives = self._late(time, base.dead_time)
            if arrives is not None:
                self._coming.append((arrives, self.commanded))
        while self._coming and self._coming[0][0] <= time:
            self._taken = self._coming.popleft()[1]
        v, omega = (base.quantum * round(one / base.quantum) if base.quantum else one for one in self._taken)
        asked = max(-base.fastest, min(base.fastest, v))
        if abs(asked) < base.dead_zone:
            asked = 0.0
        change = base.acceleration * STEP
        self._ramped = max(self._ramped - change, min(self._ramped + change, asked))
        # each wheel turns as if both were alike, and as if it did not skid
        v, omega = (self._ramped + 0.5 * base.unlike * LEVER * omega,
                    base.turn * (omega + 0.5 * base.unlike * self._ramped / LEVER))
        omega *= 1.0 - base.scrub * math.exp(-abs(v) / 0.1)
        if base.second_lag:
            share = STEP / base.second_lag
            v, omega = self._first = [one + share * (new - one) for one, new in zip(
                self._first, (v, omega), strict=True)]
        self.v += STEP / base.lag * (v - self.v)
        self.omega += STEP / base.lag * (omega - self.omega)
        for wheel, side in enumerate((1.0, -1.0)):
            self._turned[wheel] += STEP * (self.v + side * LEVER * self.omega) / RADIUS
        x, y, heading = self.pose
        along = abs(self.v) / (abs(self.v) + LEVER * abs(self.omega) + 1e-9)
        heading += STEP * self.omega * (1.0 - base.skid * (1.0 - 0.5 * along))
        aside = -0.1 * base.skid * LEVER * self.omega
        self.pose = (x + STEP * (self.v * math.cos(heading) - aside * math.sin(heading)),
                     y + STEP * (self.v * math.sin(heading) + aside * math.cos(heading)), heading)
        self.k += 1


def drive(base, control, start, seconds, rate=50.0, made=StandIn):
    """Drive a base by ``control(time, stamp, pose, velocity) -> (v, omega)``; return times and true poses."""
    robot = made(base, start)
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
