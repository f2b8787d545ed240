"""The tracking error, and the distance and bearing of the cart from the robot."""

import math

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import atan2, sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.quantities import Pose, TrackingError

_NO_BEARING = 1e-9
"""[m]: at a smaller distance the bearing is rounding noise."""


@jitable
def tracking_error(reference: Pose, pose: Pose) -> TrackingError:
    """
    Compute the reference minus the pose, in the robot's frame.

    Implements Eq. (23) of the chapter.

    Parameters
    ----------
    reference : Pose
        Of the reference cart, in the odometry frame.
    pose : Pose
        Of the robot, in the same frame.

    Returns
    -------
    TrackingError
        e1, e2 [m] and e3 [rad], wrapped.

    Examples
    --------
    >>> tracking_error(Pose(2.0, 1.0, 0.0), Pose(1.0, 1.0, 0.0))
    TrackingError(longitudinal=1.0, lateral=0.0, heading=0.0)

    """
    sin, cos = sin_cos(pose.heading)
    dx, dy = reference.x - pose.x, reference.y - pose.y
    # Eq. (23): e_p = T_p e_q
    return TrackingError(
        cos * dx + sin * dy,
        -sin * dx + cos * dy,
        wrap_angle(reference.heading - pose.heading),
    )


@jitable
def distance(error: TrackingError) -> float:
    """
    Return the distance from the robot to the reference cart [m].

    Implements Eq. (34) of the chapter, i_1.
    """
    # Eq. (34): i1 = sqrt(e1² + e2²); math.hypot rounds otherwise when compiled
    return math.sqrt(error.longitudinal * error.longitudinal + error.lateral * error.lateral)


@jitable
def bearing(error: TrackingError) -> float:
    """
    Return the direction to the reference cart from the robot's heading [rad], in (-π, π].

    Implements Eq. (34) of the chapter, i_2, and the argument of (31) and (33); the wrapped difference atan2(e_y, e_x) -
    θ is atan2(e2, e1). At distances under 1e-9 m the bearing is 0.
    """
    if distance(error) < _NO_BEARING:
        return 0.0
    # Eq. (34), (35): i2 = f(atan2(e_y, e_x) - θ); wrapping makes the -π of a negative zero into π
    return wrap_angle(atan2(error.lateral, error.longitudinal))
