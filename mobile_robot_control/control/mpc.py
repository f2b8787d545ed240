"""
Model predictive control of the tracking error over ten stages of the reference, within the limits of v and ω.

The quadratic program is solved by Riccati's recursion in plain Python: nodes import no solver. With each stage's
inputs fixed at the limits that they reach, the rest is a problem without limits; which ones they reach is found by
trying, from none.
"""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.control.limits import Limits
from mobile_robot_control.control.lqr import error_dynamics
from mobile_robot_control.elementary import cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation, TrackingError

STAGES = 10
TICKS = 4
"""Position ticks of a stage, over which an input is held in the plan."""
TRIES = 10
"""Most sets of limits that are tried; weights in the ranges of a search need up to six."""

Stage = tuple[float, ...]
"""Of A = [c s a; -s c b; 0 0 1] the numbers c, s, a, b; of B its upper rows; the limits of u1, then of u2."""
Line = tuple[float, ...]
"""Of a stage's cost u'Mu + 2 u'(Ne + g): m11, m12, m22, N by rows, g."""
Sides = tuple[int, int]
"""Limits of u1 and u2 in a stage that hold as equations: -1 the lower one, 1 the upper one, 0 none."""


class MpcWeights(NamedTuple):
    """Weights of the errors in the minimised sum; both velocities have the weights 1 s²/m² and 1 s²/rad²."""

    q1: Annotated[
        float, Field('1/m²', 'weight of the longitudinal error: larger closes the gap ahead sooner and asks for more '
                     'torque', minimum=1e-3, maximum=1e6, live=True, search=(1e-3, 200.0))
    ] = 3.9972
    q2: Annotated[
        float, Field('1/m²', 'weight of the lateral error: larger turns harder towards the path', minimum=1e-3,
                     maximum=1e6, live=True, search=(1e-3, 2000.0))
    ] = 26.152
    q3: Annotated[
        float, Field('1/rad²', 'weight of the heading error: larger turns harder against it, and less towards the '
                     'path', minimum=1e-3, maximum=1e6, live=True, search=(1e-3, 200.0))
    ] = 5.76924


@jitable
def _line() -> Line:
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


@jitable
def _stage(forward: float, velocity: BodyVelocity, limits: Limits, period: float) -> Stage:
    """Return the model and the limits of u = (forward - v, ω_r - ω) over a period [s]."""
    ((c, s, a), (_, _, b), _), ((b11, b12), (b21, b22), _) = error_dynamics(
        velocity.linear, velocity.angular, period)
    v_max = limits.linear_velocity if limits.linear_velocity > 0.0 else math.inf
    omega_max = limits.angular_velocity if limits.angular_velocity > 0.0 else math.inf
    return (c, s, a, b, b11, b12, b21, b22, forward - v_max, forward + v_max,
            velocity.angular - omega_max, velocity.angular + omega_max)


@jitable
def _ahead(observation: Observation, tick: int) -> BodyVelocity:
    """Return the velocity of the cart at a tick of its horizon; behind the last one it is held."""
    # a compiler takes no star
    references = (observation.reference,) + observation.horizon
    return references[min(tick, len(references) - 1)].velocity


@jitable
def _stages(observation: Observation, limits: Limits, period: float) -> tuple[Stage, ...]:
    """Return all stages."""
    # written out: a place that is known at compile time costs nothing
    velocities = (
        observation.reference.velocity, _ahead(observation, TICKS), _ahead(observation, 2 * TICKS),
        _ahead(observation, 3 * TICKS), _ahead(observation, 4 * TICKS), _ahead(observation, 5 * TICKS),
        _ahead(observation, 6 * TICKS), _ahead(observation, 7 * TICKS), _ahead(observation, 8 * TICKS),
        _ahead(observation, 9 * TICKS))
    # v = v_r cos e3 - u1 at once, and v_r - u1 by the linear model of what is to come
    stage = _stage(velocities[0].linear * cos(observation.error.heading), velocities[0], limits, period)
    stages = stage, stage, stage, stage, stage, stage, stage, stage, stage, stage
    for n in range(1, STAGES):
        stages = stages[1:] + (_stage(velocities[n].linear, velocities[n], limits, period),)
    return stages


