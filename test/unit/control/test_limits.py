"""Limits of a command, component by component."""

import math

import pytest

from mobile_robot_control.control.limits import Limits, limit_command
from mobile_robot_control.quantities import BodyVelocity


@pytest.mark.parametrize(('limits', 'command', 'before', 'limited'), [
    (Limits(), (1e9, -1e9), (0.0, 0.0), (1e9, -1e9)),
    (Limits(linear_velocity=0.5), (-0.7, 3.0), (0.0, 0.0), (-0.5, 3.0)),
    (Limits(angular_velocity=2.0), (0.7, 3.0), (0.0, 0.0), (0.7, 2.0)),
    (Limits(linear_acceleration=1.0), (0.7, 3.0), (0.2, 0.0), (0.3, 3.0)),
    (Limits(linear_acceleration=1.0), (-0.7, 3.0), (0.2, 0.0), (0.1, 3.0)),
    (Limits(angular_acceleration=5.0), (0.7, 3.0), (0.2, 1.0), (0.7, 1.5)),
    (Limits(linear_acceleration=1.0), (0.25, 3.0), (0.2, 0.0), (0.25, 3.0)),
    # beyond what a message may hold, limits or none
    (Limits(), (1e15, -math.inf), (0.0, 0.0), (1e12, -1e12)),
    (Limits(linear_velocity=1e15), (-1e15, 0.0), (0.0, 0.0), (-1e12, 0.0)),
    # lowered while the robot is faster than that: the velocity limit wins
    (Limits(linear_velocity=0.5, linear_acceleration=1.0), (2.0, 0.0), (2.0, 0.0), (0.5, 0.0)),
])
def test_each_component_is_limited_by_itself(limits, command, before, limited):
    found = limit_command(BodyVelocity(*command), BodyVelocity(*before), limits, 0.1)
    assert found == pytest.approx(limited, rel=1e-15)
