"""The backstepping law: Eq. (25), (26) and (28), with deviations 2 and 3."""

import math

import pytest
from helpers.observation import ask

from mobile_robot_control.control import backstepping
from mobile_robot_control.control.backstepping import BacksteppingGains, lyapunov, lyapunov_rate
from mobile_robot_control.parameters.declaration import ParameterError, build
from mobile_robot_control.quantities import TrackingError
from mobile_robot_control.settings.configure import configure

GAINS = BacksteppingGains(p=1.5, q=0.5, alpha=1.0, f=2.0, g=3.0)
ERROR = TrackingError(0.3, -0.4, math.pi / 6)
STEEP = GAINS._replace(alpha=2.0)


@pytest.mark.parametrize(('alpha', 'u1', 'u2'), [
    # by hand: u1 = -1.5 * 0.3 * 2; u2 = -(2 * 1.5 / 0.5) * 2 * -0.4 - 0.5 * 0.5 * 3
    (1.0, -0.9, 4.05),
    # (e1² + e2²)^0.5 = 0.5: u2 = (2 * 1.5 * 1.5 / 0.5) * 0.5 * 2 * 0.4 - 0.75
    (1.5, -1.35, 2.85),
    # (e1² + e2²)^1 = 0.25: u2 = -(2 * 2 * 1.5 / 0.5) * 0.25 * 2 * -0.4 - 0.75
    (2.0, -1.8, 1.65),
])
def test_equation_25_with_hand_numbers(alpha, u1, u2):
    _, command = ask(backstepping, ERROR, (2.0, 0.5), GAINS._replace(alpha=alpha))
    assert command == pytest.approx((math.sqrt(3.0) - u1, 0.5 - u2), rel=1e-14)


def test_deviation_3_alpha_is_1_by_default_and_may_be_1_but_not_less():
    assert BacksteppingGains().alpha == build(BacksteppingGains, {'alpha': 1}).alpha == 1.0
    with pytest.raises(ParameterError, match=r'backstepping\.alpha = 0\.99 is not allowed; it must be at least 1\.0'):
        configure({'position_controller': {'backstepping.alpha': 0.99}})


def test_equation_26_with_hand_numbers():
    # 1.5 * 0.25 + 0.5 * (1 - cos 30), 1.5 * 0.25² + the same
    heading = 0.5 * (1.0 - math.sqrt(3.0) / 2.0)
    assert lyapunov(ERROR, GAINS) == pytest.approx(0.375 + heading, rel=1e-14)
    assert lyapunov(ERROR, STEEP) == pytest.approx(0.09375 + heading, rel=1e-14)


def test_deviation_2_equation_28_may_be_zero_away_from_the_cart():
    # -2 * 2.25 * 0.09 * 2 - 0.25 * 0.25 * 3, and -2 * 4 * 2.25 * 0.09 * 0.25 * 2 - 0.1875
    assert lyapunov_rate(ERROR, GAINS) == lyapunov_rate(ERROR, STEEP) == pytest.approx(-0.81 - 0.1875, rel=1e-14)
    for heading in (0.0, math.pi):
        assert lyapunov_rate(TrackingError(0.0, 0.7, heading), GAINS) == pytest.approx(0.0, abs=1e-30)
