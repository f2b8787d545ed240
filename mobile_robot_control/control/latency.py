"""Latency compensation: odometry is extrapolated over its age, along the arc of its twist."""

import math
from typing import NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.kinematics import along_arc
from mobile_robot_control.quantities import BodyVelocity, Pose


@jitable
def carried_forward(pose: Pose, velocity: BodyVelocity, age: float) -> Pose:
    """
    Compute the present pose of a robot from an old one, at constant velocity: along the exact arc.

    Parameters
    ----------
    pose : Pose
        Measured.
    velocity : BodyVelocity
        Measured at the same time [m/s], [rad/s].
    age : float
        Time since the measurement [s].

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
    The newest odometry, and the number of steps since it changed.

    If odometry is slower than the position loop and stamped when sent, the base repeats a sample with a new stamp: the
    sample is older than its stamp by these steps.
    """

    pose: Pose
    velocity: BodyVelocity
    steps: int


NO_ODOMETRY = HeldOdometry(Pose(math.nan, math.nan, math.nan), BodyVelocity(math.nan, math.nan), 0)
"""Before the first sample; equal to no sample, since nan equals nothing."""


@jitable
def held_odometry(last: HeldOdometry, pose: Pose, velocity: BodyVelocity) -> HeldOdometry:
    """Update the newest odometry; a moving robot does not measure the same pose and twist twice."""
    same = pose == last.pose and velocity == last.velocity
    return HeldOdometry(pose, velocity, last.steps + 1 if same else 0)


@jitable
def held_age(age: float, longest: float) -> float:
    """Clip an age [s] to 0 and the longest age of a message."""
    return min(max(age, 0.0), longest)
