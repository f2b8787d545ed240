"""The backstepping law: Eq. (24)-(28), with deviations 2 and 3."""

import math

import pytest
from observation import observed

from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.control import backstepping
from mobile_robot_control.control.backstepping import BacksteppingGains, lyapunov, lyapunov_rate
from mobile_robot_control.control.law import NoState
from mobile_robot_control.parameters.checking import ParameterError, build
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError

GAINS = BacksteppingGains(p=1.5, q=0.5, alpha=1.0, f=2.0, g=3.0)
ERROR = TrackingError(0.3, -0.4, math.pi / 6)
STEEP = BacksteppingGains(p=1.5, q=0.5, alpha=2.0, f=2.0, g=3.0)


def command(error, gains, v_r=2.0, omega_r=0.5):
    reference = Reference(Pose(9.0, 9.0, 9.0), BodyVelocity(v_r, omega_r))
    state, velocity = backstepping.step(NoState(), observed(error, reference), gains, 0.01)
    assert state == NoState()
    return velocity


def test_equation_25_with_hand_numbers():
    # u1 = -1.5 * 0.3 * 2 = -0.9; u2 = -(2 * 1.5 / 0.5) * 2 * -0.4 - 0.5 * 0.5 * 3 = 4.05
    assert command(ERROR, GAINS) == pytest.approx((math.sqrt(3.0) + 0.9, 0.5 - 4.05), rel=1e-14)


def test_equation_25_with_an_alpha_above_1():
    # (e1² + e2²)^1 = 0.25: u1 = -1.8; u2 = -(2 * 2 * 1.5 / 0.5) * 0.25 * 2 * -0.4 - 0.75 = 1.65
    assert command(ERROR, STEEP) == pytest.approx((math.sqrt(3.0) + 1.8, 0.5 - 1.65), rel=1e-14)
    # alpha = 1.5: u1 = -1.35; u2 = (2 * 1.5 * 1.5 / 0.5) * 0.5 * 2 * 0.4 - 0.75 = 2.85
    between = GAINS._replace(alpha=1.5)
    assert command(ERROR, between) == pytest.approx((math.sqrt(3.0) + 1.35, 0.5 - 2.85), rel=1e-14)


def test_deviation_3_alpha_is_1_by_default_and_may_be_1_but_not_less():
    assert BacksteppingGains().alpha == 1.0
    assert build(BacksteppingGains, {'alpha': 1}).alpha == 1.0
    with pytest.raises(ParameterError, match=r'alpha = 0\.99 is not allowed; it must be at least 1\.0'):
        build(BacksteppingGains, {'alpha': 0.99})
    with pytest.raises(ParameterError, match=r'backstepping\.alpha = 0\.5'):
        configure({'position_controller': {'backstepping.alpha': 0.5}})


def test_equation_26_with_hand_numbers():
    # 1.5 * 0.25 + 0.5 * (1 - cos 30), 1.5 * 0.25² + the same
    heading = 0.5 * (1.0 - math.sqrt(3.0) / 2.0)
    assert lyapunov(ERROR, GAINS) == pytest.approx(0.375 + heading, rel=1e-14)
    assert lyapunov(ERROR, STEEP) == pytest.approx(0.09375 + heading, rel=1e-14)
    assert lyapunov(TrackingError(0.0, 0.0, 0.0), GAINS) == 0.0
    assert lyapunov(TrackingError(0.0, 0.0, math.pi), GAINS) == pytest.approx(1.0, rel=1e-14)


def test_equation_28_with_hand_numbers():
    # -2 * 2.25 * 0.09 * 2 - 0.25 * 0.25 * 3
    assert lyapunov_rate(ERROR, GAINS) == pytest.approx(-0.81 - 0.1875, rel=1e-14)
    # -2 * 4 * 2.25 * 0.09 * 0.25 * 2 - 0.1875
    assert lyapunov_rate(ERROR, STEEP) == pytest.approx(-0.81 - 0.1875, rel=1e-14)


def test_deviation_2_equation_28_may_be_zero_away_from_the_cart():
    assert lyapunov_rate(TrackingError(0.0, 0.7, 0.0), GAINS) == 0.0
    assert lyapunov_rate(TrackingError(0.0, 0.7, math.pi), GAINS) == pytest.approx(0.0, abs=1e-30)
