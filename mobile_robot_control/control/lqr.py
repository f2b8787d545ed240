"""
The linear-quadratic law: time-varying, with gains scheduled over the cart's velocity.

The discrete algebraic Riccati equation of three states is solved in plain Python: nodes import no SciPy.
"""

import math
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.control.ramsete import sinc
from mobile_robot_control.elementary import cos, sin_cos
from mobile_robot_control.jit import jitable, jitable_apart
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation

Matrix = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
"""Rows."""
Inputs = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
"""Rows of a matrix of two columns."""
_DOUBLINGS = 60
"""More than any loop needs that settles within 1e15 periods."""
_SETTLED = 1e-14
"""Relative change of the largest element."""
_IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


# Written out for three states and two inputs: a compiler takes it, and a search solves 63 equations a candidate.


@jitable
def _product(a: Matrix, b: Matrix) -> Matrix:
    (a11, a12, a13), (a21, a22, a23), (a31, a32, a33) = a
    (b11, b12, b13), (b21, b22, b23), (b31, b32, b33) = b
    return ((a11 * b11 + a12 * b21 + a13 * b31, a11 * b12 + a12 * b22 + a13 * b32, a11 * b13 + a12 * b23 + a13 * b33),
            (a21 * b11 + a22 * b21 + a23 * b31, a21 * b12 + a22 * b22 + a23 * b32, a21 * b13 + a22 * b23 + a23 * b33),
            (a31 * b11 + a32 * b21 + a33 * b31, a31 * b12 + a32 * b22 + a33 * b32, a31 * b13 + a32 * b23 + a33 * b33))


@jitable
def _sum(a: Matrix, b: Matrix) -> Matrix:
    (a11, a12, a13), (a21, a22, a23), (a31, a32, a33) = a
    (b11, b12, b13), (b21, b22, b23), (b31, b32, b33) = b
    return ((a11 + b11, a12 + b12, a13 + b13), (a21 + b21, a22 + b22, a23 + b23), (a31 + b31, a32 + b32, a33 + b33))


@jitable
def _transpose(a: Matrix) -> Matrix:
    (a11, a12, a13), (a21, a22, a23), (a31, a32, a33) = a
    return (a11, a21, a31), (a12, a22, a32), (a13, a23, a33)


@jitable_apart
def _solution(a: Matrix, b: Matrix, c: Matrix) -> tuple[Matrix, Matrix]:
    """Solve a x = b and a y = c by elimination with the largest pivot of each column; a must not be singular."""
    # a row becomes shorter, column by column
    rows: Any = a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]
    p, q, r = rows
    if abs(r[0]) > abs(p[0]) and abs(r[0]) > abs(q[0]):
        p, r = r, p
    elif abs(q[0]) > abs(p[0]):
        p, q = q, p
    # a column that is eliminated is read no more
    by, p1, p2, p3, p4, p5, p6, p7, p8 = p
    p1, p2, p3, p4, p5, p6, p7, p8 = p1 / by, p2 / by, p3 / by, p4 / by, p5 / by, p6 / by, p7 / by, p8 / by
    by, q1, q2, q3, q4, q5, q6, q7, q8 = q
    q = (q1 - by * p1, q2 - by * p2, q3 - by * p3, q4 - by * p4, q5 - by * p5, q6 - by * p6, q7 - by * p7, q8 - by * p8)
    by, r1, r2, r3, r4, r5, r6, r7, r8 = r
    r = (r1 - by * p1, r2 - by * p2, r3 - by * p3, r4 - by * p4, r5 - by * p5, r6 - by * p6, r7 - by * p7, r8 - by * p8)
    if abs(r[0]) > abs(q[0]):
        q, r = r, q
    by, q2, q3, q4, q5, q6, q7, q8 = q
    q2, q3, q4, q5, q6, q7, q8 = q2 / by, q3 / by, q4 / by, q5 / by, q6 / by, q7 / by, q8 / by
    p2, p3, p4, p5, p6, p7, p8 = (p2 - p1 * q2, p3 - p1 * q3, p4 - p1 * q4, p5 - p1 * q5, p6 - p1 * q6, p7 - p1 * q7,
                                  p8 - p1 * q8)
    r1, r2, r3, r4, r5, r6, r7, r8 = r
    by = r2 - r1 * q2
    r3, r4, r5 = (r3 - r1 * q3) / by, (r4 - r1 * q4) / by, (r5 - r1 * q5) / by
    r6, r7, r8 = (r6 - r1 * q6) / by, (r7 - r1 * q7) / by, (r8 - r1 * q8) / by
    return (((p3 - p2 * r3, p4 - p2 * r4, p5 - p2 * r5), (q3 - q2 * r3, q4 - q2 * r4, q5 - q2 * r5), (r3, r4, r5)),
            ((p6 - p2 * r6, p7 - p2 * r7, p8 - p2 * r8), (q6 - q2 * r6, q7 - q2 * r7, q8 - q2 * r8), (r6, r7, r8)))


