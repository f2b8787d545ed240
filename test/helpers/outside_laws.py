"""Laws from outside, of the package's own elementary functions; the last one is of the C library's."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control import BodyVelocity, Field, Law, jitable
from mobile_robot_control.elementary import atan2, cos, exp, expm1, hypot, log1p, pow, sin, sin_cos, tan, tanh


class Gains(NamedTuple):
    """Of all four."""

    k: Annotated[float, Field('1/s', 'gain', above=0.0, search=(0.0, 5.0))] = 1.5
    power: Annotated[float, Field('', 'exponent', above=0.0, search=(0.0, 2.0))] = 0.7


@jitable
def saturated(state, observation, gains, dt):
    """Saturate smoothly."""
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    sine, cosine = sin_cos(e3)
    return state, BodyVelocity(v_r * cosine + tanh(gains.k * e1),
                               omega_r + 6.0 * v_r * e2 + tan(0.3 * sine) + gains.k * sine)


@jitable
def powered(state, observation, gains, dt):
    """Turn towards the cart by a power of its distance."""
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    far = hypot(e1, e2)
    aim = atan2(e2, e1 + 0.5)
    return state, BodyVelocity(v_r * cos(e3) + gains.k * e1 * pow(1.0 + far, gains.power - 1.0),
                               omega_r + 5.0 * v_r * sin(aim) + gains.k * e3)


@jitable
def fading(state, observation, gains, dt):
    """Let the feedback fade with the distance."""
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    share = exp(-e1 * e1 - e2 * e2)
    return state, BodyVelocity(v_r * cos(e3) + gains.k * log1p(abs(e1)) * (1.0 if e1 > 0.0 else -1.0),
                               omega_r + 6.0 * v_r * e2 * share + gains.k * (e3 - 0.1 * expm1(-e3 * e3)))


@jitable
def of_the_library(state, observation, gains, dt):
    """Follow with functions of `math`."""
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    return state, BodyVelocity(v_r * math.cos(e3) + gains.k * e1, omega_r + 6.0 * v_r * e2 + math.sin(e3))


OUTSIDE = tuple(Law(f'outside_{step.__name__}', step, Gains) for step in (saturated, powered, fading))
OF_THE_LIBRARY = Law('outside_of_the_library', of_the_library, Gains)
