"""Dynamic feedback linearisation of the tracking error, after Oriolo, De Luca and Vendittelli."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law
from mobile_robot_control.elementary import expm1, sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation


class LinearizingGains(NamedTuple):
    """Gains of the linear error equation ë + k_d ė + k_p e = 0, and the least divisor."""

    kp: Annotated[
        float, Field('1/s²', 'gain k_p of the position error: larger closes the gap sooner and asks for more torque',
                     above=0.0, live=True, search=(0.0, 40.0))
    ] = 1.19767
    kd: Annotated[
        float, Field('1/s', 'gain k_d of the velocity error, critical damping at 2 √k_p: larger overshoots less and '
                     'closes the gap later', above=0.0, live=True, search=(0.0, 20.0))
    ] = 1.18669
    xi_min: Annotated[
        float, Field('m/s', 'least speed in the divisor, ξ_min: larger turns less while the robot is slow', above=0.0,
                     live=True)
    ] = 0.1


class CompensatorState(NamedTuple):
    """
    State of the dynamic compensator.

    Attributes
    ----------
    started : float
        1 after the first step, 0 before.
    xi : float
        ξ, the speed that the compensator integrates [m/s].
    last_v_r : float
        The cart's speed at the previous step [m/s].
    """

    started: float = 0.0
    xi: float = 0.0
    last_v_r: float = 0.0


@jitable
def step(
    state: CompensatorState, observation: Observation, gains: LinearizingGains, dt: float
) -> tuple[CompensatorState, BodyVelocity]:
    """
    Compute the body velocity for which the position error e obeys ë + k_d ė + k_p e = 0 in the frame of the plane.

    The dynamic compensator of [1]_ with its proportional-derivative feedback. A law has no access to the pose, so all
    vectors are written in the robot's frame, which requires equal gains along x and y. The cart's acceleration is v_r
    ω_r across its heading. Along it, it is the reference's acceleration or, if that is not sent, the last difference of
    v_r.

    Parameters
    ----------
    state : CompensatorState
        The default one at a run's start; ξ then begins at v_r.
    observation : Observation
        e1, e2 [m], e3 [rad], v_r [m/s] and ω_r [rad/s] are used.
    gains : LinearizingGains
        k_p, k_d, ξ_min.
    dt : float
        Period to the next step [s].

    Returns
    -------
    tuple of CompensatorState and BodyVelocity
        The state for the next step and the command [m/s], [rad/s].

    Notes
    -----
    The heading follows from the velocity: the robot may drive the path in reverse if it starts so. The compensator is
    integrated exactly under held errors, so no k_d makes it oscillate. The speed is the one at the period's end, and ω
    divides by the one at its start, as in the listing of [2]_.

    References
    ----------
    .. [1] G. Oriolo, A. De Luca and M. Vendittelli, "WMR control via dynamic feedback linearization: design,
       implementation, and experimental validation", IEEE Transactions on Control Systems Technology 10, 2002,
       pp. 835-852.
    .. [2] G. Klancar, A. Zdesar, S. Blazic and I. Skrjanc, "Wheeled Mobile Robotics", Butterworth-Heinemann, 2017,
       section 3.3.

    """
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    kp, kd, xi_min = gains
    xi, v_r_rate = state.xi, (v_r - state.last_v_r) / dt
    if state.started == 0.0:
        # ξ(0) = v_r(0) is not singular while the cart moves; there is no difference of v_r yet
        xi, v_r_rate = v_r, 0.0
    if len(observation.horizon) > 0:
        v_r_rate = observation.reference.acceleration.linear
    sin, cos = sin_cos(e3)
    # u = p̈_r + k_d (ṗ_r - ṗ) + k_p (p_r - p), along and across the robot, where ṗ is ξ along it
    along = v_r_rate * cos - v_r * omega_r * sin + kd * (v_r * cos - xi) + kp * e1
    across = v_r_rate * sin + v_r * omega_r * cos + kd * v_r * sin + kp * e2
    # the compensator is singular at ξ = 0: a unicycle that stands cannot accelerate sideways
    divisor = xi if abs(xi) >= xi_min else math.copysign(xi_min, xi)
    # dξ/dt = u_x cos θ + u_y sin θ, whose -k_d ξ decays exactly
    xi += along * (-expm1(-kd * dt) / kd)
    # v = ξ at the period's end, so that it answers this error and not the last one; ω = (u_y cos θ - u_x sin θ) / ξ
    return CompensatorState(1.0, xi, v_r), BodyVelocity(xi, across / divisor)


LAW = Law('dynamic_feedback_linearization', step, LinearizingGains, CompensatorState())
