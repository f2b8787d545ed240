"""Limits of velocity and acceleration on the command."""

import math

import pytest
from each import each_row
from observation import observed

from mobile_robot_control.control import bumpless_transfer
from mobile_robot_control.control.command_limits import Limits, limit_command
from mobile_robot_control.control.laws import PositionControl
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError


@each_row(('limits', 'command', 'before', 'limited'), [
    (Limits(), (1e9, -1e9), (0.0, 0.0), (1e9, -1e9)),
    (Limits(linear_velocity=0.5), (0.7, 3.0), (0.0, 0.0), (0.5, 3.0)),
    (Limits(linear_velocity=0.5), (-0.7, 3.0), (0.0, 0.0), (-0.5, 3.0)),
    (Limits(angular_velocity=2.0), (0.7, -3.0), (0.0, 0.0), (0.7, -2.0)),
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
    assert limit_command(BodyVelocity(*command), BodyVelocity(*before), limits, 0.1) == pytest.approx(
        limited, rel=1e-15)


def test_limits_changed_live_hold_for_the_running_law():
    reference, error = Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(1.0, 1.0)), TrackingError(0.0, 0.0, 0.0)
    running = bumpless_transfer.begin(PositionControl(), 0.1, under_way=False)
    running, command = bumpless_transfer.step(running, observed(error, reference), 0.1)
    assert command == pytest.approx((1.0, 1.0))
    limits = Limits(linear_velocity=0.4, angular_acceleration=1.0)
    faster = observed(error, Reference(reference.pose, BodyVelocity(1.0, 5.0)))
    running = bumpless_transfer.change(running, PositionControl(limits=limits), 0.1)
    running, command = bumpless_transfer.step(running, faster, 0.1)
    assert command == pytest.approx((0.4, 1.0))
    # the step to 5 rad/s fades in within 0.2 s, faster than 1 rad/s² allows
    _, command = bumpless_transfer.step(running, faster, 0.1)
    assert command == pytest.approx((0.4, 1.1))
