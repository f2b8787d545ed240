"""Properties of the sampled velocity loop, for drawn gains and rates."""

import chapter
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from mobile_robot_control.control.velocity_pi import VelocityGains
from mobile_robot_control.control.velocity_stability import instability, spectral_radius
from mobile_robot_control.model.robot import Robot

VELOCITY_GAINS = st.builds(VelocityGains, k1=st.floats(0.01, 200.0), ti1=st.floats(0.01, 100.0),
                           k2=st.floats(0.01, 60.0), ti2=st.floats(0.01, 100.0))


def state_matrix(gains, rate, delay):
    """
    One period of the sampled loop in wheel coordinates: wheel velocities, integrals, torques on their way.

    Eq. (13)-(14) under a hold by the exponential series of the augmented matrix, Eq. (16)-(17) and (5)-(7), (19).
    """
    dt, r, R = 1.0 / rate, chapter.r, chapter.R
    inverse = np.linalg.inv(np.array([[chapter.A, chapter.B], [chapter.B, chapter.A]]))
    augmented = np.zeros((4, 4))
    augmented[:2, :2], augmented[:2, 2:] = -chapter.K * inverse, inverse
    held = expm(augmented * dt)
    to_body = np.array([[r / 2, r / 2], [r / (2 * R), -r / (2 * R)]])
    to_wheels = np.array([[1.0, 1.0], [1.0, -1.0]])
    proportional = np.diag([gains.k1, gains.k2]) * R / r
    integral = np.diag([gains.k1 / gains.ti1, gains.k2 / gains.ti2]) * R / r * dt
    # the requested torque: of the errors -to_body w, and of the integrals
    from_wheels, from_integrals = -to_wheels @ proportional @ to_body, to_wheels
    size = 4 + 2 * delay
    matrix = np.zeros((size, size))
    matrix[:2, :2] = held[:2, :2]
    matrix[2:4, :2], matrix[2:4, 2:4] = -integral @ to_body, np.eye(2)
    if delay == 0:
        matrix[:2, :2] += held[:2, 2:] @ from_wheels
        matrix[:2, 2:4] = held[:2, 2:] @ from_integrals
    else:
        matrix[:2, 4:6] = held[:2, 2:]
        for k in range(delay - 1):
            matrix[4 + 2 * k:6 + 2 * k, 6 + 2 * k:8 + 2 * k] = np.eye(2)
        matrix[-2:, :2], matrix[-2:, 2:4] = from_wheels, from_integrals
    return matrix


@given(VELOCITY_GAINS, st.floats(20.0, 20000.0), st.integers(0, 3))
def test_the_spectral_radius_is_that_of_the_state_matrix(gains, rate, delay):
    expected = max(abs(np.linalg.eigvals(state_matrix(gains, rate, delay))))
    assert spectral_radius(gains, Robot(), rate, delay) == pytest.approx(expected, rel=1e-7)


@settings(max_examples=50)
@given(VELOCITY_GAINS, st.floats(20.0, 20000.0), st.booleans())
def test_instability_is_reported_exactly_where_the_radius_reaches_1(gains, rate, lockstep):
    delays = (0,) if lockstep else (1, 2)
    radius = max(max(abs(np.linalg.eigvals(state_matrix(gains, rate, delay)))) for delay in delays)
    if abs(radius - 1.0) > 1e-7:
        assert bool(instability(gains, Robot(), rate, lockstep)) == (radius > 1.0)
