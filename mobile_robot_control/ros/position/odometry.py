"""Odometry of a node: its age, the velocity from it, jumps of its pose, and several publishers that contradict."""

import itertools
import math
from collections import deque
from statistics import median
from typing import NamedTuple

from rclpy.node import Node

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.control.compensation import NO_ODOMETRY, advanced, carried_forward, held_age, held_odometry
from mobile_robot_control.control.odometry_faults import SILENCE, jump_across, largest
from mobile_robot_control.elementary import hypot, sin_cos
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, period_nanoseconds
from mobile_robot_control.ros.shared.clock import SteadyClock
from mobile_robot_control.ros.shared.peers import PublisherWatch
from mobile_robot_control.settings.shared import Shared


class OdomAge:
    """
    Measures the age of odometry; repeating a sample with a new stamp does not make it younger.

    Parameters
    ----------
    shared : Shared
        Parameters of the node.

    """

    def __init__(self, shared: Shared) -> None:
        self._longest = shared.stamp_tolerance
        self._period, self._velocity_dt = 1.0 / shared.position_rate, 1.0 / shared.velocity_rate
        self._velocity_period = period_nanoseconds(shared.velocity_rate)
        self._held, self._sampled = NO_ODOMETRY, 0
        self._told: int | None = None

    def begin_run(self) -> None:
        """Begin a run, or join one."""
        self._held = NO_ODOMETRY

    def note_odometry(self, stamp: int, pose: Pose, velocity: BodyVelocity) -> None:
        """Receive odometry with its stamp [ns]."""
        self._held = held_odometry(self._held, pose, velocity)
        if self._held.steps == 0:
            self._sampled = stamp

    def at(self, stamp: int, latency: float) -> float:
        """Return the age [s] of the newest odometry at a stamp [ns], with a latency that its stamp does not show."""
        return held_age(latency + self._since(stamp), self._longest)

    def _since(self, stamp: int) -> float:
        if self._told is not None:
            return (stamp - self._told) // self._velocity_period * self._velocity_dt
        return self._held.steps * self._period

    def note_step(self, stamp: int, pose: Pose, velocity: BodyVelocity, told: int | None) -> None:
        """Receive the odometry of a step, and the time [ns] of its sampling if known."""
        self.note_odometry(stamp, pose, velocity)
        self._told = told

    def present(self, reference: Reference, _age: int) -> Reference:
        """Extrapolate a reference of some age [ns] to now: in lockstep it is of now."""
        return reference


class WallClockOdomAge(OdomAge):
    """OdomAge for stamps of a clock; each odometry is noted on arrival."""

    def note_step(self, stamp: int, pose: Pose, velocity: BodyVelocity, told: int | None) -> None:
        """Do nothing: odometry was noted on arrival."""

    def _since(self, stamp: int) -> float:
        return (stamp - self._sampled) / 1e9

    def present(self, reference: Reference, age: int) -> Reference:
        """Extrapolate a reference of some age [ns] to now; reference and pose must be of the same time."""
        since = held_age(age / 1e9, self._longest)
        return Reference(
            carried_forward(reference.pose, advanced(reference.velocity, reference.acceleration, 0.5 * since), since),
            advanced(reference.velocity, reference.acceleration, since), reference.acceleration)


CONFLICT = 'odom has several publishers that contradict each other'
_POSITION, _HEADING = 0.05, 0.1
"""[m], [rad]: allowance for noise and rounding in a motion."""
_MARGIN = 1.5
"""Factor of a robot's largest speed in between over both twists."""
_VELOCITY, _ACCELERATION = 0.3, 20.0
"""[m/s or rad/s], [m/s² or rad/s²]: possible changes of a robot's twist."""


def contradicts(stamp: int, pose: Pose, velocity: BodyVelocity, last: tuple[int, Pose, BodyVelocity]) -> bool:
    """
    Return whether no robot can get from one odometry message to another.

    Parameters
    ----------
    stamp : int
        [ns].
    pose : Pose
        Measured.
    velocity : BodyVelocity
        Measured, in the robot's frame.
    last : tuple of int, Pose and BodyVelocity
        The previous message.

    """
    dt = abs(stamp - last[0]) / 1e9
    before, twist = last[1], last[2]
    moved = hypot(pose.x - before.x, pose.y - before.y)
    turned = abs(wrap_angle(pose.heading - before.heading))
    return (
        moved > _MARGIN * dt * max(abs(twist.linear), abs(velocity.linear)) + _POSITION
        or turned > _MARGIN * dt * max(abs(twist.angular), abs(velocity.angular)) + _HEADING
        or any(abs(now - then) > _ACCELERATION * dt + _VELOCITY for now, then in zip(velocity, twist, strict=True))
    )