@jitable
def _minimum(m: tuple[float, float, float], h1: float, h2: float, stage: Stage, sides: Sides) -> tuple[float, float]:
    """Return the u that minimises u'Mu + 2 u'h with the given sides at their limits."""
    m11, m12, m22 = m
    u1 = stage[8] if sides[0] < 0 else stage[9]
    u2 = stage[10] if sides[1] < 0 else stage[11]
    if sides[0] == 0 and sides[1] == 0:
        # the divisors are those of 1 + something positive, except for rounding
        u2 = -(h2 - m12 / m11 * h1) / max(1.0, m22 - m12 / m11 * m12)
    elif sides[1] == 0:
        u2 = -(h2 + m12 * u1) / m22
    if sides[0] == 0:
        u1 = -(h1 + m12 * u2) / m11
    return u1, u2


@jitable
def _before(value: Line, stage: Stage, sides: Sides, weights: MpcWeights, period: float) -> tuple[Line, Line]:
    """Return a stage's cost, and the value e'Pe + 2 p'e before the stage from that behind it: P by rows, p."""
    p11, p12, p13, p22, p23, p33, p1, p2, p3 = value
    c, s, a, b, b11, b12, b21, b22 = stage[:8]
    # PB and PA, by columns
    w11, w12, w13 = p11 * b11 + p12 * b21, p12 * b11 + p22 * b21, p13 * b11 + p23 * b21
    w21, w22, w23 = (p11 * b12 + p12 * b22 + p13 * period, p12 * b12 + p22 * b22 + p23 * period,
                     p13 * b12 + p23 * b22 + p33 * period)
    x11, x12 = c * p11 - s * p12, c * p12 - s * p22
    x21, x22 = s * p11 + c * p12, s * p12 + c * p22
    x31, x32, x33 = a * p11 + b * p12 + p13, a * p12 + b * p22 + p23, a * p13 + b * p23 + p33
    # M = R + B'PB, N = B'PA and g = B'p
    m11 = max(1.0, 1.0 + (b11 * w11 + b21 * w12))
    m12 = b11 * w21 + b21 * w22
    m22 = max(1.0, 1.0 + (b12 * w21 + b22 * w22 + period * w23))
    n11, n12, n13 = c * w11 - s * w12, s * w11 + c * w12, a * w11 + b * w12 + w13
    n21, n22, n23 = c * w21 - s * w22, s * w21 + c * w22, a * w21 + b * w22 + w23
    g1, g2 = b11 * p1 + b21 * p2, b12 * p1 + b22 * p2 + period * p3
    # u = Ke + d, where what is fixed has no share of K
    m, none = (m11, m12, m22), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    k11, k21 = _minimum(m, n11, n21, none, sides)
    k12, k22 = _minimum(m, n12, n22, none, sides)
    k13, k23 = _minimum(m, n13, n23, none, sides)
    d1, d2 = _minimum(m, g1, g2, stage, sides)
    return (m11, m12, m22, n11, n12, n13, n21, n22, n23, g1, g2), (
        # P = Q + A'PA + N'K and p = A'p + N'd
        weights.q1 + (c * x11 - s * x12 + n11 * k11 + n21 * k21),
        c * x21 - s * x22 + n11 * k12 + n21 * k22,
        c * x31 - s * x32 + n11 * k13 + n21 * k23,
        weights.q2 + (s * x21 + c * x22 + n12 * k12 + n22 * k22),
        s * x31 + c * x32 + n12 * k13 + n22 * k23,
        weights.q3 + (a * x31 + b * x32 + x33 + n13 * k13 + n23 * k23),
        c * p1 - s * p2 + n11 * d1 + n21 * d2,
        s * p1 + c * p2 + n12 * d1 + n22 * d2,
        a * p1 + b * p2 + p3 + n13 * d1 + n23 * d2)


@jitable
def _lines(
    stages: tuple[Stage, ...], sides: tuple[Sides, ...], weights: MpcWeights, period: float
) -> tuple[Line, ...]:
    """Return the costs of all stages, from the last one backwards."""
    value: Line = (weights.q1, 0.0, 0.0, weights.q2, 0.0, weights.q3, 0.0, 0.0, 0.0)
    line = _line()
    lines = line, line, line, line, line, line, line, line, line, line
    for n in range(STAGES - 1, -1, -1):
        line, value = _before(value, stages[n], sides[n], weights, period)
        lines = (line,) + lines[:-1]
    return lines


@jitable
def _side(u: float, slope: float, low: float, high: float, side: int) -> int:
    """Return the side of an input in the next try: it leaves a limit where the cost falls inwards."""
    if side == 0:
        return -1 if u < low else 1 if u > high else 0
    return 0 if side * slope > 0.0 else side


