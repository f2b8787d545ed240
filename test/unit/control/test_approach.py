"""The approach to a cart that waits: bounded, from anywhere, and at rest where it ends."""

import itertools
import math

import pytest
from each import each_row

from mobile_robot_control.control.approach import ARRIVED, FACING, Approach, approach_step, stands_still
from mobile_robot_control.control.latency import carried_forward
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError
from mobile_robot_control.reference.waiting import ALIGNED, NEAR

SPEED, DT = 0.2, 0.02
@each_row(('error', 'command'), [
    ((2.0, 0.0, 1.0), (SPEED, 0.0)),
    # v = 1.5 d, where that is less
    ((0.1, 0.0, 1.0), (0.15, 0.0)),
    # a cart at the side is turned to first, at the speed over 0.25 m
    ((0.0, 1.0, 0.0), (0.0, 0.8)),
    ((0.0, -1.0, 0.0), (0.0, -0.8)),
    ((-1.0, 0.0, 0.0), (0.0, 0.8)),
    # v = 0.2 cos β, ω = 2.5 β
    ((0.99, 0.1, 0.0), (SPEED * 0.99 / math.hypot(0.99, 0.1), 2.5 * math.atan2(0.1, 0.99))),
    # at the cart: to its heading
    ((0.03, 0.03, 0.2), (0.0, 0.5)),
    ((0.03, 0.03, -3.0), (0.0, -0.8)),
    ((0.03, 0.03, 0.09), (0.0, 0.0)),
])
def test_the_command_is_the_one_by_hand(error, command):
    _, found = approach_step(Approach(), TrackingError(*error), SPEED)
    assert found == pytest.approx(command, abs=1e-12)


def test_a_robot_that_turns_at_the_cart_is_not_sent_back_by_a_little():
    near = TrackingError(-0.06, 0.0, 1.0)
    assert approach_step(Approach(arrived=True), near, SPEED) == (Approach(arrived=True), BodyVelocity(0.0, 0.8))
    assert not approach_step(Approach(arrived=False), near, SPEED)[0].arrived
    assert not approach_step(Approach(arrived=True), TrackingError(-0.09, 0.0, 1.0), SPEED)[0].arrived


@each_row('place', itertools.product((-1.5, 0.0, 1.5), (-1.5, 0.01, 1.5)))
@each_row('heading', [-1.5, math.pi])
def test_the_robot_comes_to_rest_where_the_cart_goes_on(place, heading):
    cart, pose, state = Pose(0.0, 0.0, 0.7), Pose(*place, heading), Approach()
    for _ in range(2000):
        state, command = approach_step(state, tracking_error(cart, pose), SPEED)
        pose = carried_forward(pose, command, DT)
    assert command == BodyVelocity(0.0, 0.0)
    assert math.hypot(pose.x, pose.y) <= 0.08 < NEAR
    assert abs(tracking_error(cart, pose).heading) <= FACING < ALIGNED
    assert ARRIVED < NEAR


def test_a_cart_stands_where_neither_velocity_is_other_than_zero():
    pose = Pose(0.0, 0.0, 0.0)
    assert stands_still(Reference(pose, BodyVelocity(0.0, -0.0)))
    assert not stands_still(Reference(pose, BodyVelocity(0.0, 1e-9)))
    assert not stands_still(Reference(pose, BodyVelocity(1e-9, 0.0)))
