"""The limit of the distance between robot and reference, beyond which the robot stops."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.parameters.declaration import Field


class TrackingLimit(NamedTuple):
    """The limit of the position controller that stops the robot; those of the command are `command_limits.Limits`."""

    tracking_error: Annotated[
        float, Field('m', 'wall clock: distance from the reference beyond which the robot stops until it is released, '
                     '0 for none: larger lets it stray farther', minimum=0.0, live=True)
    ] = 0.0


def allowed_distance(closest: float, limit: float) -> float:
    """
    Return the largest distance from the reference [m] at which the robot may go on.

    Parameters
    ----------
    closest : float
        How near the robot has come to a cart that waits, since it did not [m]; 0 while it tracks.
    limit : float
        `limits.tracking_error` [m], 0 for none.

    Examples
    --------
    >>> allowed_distance(0.0, 0.5), allowed_distance(1.5, 0.5), allowed_distance(1.5, 0.0)
    (0.5, 2.0, inf)

    """
    return closest + limit if limit > 0.0 else math.inf
