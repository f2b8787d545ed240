"""Eq. (35): angles wrapped into (-pi, pi]."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobile_robot_control.angles import wrap_angle


@pytest.mark.parametrize(('angle', 'wrapped'), [
    (math.pi, math.pi), (-math.pi, math.pi), (4.0, 4.0 - 2.0 * math.pi), (-4.0, 2.0 * math.pi - 4.0),
    (-2.0 * math.pi, 0.0), (3.0 * math.pi, math.pi), (-7.5 * math.pi, 0.5 * math.pi),
])
def test_angles_wrapped_by_hand(angle, wrapped):
    assert wrap_angle(angle) == pytest.approx(wrapped, abs=1e-14)


@pytest.mark.parametrize('angle', [math.nextafter(math.pi, 0.0), math.nextafter(-math.pi, 0.0), 5e-324, -1e-17, 0.1])
def test_an_angle_already_inside_comes_back_bit_for_bit(angle):
    assert wrap_angle(angle) == angle


@pytest.mark.parametrize('angle', [-9.0, -3.0, -0.5, 0.5, 3.0, 9.0, 100.0])
def test_equation_35(angle):
    # f(x) = 2 atan(tan(x/2)), away from the odd multiples of pi where it loses precision
    assert wrap_angle(angle) == pytest.approx(2.0 * math.atan(math.tan(angle / 2.0)), abs=1e-12)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_wrapping_leads_into_the_interval_however_large(angle):
    assert -math.pi < wrap_angle(angle) <= math.pi


@given(st.floats(-1e6, 1e6))
def test_wrapping_is_idempotent_and_keeps_the_direction(angle):
    assert wrap_angle(wrap_angle(angle)) == wrap_angle(angle)
    # the float 2 pi is short of the number by 2.4e-16, once a turn
    turns = (wrap_angle(angle) - angle) / (2.0 * math.pi)
    assert abs(turns - round(turns)) < 1e-15 * (1.0 + abs(angle) / (2.0 * math.pi))


@pytest.mark.parametrize('angle', [math.inf, -math.inf, math.nan])
def test_nonfinite_angles_have_no_wrapped_value(angle):
    assert math.isnan(wrap_angle(angle))
