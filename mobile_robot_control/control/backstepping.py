"""The backstepping position law."""

from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.elementary import cos, sin, sin_cos
from mobile_robot_control.elementary import pow as power
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation, TrackingError

_FARTHEST_SQUARED = 1e30
"""[m²]: beyond this the power in Eq. (25) would overflow, which raises in Python."""


class BacksteppingGains(NamedTuple):
    """
    Gains of Eq. (25), where f and g are constants, as in the chapter's search.

    The chapter gives no units (deviation 13). With another α than 1, p is in 1/m^(2α) and f in m^(2α)/s.
    """

    p: Annotated[
        float, Field('1/m²', 'weight of the position error, p: larger reacts more strongly to a gap ahead and aside',
                     above=0.0, live=True, search=(0.0, 5.0))
    ] = 1.646
    q: Annotated[
        float, Field('', 'weight of the heading error, q: larger turns harder against it, and less towards the path',
                     above=0.0, live=True, search=(0.0, 2.0))
    ] = 0.243115
    alpha: Annotated[
        float, Field('', 'exponent α of the position error, 1 in the usual form: larger raises the longitudinal '
                     'gain and weakens the lateral feedback near the cart', minimum=1.0, maximum=5.0, live=True)
    ] = 1.0
    f: Annotated[
        float, Field('m²/s', 'gain f of the longitudinal feedback: larger closes the gap ahead sooner and asks for '
                     'more torque', above=0.0, live=True, search=(0.0, 20.0))
    ] = 1.26767
    g: Annotated[
        float, Field('1/s', 'gain g of the heading feedback: larger corrects the heading sooner and asks for more '
                     'torque', above=0.0, live=True, search=(0.0, 20.0))
    ] = 10.1146


@jitable
def step(
    state: NoState, observation: Observation, gains: BacksteppingGains, dt: float
) -> tuple[NoState, BodyVelocity]:
    """
    Compute the body velocity for which the Lyapunov function (26) decreases.

    Implements Eq. (25) of the chapter, with v = v_r cos e3 - u1 and ω = ω_r - u2 from Eq. (24).

    Parameters
    ----------
    state : NoState
        Returned unchanged.
    observation : Observation
        e1, e2 [m], e3 [rad], v_r [m/s] and ω_r [rad/s] are used.
    gains : BacksteppingGains
        p, q, α, f, g.
    dt : float
        Not used: the law is static.

    Returns
    -------
    tuple of NoState and BodyVelocity
        The command [m/s], [rad/s].

    Notes
    -----
    Converges only while v_r stays away from zero; e3 = π is a saddle that the error leaves, not an attractor.

    """
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    p, q, alpha, f, g = gains
    sin_e3, cos_e3 = sin_cos(e3)
    distance_squared = min(e1 * e1 + e2 * e2, _FARTHEST_SQUARED)
    # Eq. (25): u1 = -α p e1 f
    u1 = -alpha * p * e1 * f
    # Eq. (25): u2 = -(2 α p / q) (e1² + e2²)^(α-1) v_r e2 - q sin e3 g
    u2 = -2.0 * alpha * p / q * power(distance_squared, alpha - 1.0) * v_r * e2 - q * sin_e3 * g
    # Eq. (24): v = v_r cos e3 - u1, ω = ω_r - u2
    return state, BodyVelocity(v_r * cos_e3 - u1, omega_r - u2)


def lyapunov(error: TrackingError, gains: BacksteppingGains) -> float:
    """
    Return the Lyapunov function V >= 0 that proves the law stable; it is zero only where the error is zero.

    Implements Eq. (26) of the chapter.

    Parameters
    ----------
    error : TrackingError
        e1, e2 [m], e3 [rad].
    gains : BacksteppingGains
        p, q and α are used.
    """
    e1, e2, e3 = error
    # Eq. (26): V = p (e1² + e2²)^α + q (1 - cos e3)
    return float(gains.p * power(e1 * e1 + e2 * e2, gains.alpha) + gains.q * (1.0 - cos(e3)))


def lyapunov_rate(error: TrackingError, gains: BacksteppingGains) -> float:
    """
    Return the time derivative dV/dt <= 0 of the Lyapunov function along the ideal kinematic loop.

    Implements Eq. (28) of the chapter, whose '< 0' is '<= 0': it is zero wherever e1 = sin e3 = 0. To derive it
    from (27), the first term of (27) needs the factor e1 that it lacks in print.

    Parameters
    ----------
    error : TrackingError
        e1, e2 [m], e3 [rad].
    gains : BacksteppingGains
        p, q, α, f and g.
    """
    e1, e2, e3 = error
    p, q, alpha, f, g = gains
    # Eq. (28): dV/dt = -2 α² p² e1² (e1² + e2²)^(α-1) f - q² sin² e3 g
    along, turn = alpha * p * e1, q * sin(e3)
    return float(-2.0 * along * along * power(e1 * e1 + e2 * e2, alpha - 1.0) * f - turn * turn * g)


LAW = Law('backstepping', step, BacksteppingGains)
