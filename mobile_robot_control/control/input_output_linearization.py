"""Input/output linearisation of a point ahead of the axle, after Siciliano, Sciavicco, Villani and Oriolo."""

from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.elementary import sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation


class PointGains(NamedTuple):
    """Gain of the point's error, and the distance of the point."""

    k: Annotated[
        float, Field('1/s', "gain of the point's error: larger closes the gap sooner, ahead and aside, and asks for "
                     'more torque', above=0.0, live=True, search=(0.0, 20.0))
    ] = 1.28456
    distance: Annotated[
        float, Field('m', 'distance b of the point ahead of the axle: larger turns less for an error aside, and '
                     'corrects the heading later', above=0.0, live=True, search=(0.05, 1.0))
    ] = 0.237442


@jitable
def step(state: NoState, observation: Observation, gains: PointGains, dt: float) -> tuple[NoState, BodyVelocity]:
    """
    Compute the body velocity for which the error e of a point ahead obeys ė + k e = 0 in the frame of the plane.

    The static feedback of [1]_, section 11.5.2, for the point B at the distance b along the robot's axis. Its
    reference is the point B of the cart. A law has no access to the pose, so all vectors are written in the robot's
    frame, which requires equal gains along x and y.

    Parameters
    ----------
    state : NoState
        Returned unchanged.
    observation : Observation
        e1, e2 [m], e3 [rad], v_r [m/s] and ω_r [rad/s] are used.
    gains : PointGains
        k and b.
    dt : float
        Not used: the law is static.

    Returns
    -------
    tuple of NoState and BodyVelocity
        The command [m/s], [rad/s].

    Notes
    -----
    Nothing controls the heading. With B on its reference, ė3 = -(v_r / b) sin e3 + ω_r (1 - cos e3): behind a cart
    that drives forwards the heading error decays at v_r / b, a cart that drives backwards turns the robot round, and
    one that stands or turns on the spot leaves a heading error. No input is singular: only b divides.

    References
    ----------
    .. [1] B. Siciliano, L. Sciavicco, L. Villani and G. Oriolo, *Robotics: Modelling, Planning and Control*, Springer,
       2009, section 11.5.

    """
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    b = gains.distance
    sin, cos = sin_cos(e3)
    # from the robot's B to that of the cart, along and across the robot
    along, across = e1 + b * cos - b, e2 + b * sin
    # u = ẏ_d + k (y_d - y), where ẏ_d is v_r along the cart and b ω_r across it
    u_x = v_r * cos - b * omega_r * sin + gains.k * along
    u_y = v_r * sin + b * omega_r * cos + gains.k * across
    # v = u_x cos θ + u_y sin θ, ω = (u_y cos θ - u_x sin θ) / b
    return state, BodyVelocity(u_x, u_y / b)


LAW = Law('input_output_linearization', step, PointGains)
