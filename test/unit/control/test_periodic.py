"""The law that is periodic in the heading error."""

import math

import pytest
from observation import observed

from mobile_robot_control.control import periodic, ramsete
from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.periodic import PeriodicGains
from mobile_robot_control.control.ramsete import RamseteGains
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError

GAINS = PeriodicGains(g=4.0, zeta=0.5)


def ask(error, velocity=(2.0, 3.0), law=periodic, gains=GAINS):
    return law.step(NoState(), observed(
        TrackingError(*error), Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(*velocity))), gains, 0.01)[1]


def test_the_law_with_hand_numbers():
    # k = 2 * 0.5 * sqrt(3² + 4 * 2²) = 5, cos⁴(pi/4) = 1/4
    assert ask((0.1, 0.2, 0.5 * math.pi)) == pytest.approx((0.5, 3.0 + 4.0 * 2.0 * 0.25 * 0.2 + 5.0), rel=1e-15)


def test_facing_away_is_an_equilibrium_without_a_jump():
    assert ask((0.1, 0.2, math.pi)) == pytest.approx((-1.5, 3.0), abs=1e-14)
    assert ask((0.1, 0.2, -math.pi)) == pytest.approx(ask((0.1, 0.2, math.pi)), abs=1e-14)


def test_near_the_cart_it_is_the_law_of_samson():
    small = (1e-4, -2e-4, 1.5e-4)
    samson = ask(small, law=ramsete, gains=RamseteGains(b=4.0, zeta=0.5))
    # they differ in the third order of the errors
    assert ask(small) == pytest.approx(samson, abs=1e-10)
    assert ask((1e-4, -2e-4, 1.0)) != pytest.approx(samson, abs=1e-3)
