"""The velocity from odometry: its twist, or the motion of its poses if the twist contradicts them."""

import itertools
import math
from collections import deque

from rclpy.node import Node

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.quantities import BodyVelocity, Pose

_WINDOW, _LEAST = 1.0, 0.5
"""[s] of odometry that are compared: at most, and at least."""
_SHARE = 0.25
"""Of the larger motion: allowed difference of the two ..."""
_MOVED, _TURNED = 0.05, 0.1
"""... in addition to noise and slip [m], [rad]."""
_FASTEST = 5.0, 15.0
"""[m/s], [rad/s]: a faster pose was set, for example by a reset or a localisation."""
_BASELINE = 0.1
"""[s] over which poses give a velocity."""


class OdomTwist:
    """
    Compares the twists of odometry with the motion of its poses; some bases leave the twist at zero.

    Parameters
    ----------
    node : Node
        For the log.

    Attributes
    ----------
    problem : str
        Fault of the twist, in words; '' without one.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._taken: deque[tuple[float, Pose, BodyVelocity]] = deque()
        self.problem = ''

    def note(self, stamp: int, pose: Pose, velocity: BodyVelocity) -> BodyVelocity:
        """Receive odometry with its stamp [ns]; return the velocity of the robot."""
        time, taken = stamp / 1e9, self._taken
        if taken and (not 0.0 < time - taken[-1][0] < _LEAST or _jumps(*taken[-1][:2], time, pose)):
            taken.clear()  # of another clock, before a pause, or before the robot was moved
        taken.append((time, pose, velocity))
        while time - taken[0][0] > _WINDOW:
            taken.popleft()
        if time - taken[0][0] >= _LEAST:
            self._compare()
        return self._by_poses() if self.problem else velocity

    def _compare(self) -> None:
        """Compare poses and twists over the same time."""
        moved = turned = promised = promised_turn = 0.0
        for (begin, before, _), (end, after, twist) in itertools.pairwise(self._taken):
            step = _motion(before, after)
            moved, turned = moved + step[0], turned + step[1]
            promised += twist.linear * (end - begin)
            promised_turn += twist.angular * (end - begin)
        seconds = self._taken[-1][0] - self._taken[0][0]
        wrong = (abs(moved - promised) > _SHARE * max(abs(moved), abs(promised)) + _MOVED
                 or abs(turned - promised_turn) > _SHARE * max(abs(turned), abs(promised_turn)) + _TURNED)
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
        end, newest, velocity = self._taken[-1]
        begin, pose, _ = next((one for one in reversed(self._taken) if end - one[0] >= _BASELINE), self._taken[0])
        if end <= begin:
            return velocity
        moved, turned = _motion(pose, newest)
        return BodyVelocity(moved / (end - begin), turned / (end - begin))


def _jumps(begin: float, before: Pose, end: float, after: Pose) -> bool:
    """Return whether no robot can drive from one pose to another, at times [s]."""
    moved, turned = math.hypot(after.x - before.x, after.y - before.y), abs(wrap_angle(after.heading - before.heading))
    return moved > _FASTEST[0] * (end - begin) + _MOVED or turned > _FASTEST[1] * (end - begin) + _TURNED


def _motion(before: Pose, after: Pose) -> tuple[float, float]:
    """Return the distance moved along the heading [m], and the turn [rad]."""
    turned = wrap_angle(after.heading - before.heading)
    middle = before.heading + 0.5 * turned
    return (after.x - before.x) * math.cos(middle) + (after.y - before.y) * math.sin(middle), turned
