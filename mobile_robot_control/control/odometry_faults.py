"""Odometry that a robot must not be driven by: a jump across a silence, and motion against the command."""

import math
from typing import NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import dist, sin_cos
from mobile_robot_control.quantities import BodyVelocity, Pose

SILENCE = 0.2
"""[s] from one message to the next, from which on its pose is compared with the last one alone."""
_ROLLS = 1.0
"""[s] after the timeout of its commands in which a robot may still drive."""
_NEAR = 0.1
"""[m], [rad]: allowance for noise, and for what a base needs to stop."""


def jump_across(
    silence: float, before: Pose, pose: Pose, fastest: BodyVelocity, timeout: float
) -> tuple[float, float] | tuple[()]:
    """
    Return how far a pose lies from the last one before a silence; () if the robot may have driven there.

    Parameters
    ----------
    silence : float
        [s].
    before, pose : Pose
        Of odometry.
    fastest : BodyVelocity
        The largest velocity that twists and command tell, without signs.
    timeout : float
        Of the robot's commands [s].

    Returns
    -------
    tuple of float
        Distance [m] and turn [rad].

    Examples
    --------
    >>> at, driven, elsewhere = (Pose(x, 0.0, 0.0) for x in (1.0, 1.2, 0.0))
    >>> fastest = BodyVelocity(0.3, 0.0)
    >>> jump_across(0.5, at, driven, fastest, 0.5), jump_across(0.5, at, elsewhere, fastest, 0.5)
    ((), (1.0, 0.0))

    """
    seconds = min(silence, timeout + _ROLLS)
    moved, turned = dist(before[:2], pose[:2]), abs(wrap_angle(pose.heading - before.heading))
    if moved <= fastest.linear * seconds + _NEAR and turned <= fastest.angular * seconds + _NEAR:
        return ()
    return moved, turned


def largest(*velocities: BodyVelocity) -> BodyVelocity:
    """Return the largest of some velocities by component, without signs."""
    return BodyVelocity(*(max(map(abs, parts)) for parts in zip(*velocities, strict=True)))


CONTRARY = 'odometry moves against the command: wheels or encoders swapped, NED, or it is pushed or rolls'
_CLEAR = BodyVelocity(0.06, 0.1)
"""[m/s], [rad/s]: a smaller command says nothing."""
_ASKED = BodyVelocity(0.3, 0.5)
"""[m], [rad] that a command of one sign has to ask for."""
_STARTS = 0.5
"""[s] of each sign in which the robot may still brake."""
_AGAINST, _LASTS = 0.5, 0.8
"""Shares: of the motion asked for, that it makes the other way, and of its first speed, that it keeps."""


class OppositionChannel(NamedTuple):
    """
    Motion beside the command, for one component since the command last changed its sign.

    Attributes
    ----------
    sign : float
        Of the command; 0 before the first.
    since : float
        Time with that sign [s].
    commanded, posed, told : float
        Motion by commands, poses and twists since the robot need no longer brake [m] or [rad], positive along the
        command.
    first, now : float
        Speed by twists then and now, positive along the command [m/s] or [rad/s].

    """

    sign: float = 0.0
    since: float = 0.0
    commanded: float = 0.0
    posed: float = 0.0
    told: float = 0.0
    first: float = math.nan
    now: float = 0.0

    def after(
        self, command: float, clear: float, step: float, twist: float, dt: float, latency: float
    ) -> 'OppositionChannel':
        """Return the channel after a time [s] with a command, a step of the poses and a twist."""
        if abs(command) < clear:
            return self
        sign = math.copysign(1.0, command)
        if sign != self.sign:
            return OppositionChannel(sign)
        since = self.since + dt
        if since < _STARTS + latency:
            return self._replace(since=since)
        speed = sign * twist
        return OppositionChannel(sign, since, self.commanded + sign * command * dt, self.posed + sign * step,
                                 self.told + speed * dt, speed if math.isnan(self.first) else self.first, speed)

    def is_contrary(self, least: float) -> bool:
        """Return whether poses and twists move the other way, and do not brake."""
        return (self.commanded >= least and max(self.posed, self.told) < -_AGAINST * self.commanded
                and self.now <= _LASTS * self.first < 0.0)


class Opposition(NamedTuple):
    """Both components of odometry beside the commands."""

    linear: OppositionChannel = OppositionChannel()
    angular: OppositionChannel = OppositionChannel()

    def after(
        self, command: BodyVelocity, before: Pose, pose: Pose, twist: BodyVelocity, dt: float, latency: float = 0.0
    ) -> 'Opposition':
        """
        Return the state after odometry.

        Parameters
        ----------
        command : BodyVelocity
            The last one.
        before, pose : Pose
            The last one, and that of the odometry.
        twist : BodyVelocity
            Of the odometry.
        dt : float
            Time between the two poses [s].
        latency : float
            Known dead time of the robot [s].

        """
        if not 0.0 < dt <= SILENCE:
            return Opposition() if dt > SILENCE else self
        turned = wrap_angle(pose.heading - before.heading)
        sine, cosine = sin_cos(before.heading + 0.5 * turned)
        moved = (pose.x - before.x) * cosine + (pose.y - before.y) * sine
        return Opposition(
            self.linear.after(command.linear, _CLEAR.linear, moved, twist.linear, dt, latency),
            self.angular.after(command.angular, _CLEAR.angular, turned, twist.angular, dt, latency))

    def fault(self) -> str:
        """Return what is wrong, in words; '' if nothing is."""
        return CONTRARY if any(channel.is_contrary(least) for channel, least in zip(self, _ASKED, strict=True)) else ''
