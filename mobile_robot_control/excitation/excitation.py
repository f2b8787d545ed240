"""Commands that excite everything that `identify` fits, within a box: as asked for, and at each time."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mobile_robot_control.elementary import asin, atan2, hypot, sin, sin_cos
from mobile_robot_control.quantities import BodyVelocity, Pose

STOPPING = 1.0
"""[s]: stopping distance over speed, as allowed to a robot; enough for 0.5 m/s² at 0.7 m/s."""
_CLEAR = 0.25
"""Share of the largest velocities from which any robot moves that is to be identified."""
_AT_REST = 0.02
"""Share below which it stands."""
_UNSEEN = 0.6
"""[s] of the largest command without a change of odometry: more than a robot's dead time, less than STOPPING."""
_EXPLAINED = 2.0
"""Largest velocity by odometry over the largest command ..."""
_JUMP = 0.2, 0.5
"""... beyond which so much [m], [rad] adds up only where odometry jumps."""
_HOMING = BodyVelocity(0.5, 0.5)
"""Shares of the largest velocities on the way back to the middle."""
_AIMED = 0.3
"""[rad]: heading error below which the robot drives on that way."""
_NEAR = 0.1
"""Share of a side within which the robot counts as in the middle."""


class Area(NamedTuple):
    """
    The area and the speed of an excitation.

    Attributes
    ----------
    ahead, aside : float
        Sides of the box around the robot's start [m].
    fastest : BodyVelocity
        Largest commands [m/s], [rad/s].
    """

    ahead: float
    aside: float
    fastest: BodyVelocity

    def holds(self, x: float, y: float) -> bool:
        """Return whether a position in the frame of the start lies in the box."""
        return abs(x) <= 0.5 * self.ahead and abs(y) <= 0.5 * self.aside


class Manoeuvre(NamedTuple):
    """
    A part of the excitation.

    Attributes
    ----------
    shape : str
        'hold', 'ramp' (forth and back) or 'chirp' (0.3 to 2 Hz).
    seconds : float
        Length.
    largest : BodyVelocity
        Shares of the largest velocities.
    """

    shape: str
    seconds: float
    largest: BodyVelocity

    def at(self, time: float) -> BodyVelocity:
        """Return the shares at a time after its start [s]."""
        if self.shape == 'ramp':
            share = 2.0 / math.pi * asin(sin(2.0 * math.pi * time / self.seconds))
        elif self.shape == 'chirp':
            share = sin(2.0 * math.pi * time * (0.3 + 0.85 * time / self.seconds))
        else:
            share = 1.0
        return _times(share, self.largest)


class Excited(NamedTuple):
    """
    The progress of an excitation.

    Attributes
    ----------
    number : int
        Of the manoeuvre.
    since : float
        Time of its start [s].
    is_homing : bool
        Whether the robot is on its way back to the middle.
    """

    number: int = 0
    since: float = 0.0
    is_homing: bool = False


class Agreement(NamedTuple):
    """
    The agreement of odometry with the commands.

    Attributes
    ----------
    unseen : float
        Time since odometry has last changed [s], times the share of the largest command; 1 for a velocity by odometry.
    unexplained : BodyVelocity
        Way [m] and turn [rad] by odometry beyond the explanation of the commands.
    """

    unseen: float = 0.0
    unexplained: BodyVelocity = BodyVelocity(0.0, 0.0)

    def commanded(self, command: BodyVelocity, measured: BodyVelocity, dt: float, area: Area) -> 'Agreement':
        """Return the agreement after some time [s] with a command and a velocity by odometry."""
        share = 0.0
        for wanted, shown, largest in zip(command, measured, area.fastest, strict=True):
            if abs(shown) > _AT_REST * largest:
                share = 1.0
            elif abs(wanted) >= _CLEAR * largest:
                share = max(share, abs(wanted) / largest)
        return self._replace(unseen=self.unseen + share * dt)

    def moved(self, way: float, turn: float, dt: float, area: Area) -> 'Agreement':
        """Return the agreement after a way [m] and a turn [rad] by odometry in some time [s]."""
        unexplained = BodyVelocity(*(
            max(0.0, before + one - _EXPLAINED * largest * dt)
            for before, one, largest in zip(self.unexplained, (way, turn), area.fastest, strict=True)))
        return Agreement(0.0, unexplained)

    def fault(self) -> str:
        """Describe a contradiction between odometry and commands; '' without one."""
        if self.unseen > _UNSEEN:
            return ('odometry does not change, though the robot should move by its commands or by its velocity: its '
                    'driver hangs, or the robot is not switched on and released')
        if any(one > most for one, most in zip(self.unexplained, _JUMP, strict=True)):
            return (f'odometry moves {self.unexplained.linear:.2f} m and {self.unexplained.angular:.2f} rad farther '
                    f'than {_EXPLAINED:g} times the largest commands explain: it jumps, or is of something else')
        return ''


