"""Angles on the circle."""

import math

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
    turn = angle % (2.0 * math.pi)
    return turn if turn <= math.pi else turn - 2.0 * math.pi


@jitable
def direction(angle: float) -> tuple[float, float]:
    """
    Return cosine and sine of an angle [rad].

    Both are nan if the angle is not finite, as in compiled code; plain Python would raise.

    Examples
    --------
    >>> direction(0.0)
    (1.0, 0.0)

    """
    if not math.isfinite(angle):
        return math.nan, math.nan
    return math.cos(angle), math.sin(angle)
