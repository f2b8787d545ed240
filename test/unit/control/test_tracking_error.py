"""Eq. (23), (34) and (35): tracking error, distance and bearing."""

import math

import pytest
from each import each_row

from mobile_robot_control.control.tracking_error import bearing, distance, tracking_error
from mobile_robot_control.quantities import Pose, TrackingError


@each_row(('reference', 'pose', 'error'), [
    ((2.0, 1.0, 0.0), (1.0, 1.0, 0.0), (1.0, 0.0, 0.0)),
    # facing up: what lies 3 up and 2 to the right is 3 ahead and -2 to the left
    ((3.0, 5.0, math.pi), (1.0, 2.0, 0.5 * math.pi), (3.0, -2.0, 0.5 * math.pi)),
    # facing back
    ((1.0, 1.0, 0.0), (0.0, 0.0, math.pi), (-1.0, -1.0, math.pi)),
    # at 30 degrees: cos 30 * 2 + sin 30 * 1, -sin 30 * 2 + cos 30 * 1
    ((2.0, 1.0, 0.7), (0.0, 0.0, math.pi / 6), (2.2320508075688772, -0.1339745962155614, 0.7 - math.pi / 6)),
])
def test_equation_23_with_hand_numbers(reference, pose, error):
    assert tracking_error(Pose(*reference), Pose(*pose)) == pytest.approx(error, abs=1e-15)


def test_equation_34_distance_by_hand():
    assert distance(TrackingError(3.0, -4.0, 1.0)) == 5.0
    assert distance(TrackingError(0.0, 0.0, 3.0)) == 0.0


@each_row(('e1', 'e2', 'expected'), [
    (1.0, 0.0, 0.0),
    (1.0, 1.0, 0.25 * math.pi),
    (0.0, 2.0, 0.5 * math.pi),
    (0.0, -2.0, -0.5 * math.pi),
    (-1.0, -1.0, -0.75 * math.pi),
])
def test_equation_34_bearing_by_hand(e1, e2, expected):
    assert bearing(TrackingError(e1, e2, 2.0)) == pytest.approx(expected, abs=1e-15)


def test_no_bearing_on_the_cart():
    assert bearing(TrackingError(0.0, 0.0, 0.0)) == 0.0
    assert bearing(TrackingError(0.0, 0.999e-9, 0.0)) == 0.0
    assert bearing(TrackingError(-0.999e-9, 0.0, 0.0)) == 0.0
    assert bearing(TrackingError(0.0, 1.001e-9, 0.0)) == 0.5 * math.pi
    assert bearing(TrackingError(-1.001e-9, 0.0, 0.0)) == math.pi