def _times(share: float, velocity: BodyVelocity) -> BodyVelocity:
    return BodyVelocity(share * velocity.linear, share * velocity.angular)


def _cycle(number: int) -> Iterator[Manoeuvre]:
    """Yield the manoeuvres of half a minute; later ones are slower, and drive other curves."""
    level = (1.0, 0.6, 0.3)[number % 3]
    velocities = BodyVelocity(1.0, 0.0), BodyVelocity(0.0, 1.0)
    for velocity in velocities:
        for share in (level, -level):
            yield Manoeuvre('hold', 1.2, _times(share, velocity))
            yield Manoeuvre('hold', 0.5, _times(0.0, velocity))
    for shape, seconds, share in (('ramp', 6.0, 0.15), ('chirp', 3.0, 0.7 * level)):
        for velocity in velocities:
            yield Manoeuvre(shape, seconds, _times(share, velocity))
            yield Manoeuvre('hold', 0.3, _times(0.0, velocity))
    random = np.random.default_rng(number)
    for _ in range(10):
        linear, angular = random.choice([1.0, -1.0, 0.5, -0.5, 0.15, -0.15], 2)
        yield Manoeuvre('hold', float(random.uniform(0.3, 1.0)), _times(level, BodyVelocity(linear, angular)))


_OF_A_CYCLE = len(list(_cycle(0)))


def manoeuvre(number: int) -> Manoeuvre:
    """Return the n-th manoeuvre of an endless sequence."""
    cycle, place = divmod(number, _OF_A_CYCLE)
    return list(_cycle(cycle))[place]


def excite(
    state: Excited, time: float, pose: Pose, velocity: BodyVelocity, area: Area
) -> tuple[Excited, BodyVelocity]:
    """
    Return the next state and the command of an excitation.

    Parameters
    ----------
    state : Excited
        The last one.
    time : float
        Since the start [s].
    pose : Pose
        In the frame of the start [m], [rad].
    velocity : BodyVelocity
        Measured [m/s], [rad/s].
    area : Area
        The box and the largest commands.

    Notes
    -----
    A manoeuvre ends early if the robot could soon not stop within the box; the robot then drives back to the middle.
    """
    current = manoeuvre(state.number)
    if not state.is_homing and time - state.since >= current.seconds:
        state = Excited(state.number + 1, time)
        current = manoeuvre(state.number)
    if state.is_homing and abs(pose.x) < _NEAR * area.ahead and abs(pose.y) < _NEAR * area.aside:
        state = Excited(state.number + 1, time)
        current = manoeuvre(state.number)
    shares = _homing(pose) if state.is_homing else current.at(time - state.since)
    command = BodyVelocity(shares.linear * area.fastest.linear, shares.angular * area.fastest.angular)
    if _stops_outside(pose, velocity.linear, area):
        return state._replace(is_homing=True), BodyVelocity(0.0, 0.0)
    if _stops_outside(pose, command.linear, area):
        state = state._replace(is_homing=True)
        command = BodyVelocity(0.0, command.angular)
    return state, command


def _stops_outside(pose: Pose, speed: float, area: Area) -> bool:
    """Return whether a robot that drives away from the middle may not stop within the box."""
    way = STOPPING * speed
    sine, cosine = sin_cos(pose.heading)
    x, y = pose.x + way * cosine, pose.y + way * sine
    return not area.holds(x, y) and hypot(x, y) > hypot(pose.x, pose.y)


def _homing(pose: Pose) -> BodyVelocity:
    """Return the shares that lead to the middle, backwards if that is the smaller turn."""
    bearing = math.remainder(atan2(-pose.y, -pose.x) - pose.heading, 2.0 * math.pi)
    sign = 1.0 if abs(bearing) < 0.5 * math.pi else -1.0
    error = math.remainder(bearing if sign > 0.0 else bearing + math.pi, 2.0 * math.pi)
    turn = max(-1.0, min(1.0, error / _AIMED))
    return BodyVelocity(sign * _HOMING.linear if abs(error) < _AIMED else 0.0, turn * _HOMING.angular)


class Excitation(NamedTuple):
    """
    The result of an excitation.

    Attributes
    ----------
    way, turn, farthest : float
        Distance [m] and turn [rad], and the largest distance from the start, ahead or aside [m].
    fault : str
        Reason of an early end; '' without one.
    """

    way: float
    turn: float
    farthest: float
    fault: str