@jitable
def _largest(a: Matrix) -> float:
    (a11, a12, a13), (a21, a22, a23), (a31, a32, a33) = a
    return max(abs(a11), abs(a12), abs(a13), abs(a21), abs(a22), abs(a23), abs(a31), abs(a32), abs(a33))


@jitable_apart
def riccati(a: Matrix, b: Inputs, q: tuple[float, float, float]) -> Matrix:
    """
    Return the stabilising solution X of X = Aᵀ X A - Aᵀ X B (I + Bᵀ X B)⁻¹ Bᵀ X A + Q.

    Iterates the Riccati difference equation from Q in steps that double, as the structure-preserving doubling
    algorithm of [1]_: the n-th iterate is that of 2ⁿ steps of value iteration.

    Parameters
    ----------
    a, b : tuple of tuple of float
        Of x⁺ = A x + B u, shapes (3, 3) and (3, 2); stabilisable.
    q : tuple of float
        The diagonal of Q, positive.

    Returns
    -------
    tuple of tuple of float
        X, shape (3, 3).

    Raises
    ------
    ValueError
        If the iteration does not settle, for example if the system cannot be stabilised.

    References
    ----------
    .. [1] E. K.-W. Chu, H.-Y. Fan, W.-W. Lin and C.-S. Wang, "Structure-preserving algorithms for periodic
       discrete-time algebraic Riccati equations", International Journal of Control 77, 2004, pp. 767-788.

    """
    (b11, b12), (b21, b22), (b31, b32) = b
    g = ((b11 * b11 + b12 * b12, b11 * b21 + b12 * b22, b11 * b31 + b12 * b32),
         (b21 * b11 + b22 * b12, b21 * b21 + b22 * b22, b21 * b31 + b22 * b32),
         (b31 * b11 + b32 * b12, b31 * b21 + b32 * b22, b31 * b31 + b32 * b32))
    h = ((q[0], 0.0, 0.0), (0.0, q[1], 0.0), (0.0, 0.0, q[2]))
    for _ in range(_DOUBLINGS):
        # (I + G H)⁻¹ A and (I + G H)⁻¹ G
        w_a, w_g = _solution(_sum(_IDENTITY, _product(g, h)), a, g)
        # H⁺ = H + Aᵀ H (I + G H)⁻¹ A
        a_t = _transpose(a)
        change = _product(a_t, _product(h, w_a))
        h = _sum(h, change)
        largest = _largest(h)
        if not math.isfinite(largest):
            break
        if _largest(change) <= _SETTLED * largest:
            return h
        # G⁺ = G + A (I + G H)⁻¹ G Aᵀ, A⁺ = A (I + G H)⁻¹ A
        g, a = _sum(g, _product(_product(a, w_g), a_t)), _product(a, w_a)
    raise ValueError('the Riccati equation has no stabilising solution that the iteration finds')


