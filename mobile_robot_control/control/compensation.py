"""
Compensation of the loop's delays: feedforward of the reference, and odometry extrapolated over its age.

A base follows its command late by lag and dead time. During this time L the reference's velocity grows by its
acceleration, so a command with the lead v + L dv_r/dt arrives on time. Motors need torque to accelerate: feedback gives
it only after a velocity error, the inverse of Eq. (13)-(14) gives it at once.
"""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.model.kinematics import along_arc
from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose, Reference, WheelTorque


class Feedforward(NamedTuple):
    """Delays that the command leads by, of v and ω; they act only with feedforward.enabled."""

    lag: Annotated[
        tuple[float, ...],
        Field('s, s', "time constants of the robot's lags; the linear and the angular velocity lead by them: larger "
              'leads more', minimum=0.0, live=True, search=((0.0, 0.5),) * 2, length=2)
    ] = (0.0, 0.0)
    dead_time: Annotated[
        tuple[float, ...],
        Field('s, s', 'time until the robot begins to follow the linear and the angular velocity, which also lead by '
              'it: larger leads more', minimum=0.0, live=True, search=((0.0, 0.5),) * 2, length=2)
    ] = (0.0, 0.0)


class Lead(NamedTuple):
    """Times by which the linear and the angular velocity of a command lead [s]."""

    linear: float
    angular: float


NO_LEAD = Lead(0.0, 0.0)


@jitable
def advanced(velocity: BodyVelocity, acceleration: BodyAcceleration, time: float) -> BodyVelocity:
    """
    Return the velocity after a time under a constant acceleration.

    Parameters
    ----------
    velocity : BodyVelocity
        [m/s], [rad/s].
    acceleration : BodyAcceleration
        [m/s²], [rad/s²].
    time : float
        [s].

    Examples
    --------
    >>> advanced(BodyVelocity(1.0, 0.0), BodyAcceleration(0.5, -2.0), 0.5)
    BodyVelocity(linear=1.25, angular=-1.0)

    """
    return BodyVelocity(velocity.linear + time * acceleration.linear, velocity.angular + time * acceleration.angular)


@jitable
def leading(command: BodyVelocity, acceleration: BodyAcceleration, times: Lead) -> BodyVelocity:
    """Return a command whose velocities lead by their times, under a constant acceleration [m/s²], [rad/s²]."""
    return BodyVelocity(command.linear + times.linear * acceleration.linear,
                        command.angular + times.angular * acceleration.angular)


@jitable
def mean_acceleration(here: Reference, following: Reference) -> BodyAcceleration:
    """Return the reference's acceleration half-way between two consecutive position ticks [m/s²], [rad/s²]."""
    one, other = here.acceleration, following.acceleration
    return BodyAcceleration(0.5 * (one.linear + other.linear), 0.5 * (one.angular + other.angular))


def lead(delays: Feedforward) -> Lead:
    """Return the times by which the command leads."""
    return Lead(*(lag + dead_time for lag, dead_time in zip(delays.lag, delays.dead_time, strict=True)))


@jitable
def inverse_dynamics(velocity: BodyVelocity, acceleration: BodyAcceleration, robot: Robot) -> WheelTorque:
    """
    Compute the wheel torques for an acceleration of a robot at a velocity.

    Implements Eq. (13)-(14) of the chapter, solved for the torques.

    Parameters
    ----------
    velocity : BodyVelocity
        [m/s], [rad/s].
    acceleration : BodyAcceleration
        [m/s²], [rad/s²].
    robot : Robot
        Physical constants.

    Returns
    -------
    WheelTorque
        [N m].

    """
    # the sum of Eq. (13) and (14), and their difference: τ_R + τ_L = 2/r ((A + B) dv/dt + K v), and
    # τ_R - τ_L = 2R/r ((A - B) dω/dt + K ω)
    friction = robot.viscous_friction
    common = (linear_inertia(robot) * acceleration.linear + friction * velocity.linear) / robot.wheel_radius
    differential = (half_separation(robot) / robot.wheel_radius
                    * (angular_inertia(robot) * acceleration.angular + friction * velocity.angular))
    return WheelTorque(common + differential, common - differential)


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
