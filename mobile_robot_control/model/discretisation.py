"""Exact discretisation over one sampling period: of the robot under held torques, and of x' = u - a x."""

import math
from typing import NamedTuple

from mobile_robot_control.elementary import exp
from mobile_robot_control.jit import jitable_apart
from mobile_robot_control.model.robot import Robot, angular_inertia, linear_inertia

_OFFSET = 0.5 * math.sqrt(0.6)
QUADRATURE = (0.5 - _OFFSET, 0.5, 0.5 + _OFFSET)
"""Gauss-Legendre quadrature with three points on [0, 1], exact to the fifth power of the period."""

_SMALL = 0.5
_NEGLIGIBLE = 1e-18


class Response(NamedTuple):
    """
    Coefficients of the exact solution of x' = u - a x over a time t with u held.

    Attributes
    ----------
    decay : float
        x(t) = decay x(0) + gain u.
    gain : float
        Also ∫ x dt = gain x(0) + travel u [s].
    travel : float
        [s²].
    """

    decay: float
    gain: float
    travel: float


class Channel(NamedTuple):
    """The response of the linear or the angular velocity at the three quadrature points and at the period's end."""

    first: Response
    middle: Response
    last: Response
    end: Response


class DiscretePlant(NamedTuple):
    """
    The plant discretised for one sampling period.

    Attributes
    ----------
    robot : Robot
        Physical constants.
    linear, angular : Channel
        Exact responses of v and ω.
    dt : float
        Sampling period [s].
    centripetal_coupling : bool
        Whether to include the Coriolis pair, which Eq. (13)-(14) lack.
    """

    robot: Robot
    linear: Channel
    angular: Channel
    dt: float
    centripetal_coupling: bool


@jitable_apart
def held_response(rate: float, time: float) -> Response:
    """
    Return the response to a held u over a time [s], for a rate a >= 0 [1/s].

    Accurate to some 1e-15 of each coefficient.
    """
    x = rate * time
    if x > _SMALL:
        decay = exp(-x)
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
def channel(rate: float, dt: float) -> Channel:
    """Return the responses of a velocity with a decay rate [1/s] at the points within a time [s] and at its end."""
    first, middle, last = QUADRATURE
    return Channel(
        held_response(rate, first * dt), held_response(rate, middle * dt), held_response(rate, last * dt),
        held_response(rate, dt))


@jitable_apart
def discretise(robot: Robot, dt: float, centripetal_coupling: bool = False) -> DiscretePlant:
    """
    Discretise the plant for steps of one sampling period.

    Solves Eq. (13)-(14) of the chapter, which decouple in v and ω, under a zero-order hold of the torques.

    Parameters
    ----------
    robot : Robot
        Physical constants.
    dt : float
        Sampling period [s], positive.
    centripetal_coupling : bool
        Whether to include the Coriolis pair, which the chapter's Lagrangian lacks.

    Returns
    -------
    DiscretePlant
        For `dynamics.step`.
    """
    K = robot.viscous_friction
    return DiscretePlant(
        robot,
        # (13) + (14): (A+B) dv/dt = r/2 (τ_R + τ_L) - K v
        channel(K / linear_inertia(robot), dt),
        # (13) - (14): (A-B) dω/dt = r/(2R) (τ_R - τ_L) - K ω
        channel(K / angular_inertia(robot), dt),
        dt,
        centripetal_coupling,
    )


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
        gain = (exp(-y) - exp(-x)) / (rate - fading)
    else:
        # sinh(z)/z as a power series
        square, series = half * half, 1.0
        for n in range(12, 0, -2):
            series = 1.0 + square * series / (n * (n + 1.0))
        gain = time * exp(-0.5 * (x + y)) * series
    # x' = u e^(-b t) - a x, integrated, and the same with a and b exchanged
    if x > y:
        return FadingResponse(gain, (held_response(fading, time).gain - gain) / rate)
    return FadingResponse(gain, (held_response(rate, time).gain - gain) / fading)
