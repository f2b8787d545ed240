"""The nonlinear time-varying law of Samson, which robotics teams know as Ramsete."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.elementary import cos, sin
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation

_NO_ANGLE = 1e-9
"""[rad]: below it sin x / x is computed from its series, as in WPILib."""


class RamseteGains(NamedTuple):
    """Gains ζ and b; with the cart's present velocity they give the three gains of the feedback."""

    b: Annotated[
        float, Field('rad²/m²', 'stiffness b: larger turns harder towards the path and closes the gap ahead sooner',
                     above=0.0, live=True, search=(0.0, 60.0))
    ] = 13.6795
    zeta: Annotated[
        float, Field('', 'damping ζ: larger overshoots less and asks for more torque', above=0.0, live=True,
                     search=(0.0, 2.0))
    ] = 0.490978


@jitable
def sinc(angle: float) -> float:
    """Return sin x / x of an angle [rad], 1 at zero."""
    if abs(angle) < _NO_ANGLE:
        # the quotient is 0 / 0 at zero; two terms of the series are exact here
        return 1.0 - angle * angle / 6.0
    return sin(angle) / angle


@jitable
def step(state: NoState, observation: Observation, gains: RamseteGains, dt: float) -> tuple[NoState, BodyVelocity]:
    """
    Compute the body velocity for which V = b (e1² + e2²) / 2 + e3² / 2 never rises.

    The nonlinear controller of [1]_, Eq. (5.12), which is due to Samson [2]_; `RamseteController` of WPILib.

    Parameters
    ----------
    state : NoState
        Returned unchanged.
    observation : Observation
        e1, e2 [m], e3 [rad], v_r [m/s] and ω_r [rad/s] are used.
    gains : RamseteGains
        b and ζ.
    dt : float
        Not used: the law is static.

    Returns
    -------
    tuple of NoState and BodyVelocity
        The command [m/s], [rad/s].

    Notes
    -----
    While the cart stands, the gain k is zero, and so is the command: the robot does not move. At e3 = π the turn
    changes its side, because the heading error does.

    References
    ----------
    .. [1] A. De Luca, G. Oriolo and M. Vendittelli, "Control of wheeled mobile robots: an experimental overview", in
       Ramsete, Lecture Notes in Control and Information Sciences 270, Springer, 2001, pp. 181-226.
    .. [2] C. Samson, "Time-varying feedback stabilization of car-like wheeled mobile robots", International Journal of
       Robotics Research 12, 1993, pp. 55-64.

    """
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    # k = 2 ζ √(ω_r² + b v_r²)
    k = 2.0 * gains.zeta * math.sqrt(omega_r * omega_r + gains.b * v_r * v_r)
    return state, BodyVelocity(
        # Eq. (5.12) of [1]: v = v_r cos e3 + k e1
        v_r * cos(e3) + k * e1,
        # Eq. (5.12) of [1]: ω = ω_r + k e3 + b v_r (sin e3 / e3) e2
        omega_r + k * e3 + gains.b * v_r * sinc(e3) * e2,
    )


LAW = Law('ramsete', step, RamseteGains)
