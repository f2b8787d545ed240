"""A new path in the midst of another one."""

import math

import numpy as np
import pytest
from helpers.timed_paths import TIMING, request, shape_of, used_at
from hypothesis import assume, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.reference.joining import join
from mobile_robot_control.reference.motion import Motion, plan
from mobile_robot_control.reference.path_parameters import Drive
from mobile_robot_control.reference.planned_path import plan_spans


@given(st.floats(0.05, 0.95), st.floats(-0.3, 0.3), st.floats(-0.4, 0.4), st.floats(0.0, 0.3))
@hypothesis_settings(max_examples=6)
def test_a_new_path_goes_on_from_the_motion_before_or_is_refused(share, turn, aside, ahead):
    path = plan_spans(shape_of([(0.0, 0.0), (1.5, 0.0), (2.5, 0.8), (4.0, 0.8)], tolerance=0.2), TIMING, Drive())
    before = path.accelerated(share * path.period)
    x, y, heading = before.pose
    cos, sin = math.cos(heading + turn), math.sin(heading + turn)
    points = [(x + along * cos - aside * sin, y + along * sin + aside * cos) for along in (ahead, 1.0, 2.5)]
    try:
        joined = join(request(points), before, Motion([path]).rest(share * path.period))
    except ParameterError:
        # too far, or too sharp for the speed
        assume(False)
    at = joined.accelerated(0.0)
    assert (*at.pose, *at.velocity) == pytest.approx((*before.pose, *before.velocity), abs=1e-6)
    assert joined.reference(joined.period).pose[:2] == pytest.approx(points[-1])
    for moment in np.linspace(0.0, joined.period, 50):
        assert max(used_at(joined, moment, TIMING, Drive()).values()) <= 1.021


def test_a_path_with_long_segments_changes_nothing_wherever_the_cart_is_when_it_is_sent_again():
    bent = request([(0.0, 0.0), (2.0, 0.0), (3.0, 1.0)])
    motion = plan(bent)
    for time in np.linspace(0.0, motion.period, 20, endpoint=False):
        assert join(bent, motion.accelerated(time), motion.rest(time)) is None


def test_a_path_far_from_the_cart_and_one_that_comes_too_late_for_its_speed_are_refused():
    path = Motion([plan_spans(shape_of([(0.0, 0.0), (4.0, 0.0)]), TIMING, Drive())])
    before, rest = path.accelerated(4.0), path.rest(4.0)
    x = before.pose.x
    with pytest.raises(ParameterError, match=r'begins 0\.6 m from the cart, .* near the cart, at \(1\.98, 0\)'):
        join(request([(x + 0.6, 0.0), (x + 2.0, 0.0)]), before, rest)
    with pytest.raises(ParameterError, match=r'no motion from here keeps the limits .* at its start is too fast'):
        join(request([(x, 0.0), (x + 0.1, 0.05), (x + 0.1, 2.0)]), before, rest)
