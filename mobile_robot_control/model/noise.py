"""Measurement noise."""

from typing import Annotated, NamedTuple

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import normal
from mobile_robot_control.jit import jitable
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.model.robot import Robot, half_separation
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelVelocity

_MASK = 0xFFFFFFFF
_X, _Y, _HEADING, _RIGHT, _LEFT = 0, 1, 2, 3, 4
RIGHT_SLIP, LEFT_SLIP, COMMAND_JITTER, ODOMETRY_JITTER = 5, 6, 7, 8
"""Channels of other random effects."""


class Noise(NamedTuple):
    """Standard deviations of the measurement noise; 0 means none."""

    pose: Annotated[
        tuple[float, ...],
        Field('m, m, rad', 'standard deviations of the noise on the pose of odom, x, y, yaw: larger makes the commands '
              'rougher', minimum=0.0, length=3)
    ] = (0.0, 0.0, 0.0)
    velocity: Annotated[
        float, Field('rad/s', "standard deviation of the noise on each wheel's velocity, and so on odom's twist: "
                     'larger makes the torques rougher', minimum=0.0)
    ] = 0.0
    seed: Annotated[int, Field('', 'seed of the noise: the same seed gives the same noise',
                               minimum=0, maximum=_MASK)] = 0


@jitable
def _scrambled(x: int) -> int:
    """Hash 32 bits to 32 bits, one to one; products may wrap at 64 bits, only the lower half counts."""
    x = ((x ^ (x >> 16)) * 0x7FEB352D) & _MASK
    x = ((x ^ (x >> 15)) * 0x846CA68B) & _MASK
    return x ^ (x >> 16)


@jitable
def _hashed(seed: int, channel: int, k: int) -> int:
    """Return the k-th number of a sequence, of 32 bits."""
    return _scrambled((_scrambled((_scrambled(seed & _MASK) + k) & _MASK) + 2 * channel) & _MASK)


@jitable
def gaussian(seed: int, channel: int, k: int) -> float:
    """
    Return one number of a standard normal sequence: a function of its index, so a repeated call changes nothing.

    Uses Box and Muller's transform of two hashed numbers.

    Parameters
    ----------
    seed, channel : int
        Select the sequence.
    k : int
        Index in the sequence: the step of the velocity loop.
    """
    place = _hashed(seed, channel, k)
    # never 0, where the logarithm is not finite
    first = (place + 0.5) / 4294967296.0
    second = _scrambled((place + 1) & _MASK) / 4294967296.0
    return normal(first, second)


@jitable
def jitter(seed: int, channel: int, n: int, longest: int) -> int:
    """Return the delay of the n-th of some events: a whole number from 0 to the longest, uniformly distributed."""
    return _hashed(seed, channel, n) * (longest + 1) >> 32


@jitable
def measured_pose(pose: Pose, noise: Noise, k: int) -> Pose:
    """Return the pose of odometry at step k of the velocity loop: bit for bit the true one without noise."""
    x, y, heading = noise.pose
    if x == 0.0 and y == 0.0 and heading == 0.0:
        return pose
    return Pose(
        pose.x + x * gaussian(noise.seed, _X, k),
        pose.y + y * gaussian(noise.seed, _Y, k),
        wrap_angle(pose.heading + heading * gaussian(noise.seed, _HEADING, k)),
    )


@jitable
def measured_wheels(wheels: WheelVelocity, noise: Noise, k: int) -> WheelVelocity:
    """Return the encoders' wheel velocities at step k: bit for bit the true ones without noise."""
    if noise.velocity == 0.0:
        return wheels
    return WheelVelocity(
        wheels.right + noise.velocity * gaussian(noise.seed, _RIGHT, k),
        wheels.left + noise.velocity * gaussian(noise.seed, _LEFT, k),
    )


@jitable
def measured_twist(velocity: BodyVelocity, wheels: WheelVelocity, noise: Noise, robot: Robot) -> BodyVelocity:
    """
    Return the twist of odometry: that of the measured wheels, bit for bit the true one without noise.

    Parameters
    ----------
    velocity : BodyVelocity
        The true velocity.
    wheels : WheelVelocity
        Measured at the same time.
    noise : Noise
        Decides whether there is noise at all.
    robot : Robot
        Physical constants.
    """
    return velocity if noise.velocity == 0.0 else body_velocity(wheels, robot)


def pose_variances(noise: Noise) -> tuple[float, ...]:
    """Return the diagonal of the noise covariance of odom's pose: x, y, z [m²] and rotations [rad²]."""
    x, y, heading = noise.pose
    return (x * x, y * y, 0.0, 0.0, 0.0, heading * heading)


def twist_variances(noise: Noise, robot: Robot) -> tuple[float, ...]:
    """
    Return the diagonal of the covariance of odom's twist due to noise on the wheels [m²/s²], [rad²/s²].

    Follows from Eq. (5)-(7) of the chapter, v = r/2 (ω_R + ω_L), ω = r/(2R) (ω_R - ω_L), which are uncorrelated.
    """
    r, R = robot.wheel_radius, half_separation(robot)
    linear = 0.5 * (r * noise.velocity) * (r * noise.velocity)
    return (linear, 0.0, 0.0, 0.0, 0.0, linear / (R * R))
