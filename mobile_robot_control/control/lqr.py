"""The linear-quadratic law: time-varying, with gains scheduled over the cart's velocity."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.control.ramsete import sinc
from mobile_robot_control.control.riccati import Matrix, diagonal, optimal_feedback
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation

SPEEDS = (0.05, 0.08, 0.13, 0.22, 0.4, 0.7, 1.2)
"""|v_r| of the table's rows [m/s]."""
TURNS = (0.0, 0.015, 0.035, 0.07, 0.13, 0.25, 0.5, 1.0, 2.0)
"""|ω_r| of the table's columns [rad/s]: at small speeds the gains change most within 0.1 rad/s."""

Feedback = tuple[float, float, float, float, float, float]
"""K by rows: of the forward velocity by e1, e2, e3, then of the yaw rate."""
Schedule = tuple[tuple[Feedback, ...], ...]
"""Feedback by speed and turn."""


class LqrWeights(NamedTuple):
    """Weights of the errors in the minimised sum; both velocities have the weights 1 s²/m² and 1 s²/rad²."""

    q1: Annotated[
        float, Field('1/m²', 'weight of the longitudinal error: larger closes the gap ahead sooner and asks for more '
                     'torque', minimum=1e-3, maximum=1e6, live=True, search=(1e-3, 40.0))
    ] = 0.762509
    q2: Annotated[
        float, Field('1/m²', 'weight of the lateral error: larger turns harder towards the path', minimum=1e-3,
                     maximum=1e6, live=True, search=(1e-3, 200.0))
    ] = 5.92373
    q3: Annotated[
        float, Field('1/rad²', 'weight of the heading error: larger turns harder against it, and less towards the '
                     'path', minimum=1e-3, maximum=1e6, live=True, search=(1e-3, 40.0))
    ] = 3.11001


def error_dynamics(v_r: float, omega_r: float, dt: float) -> tuple[Matrix, Matrix]:
    """
    Discretise the error dynamics (24), linearised about the cart, exactly for inputs held over a period.

    Parameters
    ----------
    v_r, omega_r : float
        Velocity of the cart [m/s], [rad/s].
    dt : float
        Period [s].

    Returns
    -------
    tuple of tuple of tuple of float
        Φ, shape (3, 3), and Γ, shape (3, 2), of e⁺ = Φ e + Γ u with u = (v_r cos e3 - v, ω_r - ω).

    """
    # de1/dt = ω_r e2 + u1, de2/dt = -ω_r e1 + v_r e3, de3/dt = u2
    angle = omega_r * dt
    cos, sin = math.cos(angle), math.sin(angle)
    # ∫∫ sin ω_r t over the period; the series where the quotient would cancel, exact to 1e-14 there
    drift = (angle - sin) / (omega_r * omega_r) if abs(angle) > 1e-2 else (
        dt * dt * angle * (1.0 / 6.0 - angle * angle / 120.0))
    # ∫ cos ω_r t, ∫ sin ω_r t and ∫∫ cos ω_r t; 1 - cos x = 2 sin² (x / 2) does not cancel
    half = dt * sinc(0.5 * angle)
    along, across, shift = dt * sinc(angle), 0.5 * omega_r * half * half, 0.5 * half * half
    return (
        ((cos, sin, v_r * across), (-sin, cos, v_r * along), (0.0, 0.0, 1.0)),
        ((along, v_r * drift), (-across, v_r * shift), (0.0, dt)),
    )


def feedback(weights: LqrWeights, v_r: float, omega_r: float, dt: float) -> Matrix:
    """Return the gains K, shape (2, 3), of u = -K e at one velocity [m/s], [rad/s] of the cart, for a period [s]."""
    # a sum over periods: both weights have the same factor dt, which cancels
    return optimal_feedback(*error_dynamics(v_r, omega_r, dt), diagonal(weights), diagonal((1.0, 1.0)))


def prepare(weights: LqrWeights, dt: float) -> Schedule:
    """Return the schedule: the feedback at each pair of SPEEDS and TURNS, for a period [s]."""
    return tuple(
        tuple(tuple(gain for row in feedback(weights, v_r, omega_r, dt) for gain in row) for omega_r in TURNS)  # type: ignore[misc]
        for v_r in SPEEDS)