class OdomConflict:
    """
    Compares each odometry with the previous one; a single publisher may jump, for example a corrected localisation.

    Parameters
    ----------
    node : Node
        Node with the odometry.
    watch : PublisherWatch
        Counts its publishers.
    clock : SteadyClock
        Of the node.
    hold : float
        Time for which a conflict persists after the last contradiction [s].

    """

    def __init__(self, node: Node, watch: PublisherWatch, clock: SteadyClock, hold: float) -> None:
        self._node, self._watch, self._clock, self._hold = node, watch, clock, hold
        self._last: tuple[int, Pose, BodyVelocity] | None = None
        self._until = -math.inf

    @property
    def present(self) -> bool:
        """Whether there is a conflict now."""
        return self._clock.now() < self._until

    def begin_after_silence(self, stamp: int, pose: Pose, velocity: BodyVelocity) -> None:
        """Begin with odometry after a silence, before which a publisher may have been killed."""
        self._last = stamp, pose, velocity

    def note_odometry(self, stamp: int, pose: Pose, velocity: BodyVelocity) -> None:
        """Receive odometry with its stamp [ns]."""
        last, self._last = self._last, (stamp, pose, velocity)
        if last is not None and contradicts(stamp, pose, velocity, last) and self._watch.publishers('odom') > 1:
            if not self.present:
                self._node.get_logger().error(f'{CONFLICT}; stop all but one. The robot stands meanwhile, unless '
                                              'stop_on_odom_conflict is false')
            self._until = self._clock.now() + self._hold


_WINDOW, _LEAST = 1.0, 0.5
"""[s] of odometry that are compared: at most, and at least."""
_SHARE = 0.25
"""Of the larger motion: allowed difference of the two ..."""
_MOVED, _TURNED = 0.05, 0.1
"""... in addition to noise and slip [m], [rad]."""
_STRAY = Pose(0.03, 0.03, 0.06)
"""[m], [m], [rad]: smaller steps of a pose against its twist are no jumps."""
_TWIST_CHANGE = 5.0, 10.0
"""[m/s²], [rad/s²]: possible changes of the twist between two messages."""
_NOISE, _FEW, _UNKNOWN = 3.0, 5, 0.1
"""Factor of a jump over the usual step against the twist; which is known from so many on, and before it is this [m]."""
_BASELINE = 0.1
"""[s] over which poses give a velocity."""


class _Sample(NamedTuple):
    """
    Odometry.

    Attributes
    ----------
    time : float
        [s].
    pose, twist : Pose, BodyVelocity
        As measured.
    stray : Pose
        Step of the pose from the previous one, less that of the twists.
    jumped : bool
        Whether this step is a jump.

    """

    time: float
    pose: Pose
    twist: BodyVelocity
    stray: Pose
    jumped: bool


_STANDS = BodyVelocity(0.0, 0.0)


