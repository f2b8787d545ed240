"""Properties of wrapped angles, for drawn angles."""

import math

from hypothesis import given
from hypothesis import strategies as st

from mobile_robot_control.angles import wrap_angle

ANGLES = st.floats(-1e6, 1e6)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_wrapped_angles_lie_in_the_interval_however_large(angle):
    assert -math.pi < wrap_angle(angle) <= math.pi


@given(ANGLES)
def test_wrapping_is_idempotent(angle):
    assert wrap_angle(wrap_angle(angle)) == wrap_angle(angle)


@given(ANGLES)
def test_wrapping_keeps_the_direction(angle):
    # the float 2 pi is short of the number by 2.4e-16, once a turn
    turns = abs(angle) / (2.0 * math.pi)
    difference = wrap_angle(angle) - angle
    assert abs(difference / (2.0 * math.pi) - round(difference / (2.0 * math.pi))) < 1e-15 * (1.0 + turns)
