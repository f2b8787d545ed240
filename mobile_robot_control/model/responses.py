"""The exact solution of x' = u - a x over any time, for held and fading u."""

import math
from typing import NamedTuple

from mobile_robot_control.jit import jitable_apart
from mobile_robot_control.model.discretisation import Response

_SMALL = 0.5
_NEGLIGIBLE = 1e-18


class FadingResponse(NamedTuple):
    """
    Coefficients of the exact solution of x' = u exp(-b t) - a x from x(0) = 0.

    Attributes
    ----------
    gain : float
        x(t) = gain u [s].
    travel : float
        ∫ x dt = travel u [s²].
    """

    gain: float
    travel: float


@jitable_apart
def held_response(rate: float, time: float) -> Response:
    """
    Return the response to a held u over a time [s], for a rate a >= 0 [1/s].

    Accurate to some 1e-15 of each coefficient, like `discretisation.discretise`; this form can be compiled.
    """
    x = rate * time
    if x > _SMALL:
        decay = math.exp(-x)
        gain = (1.0 - decay) / rate
        return Response(decay, gain, (time - gain) / rate)
    # (x - 1 + e^-x)/x² as a power series
    second = term = 0.5
    for n in range(3, 18):
        term *= -x / n
        second += term
        if abs(term) < _NEGLIGIBLE:
            break
    first = 1.0 - x * second
    return Response(1.0 - x * first, time * first, time * time * second)


@jitable_apart
def fading_response(rate: float, fading: float, time: float) -> FadingResponse:
    """
    Return the response to a fading u over a time [s], for rates a >= 0 and b >= 0 [1/s], which may be equal.

    The coefficients are divided differences of the exponential function: t exp[-a t, -b t] and
    t² exp[0, -a t, -b t]. Accurate to some 1e-15 of each.
    """
    x, y = rate * time, fading * time
    if x <= _SMALL and y <= _SMALL:
        # exp[0, -x, -y] = Σ (-1)^n h_n(x, y) / (n + 2)! with h_n = Σ x^i y^(n-i)
        second = factor = 0.5
        power = products = 1.0
        for n in range(1, 16):
            power *= y
            products = x * products + power
            factor /= -(n + 2.0)
            second += factor * products
            if abs(factor * products) < _NEGLIGIBLE:
                break
        travel = time * time * second
        return FadingResponse(held_response(fading, time).gain - rate * travel, travel)
    half = 0.5 * (x - y)
    if abs(half) > _SMALL:
        gain = (math.exp(-y) - math.exp(-x)) / (rate - fading)
    else:
        # sinh(z)/z as a power series
        square, series = half * half, 1.0
        for n in range(12, 0, -2):
            series = 1.0 + square * series / (n * (n + 1.0))
        gain = time * math.exp(-0.5 * (x + y)) * series
    # x' = u e^(-b t) - a x, integrated, and the same with a and b exchanged
    if x > y:
        return FadingResponse(gain, (held_response(fading, time).gain - gain) / rate)
    return FadingResponse(gain, (held_response(rate, time).gain - gain) / fading)
