"""The kinematic sliding-mode law of Lee et al., with a boundary layer."""

from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law
from mobile_robot_control.elementary import atan, sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation

_LEAST_DIVISOR = 0.5
"""Least value of the divisor 1 + ∂α/∂e2 e1."""


class SlidingGains(NamedTuple):
    """Rates of approach to the two surfaces, their boundary layers, and the slope of the second surface."""

    rate1: Annotated[
        float, Field('m/s', 'rate k1 of approach to s1 = e1: larger closes the gap ahead sooner and asks for more '
                     'torque', above=0.0, live=True, search=(0.0, 2.0))
    ] = 0.842051
    layer1: Annotated[
        float, Field('m', 'boundary layer of s1: larger closes a small gap ahead later and without chatter',
                     above=0.0, live=True, search=(0.02, 1.0))
    ] = 0.2224
    rate2: Annotated[
        float, Field('rad/s', 'rate k2 of approach to s2 = e3 + arctan(λ v_r e2): larger turns sooner to the heading '
                     'that leads to the path and asks for more torque', above=0.0, live=True, search=(0.0, 10.0))
    ] = 2.35732
    layer2: Annotated[
        float, Field('rad', 'boundary layer of s2: larger corrects a small angle later and without chatter',
                     above=0.0, live=True, search=(0.1, 3.0))
    ] = 2.21953
    slope: Annotated[
        float, Field('s/m²', 'slope λ of the second surface, 1 in the paper: larger approaches the path at a steeper '
                     'angle', above=0.0, live=True, search=(0.0, 20.0))
    ] = 12.6819


class SlidingState(NamedTuple):
    """
    State of the law.

    Attributes
    ----------
    started : float
        1 after the first step, 0 before.
    last_v_r : float
        The cart's speed at the previous step [m/s].
    """

    started: float = 0.0
    last_v_r: float = 0.0


@jitable
def saturation(surface: float, layer: float) -> float:
    """Return the side of a surface, -1 or 1; within its boundary layer, the fraction of the way to its edge."""
    # sign(s) would chatter at the rate of the controller
    return max(-1.0, min(1.0, surface / layer))


@jitable
def step(
    state: SlidingState, observation: Observation, gains: SlidingGains, dt: float
) -> tuple[SlidingState, BodyVelocity]:
    """
    Compute the body velocity for which s1 = e1 and s2 = e3 + arctan(λ v_r e2) reach zero at a constant rate.

    The switching functions and the reaching law of [1]_. On both surfaces (e1 = s2 = 0) e2² falls, as
    x sin(arctan x) >= 0.

    Parameters
    ----------
    state : SlidingState
        The default one at a run's start.
    observation : Observation
        e1, e2 [m], e3 [rad], v_r [m/s] and ω_r [rad/s] are used.
    gains : SlidingGains
        Rates, boundary layers and slope.
    dt : float
        Period to the next step [s].

    Returns
    -------
    tuple of SlidingState and BodyVelocity
        The state for the next step and the command [m/s], [rad/s].

    Notes
    -----
    Differs from the paper by the saturation (the paper divides s by ``abs(s) + δ``) and by the slope λ: without it e2
    decays at the rate v_r² alone. While v_r = 0 the second surface is e3 = 0, and a lateral error stays. At e3 = π the
    turn changes its side, because the heading error does.

    References
    ----------
    .. [1] J. H. Lee, C. Lin, H. Lim and J. M. Lee, "Sliding mode control for trajectory tracking of mobile robot in
       the RFID sensor space", International Journal of Control, Automation and Systems 7, 2009, pp. 429-435.

    """
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    rate1, layer1, rate2, layer2, slope = gains
    v_r_rate = (v_r - state.last_v_r) / dt if state.started > 0.0 else 0.0
    sin_e3, cos_e3 = sin_cos(e3)
    # s1 = e1, s2 = e3 + α with α = arctan(λ v_r e2)
    x = slope * v_r * e2
    s1, s2 = e1, e3 + atan(x)
    # ∂α/∂e2 = λ v_r / (1 + x²), ∂α/∂v_r = λ e2 / (1 + x²)
    by_e2, by_v_r = slope * v_r / (1.0 + x * x), slope * e2 / (1.0 + x * x)
    # zero for a cart 1 / (∂α/∂e2) behind: no turn keeps the robot on s2 there, and s1 leads away from it
    divisor = max(_LEAST_DIVISOR, 1.0 + by_e2 * e1)
    # ds2/dt = -k2 sat(s2): ω = (ω_r + ∂α/∂v_r dv_r/dt + ∂α/∂e2 v_r sin e3 + k2 sat(s2)) / (1 + ∂α/∂e2 e1)
    omega = (omega_r + by_v_r * v_r_rate + by_e2 * v_r * sin_e3 + rate2 * saturation(s2, layer2)) / divisor
    # ds1/dt = -k1 sat(s1): v = v_r cos e3 + e2 ω + k1 sat(s1)
    v = v_r * cos_e3 + e2 * omega + rate1 * saturation(s1, layer1)
    return SlidingState(1.0, v_r), BodyVelocity(v, omega)


LAW = Law('sliding_mode', step, SlidingGains, SlidingState())