@jitable
def _planned(
    error: TrackingError, stages: tuple[Stage, ...], lines: tuple[Line, ...], sides: tuple[Sides, ...], period: float
) -> tuple[tuple[float, float], tuple[Sides, ...], bool]:
    """Return the first input of the plan, the sides of the next try, and whether they are those of this one."""
    (e1, e2, e3), first, settled = error, (0.0, 0.0), True
    for n in range(STAGES):
        stage, before = stages[n], sides[0]
        m11, m12, m22, n11, n12, n13, n21, n22, n23, g1, g2 = lines[n]
        h1, h2 = n11 * e1 + n12 * e2 + n13 * e3 + g1, n21 * e1 + n22 * e2 + n23 * e3 + g2
        u1, u2 = _minimum((m11, m12, m22), h1, h2, stage, before)
        after = (_side(u1, m11 * u1 + m12 * u2 + h1, stage[8], stage[9], before[0]),
                 _side(u2, m12 * u1 + m22 * u2 + h2, stage[10], stage[11], before[1]))
        settled = settled and after == before
        sides = sides[1:] + (after,)
        # the plan itself keeps the limits, so that later stages see an error that can be
        u1, u2 = min(max(u1, stage[8]), stage[9]), min(max(u2, stage[10]), stage[11])
        if n == 0:
            first = u1, u2
        c, s, a, b, b11, b12, b21, b22 = stage[:8]
        e1, e2, e3 = (c * e1 + s * e2 + a * e3 + b11 * u1 + b12 * u2,
                      c * e2 - s * e1 + b * e3 + b21 * u1 + b22 * u2, e3 + period * u2)
    return first, sides, settled


@jitable
def step(
    state: NoState, observation: Observation, gains: tuple[MpcWeights, Limits], dt: float
) -> tuple[NoState, BodyVelocity]:
    """
    Return the first command of the plan that minimises the predicted errors and inputs within the limits.

    Linear time-varying model predictive control, see [2]_, of the error dynamics of [1]_: the sum over the stages of
    eᵀQe at their ends and of uᵀu, with u = (v_r cos e3 - v, ω_r - ω), where A and B of a stage are those of the
    reference at its start, held over the stage.

    Parameters
    ----------
    state : NoState
        Returned unchanged: no step depends on the one before.
    observation : Observation
        e1, e2 [m], e3 [rad], and v_r [m/s] and ω_r [rad/s] now and ahead are used.
    gains : tuple of MpcWeights and Limits
        Q, and limits of v and ω; limits of acceleration are not in the plan.
    dt : float
        Period to the next step [s].

    Returns
    -------
    tuple of NoState and BodyVelocity
        The command [m/s], [rad/s].

    Notes
    -----
    A try solves the program with some inputs fixed at limits, by Riccati's recursion with an affine part. An input
    beyond a limit is fixed there in the next try, and freed where the cost falls inwards; when nothing changes, the
    optimality conditions hold. This is the primal-dual active set method of [3]_ on a plan that keeps its limits, as in
    [4]_. Without limits the first try is the answer. The command of the last try is within the limits in any case, and
    no optimum if something would still change.

    References
    ----------
    .. [1] G. Klancar and I. Skrjanc, "Tracking-error model-based predictive control for mobile robots in real time",
       Robotics and Autonomous Systems 55, 2007, pp. 460-469.
    .. [2] J. B. Rawlings, D. Q. Mayne and M. M. Diehl, *Model Predictive Control: Theory, Computation, and Design*,
       second edition, Nob Hill, 2017, sections 1.3 and 8.8.
    .. [3] M. Hintermueller, K. Ito and K. Kunisch, "The primal-dual active set strategy as a semismooth Newton
       method", SIAM Journal on Optimization 13, 2002, pp. 865-888.
    .. [4] Y. Tassa, N. Mansard and E. Todorov, "Control-limited differential dynamic programming", IEEE International
       Conference on Robotics and Automation, 2014, pp. 1168-1175.

    """
    weights, limits = gains
    period = TICKS * dt
    stages = _stages(observation, limits, period)
    none, u = (0, 0), (0.0, 0.0)
    sides: tuple[Sides, ...] = (none, none, none, none, none, none, none, none, none, none)
    for _ in range(TRIES):
        u, sides, settled = _planned(
            observation.error, stages, _lines(stages, sides, weights, period), sides, period)
        if settled:
            break
    v_r, omega_r = observation.reference.velocity
    return state, BodyVelocity(v_r * cos(observation.error.heading) - u[0], omega_r - u[1])


LAW = Law('mpc', step, MpcWeights, within_limits=True)
