"""A position law that the package has never seen, with gains named like those of others."""

import math
from typing import Annotated, NamedTuple

from mobile_robot_control import BodyVelocity, Field, Law, jitable


class KanayamaGains(NamedTuple):
    p: Annotated[float, Field('1/s', 'longitudinal gain', above=0.0, live=True, search=(0.0, 20.0))] = 4.8
    a: Annotated[float, Field('1/m²', 'lateral gain', above=0.0, live=True, search=(0.0, 200.0))] = 60.0
    k1: Annotated[float, Field('1/m', 'heading gain', above=0.0, live=True, search=(0.0, 50.0))] = 12.0
    b1: Annotated[float, Field('', 'weight of both', above=0.0, live=True)] = 1.0


@jitable
def step(state, observation, gains, dt):
    e1, e2, e3 = observation.error
    v_r, omega_r = observation.reference.velocity
    return state, BodyVelocity(v_r * math.cos(e3) + gains.p * e1,
                               omega_r + v_r * (gains.a * e2 + gains.k1 * math.sin(e3)) * gains.b1)


LAW = Law('my_kanayama', step, KanayamaGains)
