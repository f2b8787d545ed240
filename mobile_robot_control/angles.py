"""Angles on the circle."""

import math

from mobile_robot_control.elementary.circular import folded
from mobile_robot_control.jit import jitable


@jitable
def wrap_angle(angle: float) -> float:
    """
    Wrap an angle into (-π, π].

    Implements Eq. (35) of the chapter, f(x) = 2 atan(tan(x/2)), without its loss of precision near ±π.

    Parameters
    ----------
    angle : float
        Any finite angle [rad].

    Returns
    -------
    float
        The same direction [rad] in (-π, π]; an angle already inside is returned unchanged, bit for bit.

    Examples
    --------
    >>> wrap_angle(-math.pi) == math.pi
    True

    """
    if -math.pi < angle <= math.pi:
        return angle
    turn = angle if abs(angle) < 3.0 * math.pi else folded(angle)
    return turn - 2.0 * math.pi if turn > math.pi else turn + 2.0 * math.pi if turn <= -math.pi else turn
