"""Latency compensation: odometry is carried forward by its age, along the arc of its twist."""

import math
from typing import NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.kinematics import along_arc
from mobile_robot_control.quantities import BodyVelocity, Pose


@jitable
def carried_forward(pose: Pose, velocity: BodyVelocity, age: float) -> Pose:
    """
    Compute where a robot is now that was at a pose some time ago and has kept its velocity: along the exact arc.

    Parameters
    ----------
    pose : Pose
        Measured.
    velocity : BodyVelocity
        Measured at the same time [m/s], [rad/s].
    age : float
        Time since then [s].

    Returns
    -------
    Pose
        The heading is wrapped.

    Examples
    --------
    >>> carried_forward(Pose(1.0, 2.0, 0.0), BodyVelocity(0.5, 0.0), 0.1)
    Pose(x=1.05, y=2.0, heading=0.0)

    """
    return along_arc(pose, velocity.linear * age, velocity.angular * age)


class HeldOdometry(NamedTuple):
    """
    The newest odometry, and for how many steps it has not changed.

    A base whose odometry is slower than the position loop, and that stamps when it sends, repeats a sample as if it
    were new: it is as much older.
    """

    pose: Pose
    velocity: BodyVelocity
    steps: int


NO_ODOMETRY = HeldOdometry(Pose(math.nan, math.nan, math.nan), BodyVelocity(math.nan, math.nan), 0)
"""Before the first one: equal to none."""


@jitable
def held_odometry(last: HeldOdometry, pose: Pose, velocity: BodyVelocity) -> HeldOdometry:
    """Return the newest odometry after that of the step before; a robot that moves does not measure the same twice."""
    same = pose == last.pose and velocity == last.velocity
    return HeldOdometry(pose, velocity, last.steps + 1 if same else 0)


@jitable
def held_age(age: float, longest: float) -> float:
    """Return an age [s] within 0 and the longest one that a message may have."""
    return min(max(age, 0.0), longest)
