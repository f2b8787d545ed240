"""What stops the robot until its release: its distance from the reference, and jumps of its odometry."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.parameters.declaration import Field


class TrackingLimit(NamedTuple):
    """The limits that stop the robot; `command_limits.Limits` are those of the command."""

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
