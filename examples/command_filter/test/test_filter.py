"""The filter by itself; it needs no ROS."""

import pytest
from command_filter.node import NODE, Parameters


def test_it_reaches_a_share_of_63_percent_after_its_time_constant():
    state = NODE.start
    for _ in range(5):
        state, outputs = NODE.step(state, {'cmd_vel_raw': (0.4, -1.0)}, Parameters(time_constant=0.05), 0.01)
    assert outputs == {'cmd_vel': state}
    assert state == pytest.approx((0.4 * 0.6321, -0.6321), rel=1e-4)
