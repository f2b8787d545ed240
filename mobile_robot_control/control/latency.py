"""Latency compensation: odometry is carried forward by its age, along the arc of its twist."""

from collections.abc import Callable

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.kinematics import along_arc
from mobile_robot_control.quantities import BodyVelocity, Pose

ObservedPose = Callable[[Pose, BodyVelocity, float], Pose]
"""Makes the pose that a law sees of a measured pose, its velocity and its age [s]."""


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


@jitable
def as_measured(pose: Pose, velocity: BodyVelocity, age: float) -> Pose:
    """Return a pose as it is: what `carried_forward` is where latency is not compensated."""
    return pose


@jitable
def held_age(age: float, longest: float) -> float:
    """Return an age [s] within 0 and the longest one that a message may have."""
    return min(max(age, 0.0), longest)
