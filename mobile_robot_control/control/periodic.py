"""The law periodic in the heading error, after Blazic and Klancar et al."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.elementary import sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation


class PeriodicGains(NamedTuple):
    """Gains ζ and g; with the cart's present velocity they give the three gains of the feedback."""

    g: Annotated[
        float, Field('rad²/m²', 'stiffness g: larger turns harder towards the path and closes the gap ahead sooner',
                     above=0.0, live=True, search=(0.0, 60.0))
    ] = 16.3153
    zeta: Annotated[
        float, Field('', 'damping ζ: larger overshoots less and asks for more torque', above=0.0, live=True,
                     search=(0.0, 2.0))
    ] = 0.582474


@jitable
def step(state: NoState, observation: Observation, gains: PeriodicGains, dt: float) -> tuple[NoState, BodyVelocity]:
    """
    Compute the body velocity for which V = k_y (e1² + e2²) / 2 + 2 tan²(e3 / 2) never rises.

    The periodic law of [1]_, chapter 3, a member of the family of [2]_, with k_y = g and k_x = k_φ of the book's
    listing, which keep the damping for every velocity of the cart.

    Parameters
    ----------
    state : NoState
        Returned unchanged.
    observation : Observation
        e1, e2 [m], e3 [rad], v_r [m/s] and ω_r [rad/s] are used.
    gains : PeriodicGains
        g and ζ.
    dt : float
        Not used: the law is static.

    Returns
    -------
    tuple of NoState and BodyVelocity
        The command [m/s], [rad/s].

    Notes
    -----
    No division occurs. A full turn changes nothing, so the command has no jump at e3 = π. There V is infinite: facing
    away is an equilibrium that the error leaves, slowly from nearby. While the cart stands, the gains are zero, and so
    is the command.

    References
    ----------
    .. [1] G. Klancar, A. Zdesar, S. Blazic and I. Skrjanc, *Wheeled Mobile Robotics*, Butterworth-Heinemann, 2017,
       chapter 3, the periodic control law and its listing.
    .. [2] S. Blazic, "A novel trajectory-tracking control law for wheeled mobile robots", Robotics and Autonomous
       Systems 59, 2011, pp. 1001-1007.

    """
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    # k_x = k_φ = 2 ζ √(ω_r² + g v_r²), k_y = g
    k = 2.0 * gains.zeta * math.sqrt(omega_r * omega_r + gains.g * v_r * v_r)
    sin_e3, cos_e3 = sin_cos(e3)
    # cos²(e3 / 2)
    half = 0.5 * (1.0 + cos_e3)
    return state, BodyVelocity(
        # v = v_r cos e3 + k_x e1
        v_r * cos_e3 + k * e1,
        # ω = ω_r + k_y v_r cos⁴(e3 / 2) e2 + k_φ sin e3
        omega_r + gains.g * v_r * (half * half) * e2 + k * sin_e3,
    )


LAW = Law('periodic', step, PeriodicGains)