@jitable_apart
def optimal_feedback(a: Matrix, b: Inputs, q: tuple[float, float, float]) -> 'Feedback':
    """
    Return the gains K of u = -K x that minimise the sum of xᵀ Q x + uᵀ u, by rows.

    Parameters and errors as in `riccati`.
    """
    (b11, b12), (b21, b22), (b31, b32) = b
    (x11, x12, x13), (x21, x22, x23), (x31, x32, x33) = riccati(a, b, q)
    (a11, a12, a13), (a21, a22, a23), (a31, a32, a33) = a
    # Bᵀ X
    p1, p2, p3 = (b11 * x11 + b21 * x21 + b31 * x31, b11 * x12 + b21 * x22 + b31 * x32,
                  b11 * x13 + b21 * x23 + b31 * x33)
    r1, r2, r3 = (b12 * x11 + b22 * x21 + b32 * x31, b12 * x12 + b22 * x22 + b32 * x32,
                  b12 * x13 + b22 * x23 + b32 * x33)
    # I + Bᵀ X B, which is symmetric and positive definite, and Bᵀ X A
    m11, m12 = 1.0 + (p1 * b11 + p2 * b21 + p3 * b31), p1 * b12 + p2 * b22 + p3 * b32
    m21, m22 = r1 * b11 + r2 * b21 + r3 * b31, 1.0 + (r1 * b12 + r2 * b22 + r3 * b32)
    n11, n12, n13 = (p1 * a11 + p2 * a21 + p3 * a31, p1 * a12 + p2 * a22 + p3 * a32, p1 * a13 + p2 * a23 + p3 * a33)
    n21, n22, n23 = (r1 * a11 + r2 * a21 + r3 * a31, r1 * a12 + r2 * a22 + r3 * a32, r1 * a13 + r2 * a23 + r3 * a33)
    # K = (I + Bᵀ X B)⁻¹ Bᵀ X A, by elimination
    m12, n11, n12, n13 = m12 / m11, n11 / m11, n12 / m11, n13 / m11
    m22, n21, n22, n23 = m22 - m21 * m12, n21 - m21 * n11, n22 - m21 * n12, n23 - m21 * n13
    n21, n22, n23 = n21 / m22, n22 / m22, n23 / m22
    return n11 - m12 * n21, n12 - m12 * n22, n13 - m12 * n23, n21, n22, n23


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


@jitable
def error_dynamics(v_r: float, omega_r: float, dt: float) -> tuple[Matrix, Inputs]:
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
    sin, cos = sin_cos(angle)
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


@jitable_apart
def feedback(weights: LqrWeights, v_r: float, omega_r: float, dt: float) -> Feedback:
    """Return the gains K of u = -K e at one velocity [m/s], [rad/s] of the cart, for a period [s], by rows."""
    # a sum over periods: both weights have the same factor dt, which cancels
    a, b = error_dynamics(v_r, omega_r, dt)
    return optimal_feedback(a, b, (weights.q1, weights.q2, weights.q3))


_TABLE = ''.join(f'({"".join(f"feedback(weights, {v_r}, {omega_r}, dt), " for omega_r in TURNS)}), ' for v_r in SPEEDS)
# written out, too: a compiler takes no loop that makes a tuple
prepare: Any = jitable(eval(f'lambda weights, dt: ({_TABLE})', {'feedback': feedback}))  # noqa: S307 (of constants)
"""Returns the schedule, the feedback at each pair of SPEEDS and TURNS, of weights and a period [s]."""


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
        v_r * cos(e3) + (k11 * e1 + k12 * e2 + k13 * e3),
        # ω = ω_r + k21 e1 + k22 e2 + k23 e3
        omega_r + (k21 * e1 + k22 * e2 + k23 * e3),
    )


LAW = Law('lqr', step, LqrWeights, prepare=prepare)