class OdomTwist:
    """
    Compares the twists of odometry with the motion of its poses.

    Some bases leave the twist at zero: it then contradicts many poses. Where a localisation corrects the pose or a
    driver is reset, one pose contradicts the twist: it has jumped, and the twist stays trusted.

    Parameters
    ----------
    node : Node
        For the log.

    Attributes
    ----------
    problem : str
        Fault of the twist, in words; '' without one.
    jump : tuple of float
        By how far the newest pose has jumped [m], [rad]; () if it has not.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._taken: deque[_Sample] = deque()
        self.problem = ''
        self.jump: tuple[float, float] | tuple[()] = ()

    def note_odometry(
        self, stamp: int, pose: Pose, velocity: BodyVelocity, command: BodyVelocity = _STANDS,
        timeout: float = 0.0,
    ) -> BodyVelocity:
        """
        Receive odometry; return the velocity of the robot.

        Parameters
        ----------
        stamp : int
            [ns].
        pose, velocity : Pose, BodyVelocity
            As measured.
        command : BodyVelocity
            The last one.
        timeout : float
            Of commands [s].

        """
        time, taken = stamp / 1e9, self._taken
        stray, self.jump = Pose(0.0, 0.0, 0.0), ()
        if taken:
            last, dt = taken[-1], max(0.0, time - taken[-1].time)
            stray = _stray(last, pose, velocity, dt)
            if dt > SILENCE:
                self.jump = jump_across(dt, last.pose, pose, largest(last.twist, velocity, command), timeout)
            elif self._has_jumped(stray, _unknown(last.twist, velocity, dt)):
                self.jump = hypot(stray.x, stray.y), abs(stray.heading)
            if time < last.time:
                taken.clear()  # of another clock
        taken.append(_Sample(time, pose, velocity, stray, bool(self.jump)))
        while time - taken[0].time > _WINDOW:
            taken.popleft()
        if time - taken[0].time >= _LEAST:
            self._compare()
        return self._by_poses() if self.problem else velocity

    def forget_odometry(self) -> None:
        """Forget the odometry so far."""
        self._taken.clear()

    def _has_jumped(self, stray: Pose, unknown: tuple[float, float]) -> bool:
        """Return whether a pose strays from its twist more than the last second, and from all of its poses."""
        moved, turned = _STRAY.x + unknown[0], _STRAY.heading + unknown[1]
        if hypot(stray.x, stray.y) <= moved and abs(stray.heading) <= turned:
            return False
        # a twist that lies strays on and on, and noise again and again
        before = self._taken[-1].stray
        ahead = (before.x * stray.x + before.y * stray.y) / (hypot(stray.x, stray.y) or 1.0)
        few = len(self._taken) < _FEW
        moved += _NOISE * max(ahead, _UNKNOWN if few else median(
            hypot(one.stray.x, one.stray.y) for one in self._taken))
        turned += _NOISE * max(math.copysign(before.heading, before.heading * stray.heading), _UNKNOWN if few else
                               median(abs(one.stray.heading) for one in self._taken))
        # poses that come more seldom than messages, or with uneven stamps, return to the way of the twist
        x, y, heading = stray
        for sample in reversed(self._taken):
            if hypot(x, y) <= moved and abs(heading) <= turned:
                return False
            if sample.jumped:
                break
            x, y, heading = x + sample.stray.x, y + sample.stray.y, heading + sample.stray.heading
        return True

    def _compare(self) -> None:
        """Compare poses and twists over the same time, without jumps."""
        moved = turned = promised = promised_turn = 0.0
        allowed, allowed_turn = _MOVED, _TURNED
        for before, after in itertools.pairwise(self._taken):
            if after.jumped:
                continue
            dt = after.time - before.time
            step = _motion(before.pose, after.pose)
            moved, turned = moved + step[0], turned + step[1]
            promised += 0.5 * (before.twist.linear + after.twist.linear) * dt
            promised_turn += 0.5 * (before.twist.angular + after.twist.angular) * dt
            unknown = _unknown(before.twist, after.twist, dt)
            allowed, allowed_turn = allowed + unknown[0], allowed_turn + unknown[1]
        seconds = self._taken[-1].time - self._taken[0].time
        wrong = (abs(moved - promised) > _SHARE * max(abs(moved), abs(promised)) + allowed
                 or abs(turned - promised_turn) > _SHARE * max(abs(turned), abs(promised_turn)) + allowed_turn)
        if wrong and not self.problem:
            self.problem = (
                f'the twist of odom ({promised / seconds:.2f} m/s, {promised_turn / seconds:.2f} rad/s) contradicts '
                f'the motion of its poses ({moved / seconds:.2f} m/s, {turned / seconds:.2f} rad/s), which are used '
                'instead; publish the twist in the frame of the robot')
            self._node.get_logger().warning(self.problem)
        elif not wrong and self.problem:
            self.problem = ''
            self._node.get_logger().info('the twist of odom agrees with its poses again')

    def _by_poses(self) -> BodyVelocity:
        """Return the mean velocity over the last moment."""
        newest = begin = self._taken[-1]
        for before in itertools.islice(reversed(self._taken), 1, None):
            if begin.jumped or newest.time - begin.time >= _BASELINE:
                break
            begin = before
        if newest.time <= begin.time:
            return newest.twist
        moved, turned = _motion(begin.pose, newest.pose)
        return BodyVelocity(moved / (newest.time - begin.time), turned / (newest.time - begin.time))


def _stray(last: _Sample, pose: Pose, velocity: BodyVelocity, dt: float) -> Pose:
    """Return the step to a pose, less that of the mean twist over a time [s] along the middle of its arc."""
    turn = 0.5 * (last.twist.angular + velocity.angular) * dt
    way, along = 0.5 * (last.twist.linear + velocity.linear) * dt, last.pose.heading + 0.5 * turn
    sine, cosine = sin_cos(along)
    return Pose(pose.x - last.pose.x - way * cosine, pose.y - last.pose.y - way * sine,
                wrap_angle(pose.heading - last.pose.heading - turn))


def _unknown(before: BodyVelocity, after: BodyVelocity, dt: float) -> tuple[float, float]:
    """Return by how much [m], [rad] a motion between two twists may differ from their mean over a time [s]."""
    # speeding up and slowing down by a differ by a dt²/4; in a long gap the robot may have stood, or moved a little
    linear, angular = (max(abs(one), abs(other)) for one, other in zip(before, after, strict=True))
    return (min(0.25 * _TWIST_CHANGE[0] * dt * dt, linear * dt + 2.0 * _MOVED),
            min(0.25 * _TWIST_CHANGE[1] * dt * dt, angular * dt + 2.0 * _TURNED))


def _motion(before: Pose, after: Pose) -> tuple[float, float]:
    """Return the distance moved along the heading [m], and the turn [rad]."""
    turned = wrap_angle(after.heading - before.heading)
    sine, cosine = sin_cos(before.heading + 0.5 * turned)
    return (after.x - before.x) * cosine + (after.y - before.y) * sine, turned