@jitable
def below(value: float, nodes: tuple[float, ...]) -> int:
    """Return the index of the interval of nodes that contains a value; beyond them, the last interval."""
    n = 0
    while n < len(nodes) - 2 and value > nodes[n + 1]:
        n += 1
    return n


@jitable
def share(value: float, low: float, high: float) -> float:
    """Return the position of a value between low and high, as a share within 0 and 1."""
    return max(0.0, min(1.0, (value - low) / (high - low)))


@jitable
def step(state: NoState, observation: Observation, gains: Schedule, dt: float) -> tuple[NoState, BodyVelocity]:
    """
    Compute the body velocity that is optimal for the error dynamics, linearised about the cart at its velocity.

    The linear-quadratic regulator, see [1]_, of the linearised error dynamics of [2]_, scheduled over the cart's
    velocity by bilinear interpolation in a table.

    Parameters
    ----------
    state : NoState
        Returned unchanged.
    observation : Observation
        e1, e2 [m], e3 [rad], v_r [m/s] and ω_r [rad/s] are used.
    gains : tuple of tuple of tuple of float
        Result of `prepare`, shape (7, 9, 6).
    dt : float
        Not used: the law is static, and `prepare` has used the period.

    Returns
    -------
    tuple of NoState and BodyVelocity
        The command [m/s], [rad/s].

    Notes
    -----
    The table covers v_r and ω_r >= 0: the other signs follow from mirror symmetry and from driving in reverse. Beyond
    the table its edge holds. Within it the gains are those of the equation to 5 % of the largest one for the default
    weights. At e3 = π the turn changes its side, because the heading error does.

    References
    ----------
    .. [1] B. D. O. Anderson and J. B. Moore, *Optimal Control: Linear Quadratic Methods*, Prentice Hall, 1990.
    .. [2] A. De Luca, G. Oriolo and M. Vendittelli, "Control of wheeled mobile robots: an experimental overview", in
       Ramsete, Lecture Notes in Control and Information Sciences 270, Springer, 2001, pp. 181-226.

    """
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    speed, turn = abs(v_r), abs(omega_r)
    n, m = below(speed, SPEEDS), below(turn, TURNS)
    x, y = share(speed, SPEEDS[n], SPEEDS[n + 1]), share(turn, TURNS[m], TURNS[m + 1])
    a, b, c, d = gains[n][m], gains[n][m + 1], gains[n + 1][m], gains[n + 1][m + 1]
    at_a, at_b, at_c, at_d = (1.0 - x) * (1.0 - y), (1.0 - x) * y, x * (1.0 - y), x * y
    # beside a standing cart no feedback reduces e2, and the equation has no solution: terms odd in v_r fade out there
    way = v_r / max(speed, SPEEDS[0])
    side = math.copysign(1.0, omega_r)
    k11 = at_a * a[0] + at_b * b[0] + at_c * c[0] + at_d * d[0]
    k12 = side * (at_a * a[1] + at_b * b[1] + at_c * c[1] + at_d * d[1])
    k13 = side * way * (at_a * a[2] + at_b * b[2] + at_c * c[2] + at_d * d[2])
    k21 = side * way * (at_a * a[3] + at_b * b[3] + at_c * c[3] + at_d * d[3])
    k22 = way * (at_a * a[4] + at_b * b[4] + at_c * c[4] + at_d * d[4])
    k23 = at_a * a[5] + at_b * b[5] + at_c * c[5] + at_d * d[5]
    return state, BodyVelocity(
        # u = -K e: v = v_r cos e3 + k11 e1 + k12 e2 + k13 e3
        v_r * math.cos(e3) + (k11 * e1 + k12 * e2 + k13 * e3),
        # ω = ω_r + k21 e1 + k22 e2 + k23 e3
        omega_r + (k21 * e1 + k22 * e2 + k23 * e3),
    )


LAW = Law('lqr', step, LqrWeights, prepare=prepare)
