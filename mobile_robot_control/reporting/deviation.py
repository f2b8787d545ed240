"""The error along the path: by how much the robot is beside the cart, at each place of the cart."""

from typing import NamedTuple

import numpy as np

from mobile_robot_control.reporting.lines import Floats
from mobile_robot_control.reporting.series import Series

_POINTS = 4000


class Deviation(NamedTuple):
    """
    Where the cart is and how far the robot is from it: arrays of shape (n,).

    Attributes
    ----------
    time : array
        [s]
    x, y : array
        Place of the cart [m].
    x_error, y_error : array
        Place of the robot minus that of the cart [m], in the axes of the odometry frame.
    """

    time: Floats
    x: Floats
    y: Floats
    x_error: Floats
    y_error: Floats


def deviation(series: Series) -> Deviation:
    """
    Return where the robot is relative to the cart, at most at some thousand times, evenly.

    The cart is taken to be on straight lines between its messages, and before the first and after the last there is
    nothing. The robot's place is the true one where that is known.
    """
    cart = series.time('reference')
    if not cart.size:
        return Deviation(*[np.zeros(0)] * 5)
    time = series.time(series.motion)
    during = np.nonzero((time >= cart[0]) & (time <= cart[-1]))[0]
    chosen = during[np.linspace(0, during.size - 1, min(during.size, _POINTS)).astype(int)]
    places = [np.interp(time[chosen], cart, series.line('reference', axis).value) for axis in 'xy']
    errors = [series.line(series.motion, axis).value[chosen] - place for axis, place in zip('xy', places, strict=True)]
    return Deviation(time[chosen], *places, *errors)
