"""The steering law of Stanley, the automobile of Hoffmann et al., for a robot that turns by its wheels."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.elementary import sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation


class StanleyGains(NamedTuple):
    """Gains of steering and speed, and the geometry of the front wheel that the robot does not have."""

    k: Annotated[
        float, Field('1/s', 'gain of the cross-track error of the front wheel, its decay rate near the path: larger '
                     'reaches the path sooner and asks for more torque', above=0.0, live=True, search=(0.0, 20.0))
    ] = 2.98964
    kx: Annotated[
        float, Field('1/s', 'speed for each metre that the cart is ahead along its path: larger closes this gap '
                     'sooner, 0 does not; the source has none', minimum=0.0, live=True, search=(0.0, 20.0))
    ] = 0.678894
    wheelbase: Annotated[
        float, Field('m', 'distance of the front wheel ahead of the axle: larger turns less for an error aside, and '
                     'corrects the heading later', above=0.0, live=True, search=(0.05, 1.0))
    ] = 0.255389
    softening: Annotated[
        float, Field('m/s', 'speed k_soft beside that in the divisor: larger steers less for an error aside while the '
                     'robot is slow', above=0.0, live=True)
    ] = 0.1
    max_steer: Annotated[
        float, Field('rad', 'largest steering angle: larger turns more sharply, and at 1.5708 on the spot', above=0.0,
                     maximum=1.5708, live=True)
    ] = 1.5708


@jitable
def step(state: NoState, observation: Observation, gains: StanleyGains, dt: float) -> tuple[NoState, BodyVelocity]:
    """
    Compute the body velocity of a bicycle whose front wheel is steered by the law of Stanley.

    The steering law of [1]_ for the kinematic automobile, with the softening of its slow motion: the steering angle is
    δ = ψ + arctan(k e / (k_soft + v)) within ±δ_max, for the heading ψ of the path and the cross-track error e, both
    seen by the front wheel, and the speed v of that wheel.

    Parameters
    ----------
    state : NoState
        Returned unchanged.
    observation : Observation
        e1, e2 [m], e3 [rad], v_r [m/s] and ω_r [rad/s] are used.
    gains : StanleyGains
        k, k_x, wheelbase, k_soft, δ_max.
    dt : float
        Not used: the law is static.

    Returns
    -------
    tuple of NoState and BodyVelocity
        The command [m/s], [rad/s].

    Notes
    -----
    A robot that moves with v cos δ and v sin δ / wheelbase moves as the bicycle does, so a differential drive follows
    the law exactly, also at δ = ±π/2. The path of the front wheel is that of the cart's own front wheel, so that on a
    curve the axle follows the curve; in [1]_ the front wheel does. A law sees no path: it is taken as the tangent at
    the cart, and far from the cart on a curve this is not the path. The speed is the cart's, plus k_x times the gap;
    [1]_ has a planner's. The yaw damping, the lag of the steering and the tyres of [1]_ are left out. Beside a
    standing cart a lateral error stays, and a cart that drives backwards turns the robot round.

    References
    ----------
    .. [1] G. M. Hoffmann, C. J. Tomlin, M. Montemerlo and S. Thrun, "Autonomous automobile trajectory tracking for
       off-road driving: controller design, experimental validation and racing", American Control Conference, 2007,
       pp. 2296-2301.

    """
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    k, kx, wheelbase, softening, max_steer = gains
    sin, cos = sin_cos(e3)
    # from the robot's front wheel to the cart's
    along, across = e1 + wheelbase * cos - wheelbase, e2 + wheelbase * sin
    # velocity of the cart's front wheel, and its direction ψ; a cart at rest points along its axis
    turning = wheelbase * omega_r
    v = math.sqrt(v_r * v_r + turning * turning)
    way = math.copysign(1.0, v_r)
    t_x, t_y = way * cos, way * sin
    if v > 0.0:
        t_x, t_y = (v_r * cos - turning * sin) / v, (v_r * sin + turning * cos) / v
    # gap along the path, and cross-track error e to the left of it
    gap, e = t_x * along + t_y * across, t_x * across - t_y * along
    speed = max(0.0, v + kx * gap)
    # δ = ψ + arctan(k e / (k_soft + v)), as the direction of the front wheel
    lean = k * e / (softening + speed)
    share = speed / math.sqrt(1.0 + lean * lean)
    front_x, front_y = share * (t_x - lean * t_y), share * (t_y + lean * t_x)
    sin_max, cos_max = sin_cos(max_steer)
    if way * front_x < speed * cos_max:
        front_x, front_y = way * speed * cos_max, math.copysign(speed * sin_max, front_y)
    # v cos δ, and ω = v sin δ / wheelbase
    return state, BodyVelocity(front_x, front_y / wheelbase)


LAW = Law('stanley', step, StanleyGains)
