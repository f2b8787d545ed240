"""The tracking law of Kanayama et al., as a law of one's own for mobile_robot_control."""

from typing import Annotated, NamedTuple

from mobile_robot_control import BodyVelocity, Field, Law, NoState, Observation, jitable
from mobile_robot_control.elementary import sin_cos


class KanayamaGains(NamedTuple):
    """Gains of the law; any positive ones are stable on the ideal robot."""

    kx: Annotated[
        float, Field('1/s', 'longitudinal gain: larger closes the gap ahead sooner and asks for more torque',
                     above=0.0, live=True, search=(0.0, 20.0))
    ] = 2.21114
    ky: Annotated[
        float, Field('rad/m²', 'lateral gain: larger turns harder towards the path, and swings around it',
                     above=0.0, live=True, search=(0.0, 60.0))
    ] = 11.0204
    ktheta: Annotated[
        float, Field('rad/m', 'heading gain: larger corrects the heading sooner and asks for more torque',
                     above=0.0, live=True, search=(0.0, 30.0))
    ] = 7.21668


@jitable
def step(state: NoState, observation: Observation, gains: KanayamaGains, dt: float) -> tuple[NoState, BodyVelocity]:
    """
    Compute the velocities for which V = (e1² + e2²) / 2 + (1 - cos e3) / ky never rises while v_r >= 0.

    The control rule of Y. Kanayama, Y. Kimura, F. Miyazaki and T. Noguchi, "A stable tracking control method for an
    autonomous mobile robot", IEEE Int. Conf. on Robotics and Automation, 1990. The gains have their names in G. Klancar
    et al., "Wheeled Mobile Robotics", 2017, chapter 3.
    """
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    sine, cosine = sin_cos(e3)
    return state, BodyVelocity(
        # v = v_r cos e3 + kx e1
        v_r * cosine + gains.kx * e1,
        # ω = ω_r + v_r (ky e2 + kθ sin e3)
        omega_r + v_r * (gains.ky * e2 + gains.ktheta * sine),
    )


LAW = Law('my_kanayama', step, KanayamaGains)
