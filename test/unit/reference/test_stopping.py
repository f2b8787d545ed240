"""A planned stop on a path."""

import numpy as np
import pytest
from helpers.timed_paths import RECTANGLE, TIMING, WAYPOINTS, request, smooth_shape, used_at
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from mobile_robot_control.reference.motion import Motion, plan
from mobile_robot_control.reference.path_parameters import Drive
from mobile_robot_control.reference.planned_path import plan_spans
from mobile_robot_control.reference.stopping import STANDS, stop


@given(WAYPOINTS, st.floats(0.02, 0.98), st.sampled_from([0.3, 0.6]))
@hypothesis_settings(max_examples=4)
def test_a_stop_anywhere_goes_on_from_the_motion_before_and_keeps_the_limits(points, share, torque):
    timing = TIMING._replace(max_wheel_torque=torque)
    path = plan_spans(smooth_shape(points), timing, Drive())
    time = share * path.period
    before = path.accelerated(time)
    stopped = stop(Motion([path]).rest(time), request(RECTANGLE, timing=timing), before)
    at = stopped.accelerated(0.0)
    assert (*at.pose, *at.velocity) == pytest.approx((*before.pose, *before.velocity), abs=1e-6)
    assert stopped.accelerated(stopped.period).velocity == (0.0, 0.0)
    # as soon as the limits allow: at most half of the longest braking distance later
    assert stopped.length <= path.length * (1.0 - share) + 1.0
    for moment in np.linspace(0.0, stopped.period, 50):
        assert max(used_at(stopped, moment, timing, Drive()).values()) <= 1.021


@pytest.mark.parametrize('left', [0.1, 0.02, 0.003])
def test_a_stop_of_a_cart_that_stops_already_takes_no_longer(left):
    path = plan(request([(0.0, 0.0), (1.0, 0.2), (4.0, 0.0)]))
    asked = request(RECTANGLE)
    stopped = stop(path.rest(3.0), asked, path.accelerated(3.0))
    at = stopped.period - left
    assert stopped.accelerated(at).velocity.linear > STANDS
    assert stop(stopped.rest(at), asked, stopped.accelerated(at)).period < 1.3 * left
