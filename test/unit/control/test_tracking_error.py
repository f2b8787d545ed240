"""Eq. (23) and (34): tracking error, distance and bearing."""

import math

import pytest

from mobile_robot_control.control.tracking_error import bearing, distance, tracking_error
from mobile_robot_control.quantities import Pose, TrackingError


@pytest.mark.parametrize(('reference', 'pose', 'error'), [
    # facing up: what lies 3 up and 2 to the right is 3 ahead and -2 to the left
    ((3.0, 5.0, math.pi), (1.0, 2.0, 0.5 * math.pi), (3.0, -2.0, 0.5 * math.pi)),
    # facing back
    ((1.0, 1.0, 0.0), (0.0, 0.0, math.pi), (-1.0, -1.0, math.pi)),
    # at 30 degrees: cos 30 * 2 + sin 30 * 1, -sin 30 * 2 + cos 30 * 1
    ((2.0, 1.0, 0.7), (0.0, 0.0, math.pi / 6), (2.2320508075688772, -0.1339745962155614, 0.7 - math.pi / 6)),
])
def test_equation_23_with_hand_numbers(reference, pose, error):
    assert tracking_error(Pose(*reference), Pose(*pose)) == pytest.approx(error, abs=1e-15)


@pytest.mark.parametrize(('e1', 'e2', 'far', 'expected'), [
    (3.0, -4.0, 5.0, -0.9272952180016122),
    (0.0, 2.0, 2.0, 0.5 * math.pi),
    (-1.0, -1.0, math.sqrt(2.0), -0.75 * math.pi),
    # on the cart there is no bearing
    (0.0, 0.0, 0.0, 0.0),
    (0.0, 0.999e-9, 0.999e-9, 0.0),
    (-1.001e-9, 0.0, 1.001e-9, math.pi),
])
def test_equation_34_distance_and_bearing_by_hand(e1, e2, far, expected):
    error = TrackingError(e1, e2, 2.0)
    assert (distance(error), bearing(error)) == pytest.approx((far, expected), abs=1e-15)
