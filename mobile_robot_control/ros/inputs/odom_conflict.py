"""Contradicting odometry of several publishers: no robot can move from one message to the next."""

import math

from rclpy.node import Node

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.quantities import BodyVelocity, Pose
from mobile_robot_control.ros.services.publisher_watch import PublisherWatch
from mobile_robot_control.ros.services.robot_clock import SteadyClock

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
    moved = math.hypot(pose.x - before.x, pose.y - before.y)
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

    def note(self, stamp: int, pose: Pose, velocity: BodyVelocity) -> None:
        """Receive odometry with its stamp [ns]."""
        last, self._last = self._last, (stamp, pose, velocity)
        if last is not None and contradicts(stamp, pose, velocity, last) and self._watch.publishers('odom') > 1:
            if not self.present:
                self._node.get_logger().error(f'{CONFLICT}; stop all but one. The robot stands meanwhile, unless '
                                              'stop_on_odom_conflict is false')
            self._until = self._clock.now() + self._hold
