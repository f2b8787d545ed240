"""
The quantities of the domain: the arguments and results of this package's functions; and the grid of stamps.

All are in SI units. The chapter's symbols stand behind each field.
"""

from typing import NamedTuple

LARGEST = 1e12
"""In SI units, beyond any robot. Larger parameters and messages are refused, and nothing larger is sent."""
SMALLEST = 1.0 / LARGEST
"""In SI units: the least positive value, since it divides."""
WALL = 10**15
"""[ns]: eleven days; later stamps come from a wall clock, not from a run."""


class Pose(NamedTuple):
    """
    Position of the axle's centre (point A) and heading, in the odometry frame.

    Attributes
    ----------
    x, y : float
        Position [m].
    heading : float
        Angle from the frame's x axis to the robot's, θ [rad].

    """

    x: float
    y: float
    heading: float


class BodyVelocity(NamedTuple):
    """
    Velocity of point A in the robot's own frame.

    Attributes
    ----------
    linear : float
        Forward velocity, v [m/s].
    angular : float
        Yaw rate, ω [rad/s], counter-clockwise positive.

    """

    linear: float
    angular: float


class BodyAcceleration(NamedTuple):
    """
    Rate of change of a body velocity.

    Attributes
    ----------
    linear : float
        dv/dt [m/s²].
    angular : float
        dω/dt [rad/s²].

    """

    linear: float
    angular: float


NO_ACCELERATION = BodyAcceleration(0.0, 0.0)
"""Of a reference with constant velocity, or without a user of its acceleration."""


class WheelVelocity(NamedTuple):
    """
    Angular velocities of the driving wheels.

    Attributes
    ----------
    right, left : float
        ω_R and ω_L [rad/s], positive forwards.

    """

    right: float
    left: float


class Push(NamedTuple):
    """
    A push at point A, in the robot's own frame.

    Attributes
    ----------
    force : float
        Forwards [N].
    torque : float
        About the vertical [N m], counter-clockwise positive.

    """

    force: float
    torque: float


class WheelTorque(NamedTuple):
    """
    Torques at the axle of the driving wheels.

    Attributes
    ----------
    right, left : float
        τ_R and τ_L [N m], positive forwards.

    """

    right: float
    left: float


UNKNOWN_TORQUE = WheelTorque(float('nan'), float('nan'))
"""Of a base that takes velocity commands, and where no torque is told."""


class Reference(NamedTuple):
    """
    The reference cart at one time.

    Attributes
    ----------
    pose : Pose
        x_r, y_r [m] and θ_r [rad].
    velocity : BodyVelocity
        v_r [m/s] and ω_r [rad/s].
    acceleration : BodyAcceleration
        dv_r/dt [m/s²] and dω_r/dt [rad/s²]; zero where `reference_horizon` is 0.
    """

    pose: Pose
    velocity: BodyVelocity
    acceleration: BodyAcceleration = NO_ACCELERATION


class TrackingError(NamedTuple):
    """
    Reference minus pose, in the robot's own frame.

    Attributes
    ----------
    longitudinal : float
        e1 [m], positive when the cart is ahead.
    lateral : float
        e2 [m], positive when the cart is to the left.
    heading : float
        e3 [rad], wrapped into (-π, π].

    """

    longitudinal: float
    lateral: float
    heading: float


class Truth(NamedTuple):
    """
    The true motion of a robot, beside the motion that odometry shows.

    Attributes
    ----------
    pose : Pose
        In the odometry frame [m], [rad].
    velocity : BodyVelocity
        [m/s], [rad/s].
    error : TrackingError
        Tracking error of the true pose, e1, e2 [m], e3 [rad].

    """

    pose: Pose
    velocity: BodyVelocity
    error: TrackingError


class Observation(NamedTuple):
    """
    The input of a position law: no absolute pose, so every law is invariant under motions of the plane.

    Attributes
    ----------
    error : TrackingError
        e1, e2 [m], e3 [rad].
    reference : Reference
        Of the cart: v_r [m/s] and ω_r [rad/s] are its velocity.
    velocity : BodyVelocity
        Twist of odometry, v [m/s] and ω [rad/s].
    horizon : tuple of Reference
        Of the cart at the next `reference_horizon` position ticks.

    """

    error: TrackingError
    reference: Reference
    velocity: BodyVelocity
    horizon: tuple[Reference, ...] = ()


FASTEST = 1e5
"""Highest rate of a loop [Hz]; above it rounding spoils the stability check of the velocity loop."""
NANOSECONDS = 1_000_000_000
"""Nanoseconds in one second."""


def period_nanoseconds(rate: float) -> int:
    """Return the period [ns] of a rate [Hz] whose period is whole nanoseconds."""
    return round(NANOSECONDS / rate)
