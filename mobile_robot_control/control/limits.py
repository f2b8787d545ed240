"""Limits: of the body velocity command and its change, and of the tracking error and the odometry of a moving robot."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import LARGEST, BodyVelocity


class Limits(NamedTuple):
    """Limits of a command; 0 means none."""

    linear_velocity: Annotated[
        float, Field('m/s', 'limit of the forward and backward velocity, 0 for none: larger lets the robot drive '
                     'faster', minimum=0.0, live=True)
    ] = 0.0
    angular_velocity: Annotated[
        float, Field('rad/s', 'limit of the yaw rate, 0 for none: larger lets the robot turn faster',
                     minimum=0.0, live=True)
    ] = 0.0
    linear_acceleration: Annotated[
        float, Field('m/s²', 'limit of the change of the velocity, 0 for none: larger lets it accelerate harder',
                     minimum=0.0, live=True)
    ] = 0.0
    angular_acceleration: Annotated[
        float, Field('rad/s²', 'limit of the change of the yaw rate, 0 for none: larger lets it turn in sooner',
                     minimum=0.0, live=True)
    ] = 0.0


@jitable
def _within(value: float, before: float, largest: float, step: float) -> float:
    """Limit the slew rate of one component, then its size."""
    if step > 0.0:
        value = min(max(value, before - step), before + step)
    bound = largest if 0.0 < largest < LARGEST else LARGEST
    return min(max(value, -bound), bound)


@jitable
def limit_command(command: BodyVelocity, before: BodyVelocity, limits: Limits, dt: float) -> BodyVelocity:
    """
    Hold a command within the limits, each component by itself.

    Parameters
    ----------
    command : BodyVelocity
        From the law [m/s], [rad/s].
    before : BodyVelocity
        The previous command, after its limits.
    limits : Limits
        A velocity limit takes precedence over an acceleration limit.
    dt : float
        Time between the two commands [s].

    Returns
    -------
    BodyVelocity
        Bit for bit the command of the law if no limit applies; always within the bounds of a message.

    Examples
    --------
    >>> limit_command(BodyVelocity(1.0, 0.1), BodyVelocity(0.0, 0.0), Limits(linear_acceleration=2.0), 0.25)
    BodyVelocity(linear=0.5, angular=0.1)
    """
    return BodyVelocity(
        _within(command.linear, before.linear, limits.linear_velocity, limits.linear_acceleration * dt),
        _within(command.angular, before.angular, limits.angular_velocity, limits.angular_acceleration * dt),
    )


class TrackingLimit(NamedTuple):
    """The limits that stop the robot; `Limits` are those of the command."""

    tracking_error: Annotated[
        float, Field('m', 'wall clock: distance from the reference that stops the robot until its release, 0 for '
                          'none: larger lets it stray farther', minimum=0.0, live=True)
    ] = 0.0
    odom_jump: Annotated[
        float, Field('m', 'wall clock: jump of the pose of odom against its twist that stops a driving robot until '
                          'its release, 0 for none: larger takes larger corrections of a localisation', minimum=0.0,
                     live=True)
    ] = 0.3
    odom_turn: Annotated[
        float, Field('rad', 'wall clock: the same for its heading: larger takes larger corrections', minimum=0.0,
                     live=True)
    ] = 0.5
    localisation_jump: Annotated[
        float, Field('m', 'wall clock: distance by which a correction from path_frame to odom moves the robot at once '
                          'that stops a driving one until its release, 0 for none: larger takes larger corrections',
                     minimum=0.0, live=True)
    ] = 0.5
    localisation_turn: Annotated[
        float, Field('rad', 'wall clock: the same for its heading: larger takes larger corrections', minimum=0.0,
                     live=True)
    ] = 0.5


def allowed_distance(closest: float, limit: float) -> float:
    """
    Return the largest distance from the reference [m] at which the robot keeps driving.

    Parameters
    ----------
    closest : float
        Smallest distance to a cart that waits, since the wait began [m]; 0 while the robot tracks.
    limit : float
        `limits.tracking_error` [m], 0 for none.

    Examples
    --------
    >>> allowed_distance(0.0, 0.5), allowed_distance(1.5, 0.5), allowed_distance(1.5, 0.0)
    (0.5, 2.0, inf)

    """
    return closest + limit if limit > 0.0 else math.inf
