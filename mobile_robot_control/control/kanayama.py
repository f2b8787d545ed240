"""The tracking law of Kanayama et al."""

from typing import Annotated, NamedTuple

from mobile_robot_control.control.law import Law, NoState
from mobile_robot_control.elementary import sin_cos
from mobile_robot_control.jit import jitable
from mobile_robot_control.parameters.declaration import Field
from mobile_robot_control.quantities import BodyVelocity, Observation


class KanayamaGains(NamedTuple):
    """Gains K_x, K_y and K_θ of the control rule."""

    kx: Annotated[
        float, Field('1/s', 'longitudinal gain K_x: larger closes the gap ahead sooner and asks for more torque',
                     above=0.0, live=True, search=(0.0, 20.0))
    ] = 2.2111
    ky: Annotated[
        float, Field('rad/m²', 'lateral gain K_y: larger turns harder towards the path, and swings around it',
                     above=0.0, live=True, search=(0.0, 60.0))
    ] = 11.0207
    ktheta: Annotated[
        float, Field('rad/m', 'heading gain K_θ, critical damping on a line at 2 √K_y: larger corrects the heading '
                     'sooner and asks for more torque', above=0.0, live=True, search=(0.0, 30.0))
    ] = 7.21678


@jitable
def step(state: NoState, observation: Observation, gains: KanayamaGains, dt: float) -> tuple[NoState, BodyVelocity]:
    """
    Compute the body velocity for which V = (e1² + e2²) / 2 + (1 - cos e3) / K_y never rises while v_r >= 0.

    The control rule of [1]_, Eq. (8).

    Parameters
    ----------
    state : NoState
        Returned unchanged.
    observation : Observation
        e1, e2 [m], e3 [rad], v_r [m/s] and ω_r [rad/s] are used.
    gains : KanayamaGains
        K_x, K_y, K_θ.
    dt : float
        Not used: the law is static.

    Returns
    -------
    tuple of NoState and BodyVelocity
        The command [m/s], [rad/s].

    Notes
    -----
    No division occurs. At v_r = 0 nothing turns the robot: heading and lateral error stay. e3 = π is a saddle that the
    error leaves. Backstepping at α = 1 is this law with a constant heading gain.

    References
    ----------
    .. [1] Y. Kanayama, Y. Kimura, F. Miyazaki and T. Noguchi, "A stable tracking control method for an autonomous
       mobile robot", IEEE International Conference on Robotics and Automation, 1990, pp. 384-389.

    """
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    sin_e3, cos_e3 = sin_cos(e3)
    return state, BodyVelocity(
        # Eq. (8) of [1]: v = v_r cos e3 + K_x e1
        v_r * cos_e3 + gains.kx * e1,
        # Eq. (8) of [1]: ω = ω_r + v_r (K_y e2 + K_θ sin e3)
        omega_r + v_r * (gains.ky * e2 + gains.ktheta * sin_e3),
    )


LAW = Law('kanayama', step, KanayamaGains)
