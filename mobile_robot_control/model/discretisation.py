"""Discretisation of the equations of motion: exact over one sampling period, under a zero-order hold of the torques."""

import math
from typing import NamedTuple

from mobile_robot_control.model.robot import Robot, angular_inertia, linear_inertia

_OFFSET = 0.5 * math.sqrt(0.6)
QUADRATURE = (0.5 - _OFFSET, 0.5, 0.5 + _OFFSET)
"""Gauss-Legendre quadrature with three points on [0, 1], exact to the fifth power of the period."""


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


def _response(rate: float, time: float) -> Response:
    """Solve x' = u - rate x over a time; a series avoids cancellation at little friction."""
    x = rate * time
    if x > 0.5:
        gain = -math.expm1(-x) / rate
        return Response(math.exp(-x), gain, (time - gain) / rate)
    # (1 - e^-x)/x and (x - 1 + e^-x)/x² as power series, to the last bit for x <= 0.5
    first = math.fsum((-x) ** n / math.factorial(n + 1) for n in range(16))
    second = math.fsum((-x) ** n / math.factorial(n + 2) for n in range(16))
    return Response(math.exp(-x), time * first, time * time * second)


def channel(rate: float, dt: float) -> Channel:
    """Return the responses of a velocity with a decay rate [1/s] at the points within a time [s] and at its end."""
    first, middle, last = QUADRATURE
    return Channel(
        _response(rate, first * dt), _response(rate, middle * dt), _response(rate, last * dt), _response(rate, dt))


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
