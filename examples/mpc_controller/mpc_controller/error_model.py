"""The tracking error as a linear system, exact over a stage on which the reference velocity is held."""

import math

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


def _sinc(x: float) -> float:
    """Return sin x / x; the series where that would divide by nothing."""
    return 1.0 - x * x / 6.0 if abs(x) < 1e-4 else math.sin(x) / x


def _ramp(x: float) -> float:
    """Return (x - sin x) / x²; the series where the difference would lose its digits."""
    return x / 6.0 * (1.0 - x * x / 20.0) if abs(x) < 1e-2 else (x - math.sin(x)) / (x * x)


def error_model(v_r: float, omega_r: float, period: float) -> tuple[Matrix, Matrix]:
    """
    Return A and B of e(k+1) = A e(k) + B u(k) along a reference that keeps its velocity.

    The tracking error of Eq. (24) of the chapter, linearised at e = 0 and u = 0, where u = (v_r cos e3 - v, ω_r - ω)::

        ė1 =  ω_r e2       + u1
        ė2 = -ω_r e1 + v_r e3
        ė3 =                 u2

    Parameters
    ----------
    v_r, omega_r : float
        Of the reference [m/s], [rad/s].
    period : float
        Of a stage, over which u is held [s].

    Returns
    -------
    array, shape (3, 3), and array, shape (3, 2)
        The solution over the period; no step is too long for it.

    """
    x, way = omega_r * period, v_r * period
    half = _sinc(0.5 * x)
    # (1 - cos x) / x² without a difference of numbers that are nearly equal
    turned = 0.5 * half * half
    sinc, cos, sin = _sinc(x), math.cos(x), math.sin(x)
    return (
        np.array([[cos, sin, way * x * turned], [-sin, cos, way * sinc], [0.0, 0.0, 1.0]]),
        np.array([[period * sinc, way * period * _ramp(x)], [-period * x * turned, way * period * turned],
                  [0.0, period]]),
    )
