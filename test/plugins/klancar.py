"""The linear law of Klancar et al., Wheeled Mobile Robotics (2017), Eq. (3.9)."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control import BodyVelocity, Field, Law


class Gains(NamedTuple):
    zeta: Annotated[float, Field('', 'damping: larger overshoots less', above=0.0, search=(0.1, 2.0))] = 0.9
    g: Annotated[float, Field('1/m²', 'stiffness: larger closes the gap sooner', above=0.0, search=(1.0, 200.0))] = 85.0


def step(state, observation, gains, dt):
    error, reference = observation.error, observation.reference.velocity
    v, omega = reference.linear, reference.angular
    # K_x = K_θ = 2 ζ sqrt(ω_r² + g v_r²), K_y = g v_r
    k = 2.0 * gains.zeta * math.sqrt(omega * omega + gains.g * v * v)
    return state, BodyVelocity(
        v * math.cos(error.heading) + k * error.longitudinal,
        omega + gains.g * v * error.lateral + k * error.heading,
    )


LAW = Law('klancar', step, Gains)
