"""Wheel velocities to body velocity and back, and the arc of a constant body velocity."""

import math

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import sin, sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.robot import Robot, half_separation
from mobile_robot_control.quantities import (
    BodyAcceleration,
    BodyVelocity,
    Pose,
    Reference,
    WheelVelocity,
)

_STRAIGHT = 1e-4
"""[rad]: below it an arc is a line to within 1e-9 of its length."""


@jitable
def body_velocity(wheels: WheelVelocity, robot: Robot) -> BodyVelocity:
    """
    Compute the body velocity from wheel velocities, as odometry from encoders does.

    Implements Eq. (5)-(7) of the chapter in the robot's own frame.

    Parameters
    ----------
    wheels : WheelVelocity
        ω_R and ω_L [rad/s].
    robot : Robot
        Physical constants.

    Returns
    -------
    BodyVelocity
        v [m/s] and ω [rad/s].

    Examples
    --------
    >>> body_velocity(WheelVelocity(1.0, 1.0), Robot(wheel_radius=0.5))
    BodyVelocity(linear=0.5, angular=0.0)

    """
    half_radius = 0.5 * robot.wheel_radius
    return BodyVelocity(
        # Eq. (5), (6): v = r/2 (ω_R + ω_L), along the heading
        linear=half_radius * (wheels.right + wheels.left),
        # Eq. (7): ω = r (ω_R - ω_L) / (2R)
        angular=half_radius * (wheels.right - wheels.left) / half_separation(robot),
    )


@jitable
def wheel_velocity(body: BodyVelocity, robot: Robot) -> WheelVelocity:
    """
    Compute the wheel velocities of a body velocity.

    Implements Eq. (19) of the chapter.

    Parameters
    ----------
    body : BodyVelocity
        v [m/s] and ω [rad/s].
    robot : Robot
        Physical constants.

    Returns
    -------
    WheelVelocity
        ω_R and ω_L [rad/s].

    """
    rim = half_separation(robot) * body.angular
    # Eq. (19): ω_R = (v + R ω) / r, ω_L = (v - R ω) / r
    return WheelVelocity(
        right=(body.linear + rim) / robot.wheel_radius,
        left=(body.linear - rim) / robot.wheel_radius,
    )


@jitable
def along_arc(pose: Pose, distance: float, turn: float) -> Pose:
    """
    Compute the pose after an arc: exactly the motion of a constant body velocity.

    Parameters
    ----------
    pose : Pose
        At the arc's start.
    distance : float
        Length of the arc [m], negative backwards.
    turn : float
        Of the heading along it [rad].

    Returns
    -------
    Pose
        At the arc's end; the heading is wrapped.

    Examples
    --------
    >>> along_arc(Pose(1.0, 2.0, 0.0), 0.05, 0.0)
    Pose(x=1.05, y=2.0, heading=0.0)

    """
    half = 0.5 * turn
    # the chord: s sin(Δ/2) / (Δ/2), in the direction of the heading half-way
    chord = distance * (sin(half) / half if abs(half) > _STRAIGHT else 1.0 - half * half / 6.0)
    sine, cosine = sin_cos(pose.heading + half)
    return Pose(
        pose.x + chord * cosine,
        pose.y + chord * sine,
        wrap_angle(pose.heading + turn),
    )


@jitable
def turned_round(reference: Reference) -> Reference:
    """Return a reference whose cart is turned by π: backwards becomes forwards, and forwards backwards."""
    pose, velocity, acceleration = reference
    return Reference(Pose(pose.x, pose.y, wrap_angle(pose.heading + math.pi)),
                     BodyVelocity(-velocity.linear, velocity.angular),
                     BodyAcceleration(-acceleration.linear, acceleration.angular))
