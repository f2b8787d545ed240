"""The reference's acceleration."""

import math

import pytest

from mobile_robot_control.quantities import BodyAcceleration
from mobile_robot_control.reference.cart import Placement, accelerated_at, reference_at
from mobile_robot_control.reference.curves import CURVES

PLACED = Placement(scale=1.3, period=9.0, phase=0.2, center=(1.0, -2.0), rotation=0.7)


@pytest.mark.parametrize('curve', CURVES)
def test_accelerations_are_the_slopes_of_the_velocities(curve):
    h = 1e-4
    for time in (0.0, 0.3, 2.0, 4.4, 8.9, 100.0):
        before, at, after = (accelerated_at(CURVES[curve], time + shift, PLACED) for shift in (-h, 0.0, h))
        assert at._replace(acceleration=BodyAcceleration(0.0, 0.0)) == reference_at(CURVES[curve], time, PLACED)
        slopes = [(b - a) / (2.0 * h) for a, b in zip(before.velocity, after.velocity, strict=True)]
        assert at.acceleration == pytest.approx(slopes, rel=1e-5, abs=1e-6)


def test_third_derivatives_are_taken_where_a_curve_gives_them():
    def with_third(s):
        # trifolium, x = (cos 2s + cos s)/2, y = (sin 2s - sin s)/2
        return CURVES['trifolium'](s)._replace(
            dddx=0.5 * (8.0 * math.sin(2.0 * s) + math.sin(s)), dddy=0.5 * (math.cos(s) - 8.0 * math.cos(2.0 * s)))

    for time in (0.0, 0.7, 3.3, 6.1):
        exact, differences, wrong = (accelerated_at(curve, time, PLACED).acceleration for curve in (
            with_third, CURVES['trifolium'], lambda s: with_third(s)._replace(dddx=10.0)))
        assert differences == pytest.approx(exact, rel=1e-7, abs=1e-8)
        # they are used: others give another acceleration
        assert abs(wrong.angular - exact.angular) > 0.1
