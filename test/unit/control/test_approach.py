"""The approach to a cart that waits: bounded, from anywhere, and at rest where it ends."""

import itertools
import math

import pytest

from mobile_robot_control.control.approach import FACING, Approach, approach_step, stands_still
from mobile_robot_control.control.compensation import carried_forward
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError
from mobile_robot_control.reference.waiting import ALIGNED, NEAR

SPEED = 0.2


@pytest.mark.parametrize(('arrived', 'error', 'after', 'command'), [
    # v = 1.5 d, where that is less
    (False, (0.1, 0.0, 1.0), False, (0.15, 0.0)),
    # a cart at the side is turned to first, at the speed over 0.25 m
    (False, (0.0, 1.0, 0.0), False, (0.0, 0.8)),
    (False, (0.0, -1.0, 0.0), False, (0.0, -0.8)),
    (False, (-1.0, 0.0, 0.0), False, (0.0, 0.8)),
    # v = 0.2 cos β, ω = 2.5 β
    (False, (0.99, 0.1, 0.0), False, (SPEED * 0.99 / math.hypot(0.99, 0.1), 2.5 * math.atan2(0.1, 0.99))),
    # at the cart: to its heading
    (False, (0.03, 0.03, 0.2), True, (0.0, 0.5)),
    (False, (0.03, 0.03, -3.0), True, (0.0, -0.8)),
    (False, (0.03, 0.03, 0.09), True, (0.0, 0.0)),
    # a robot that turns there is not sent back by a little
    (True, (-0.06, 0.0, 1.0), True, (0.0, 0.8)),
    (False, (-0.06, 0.0, 1.0), False, (0.0, 0.8)),
    (True, (0.09, 0.0, 1.0), False, (0.135, 0.0)),
])
def test_the_command_is_the_one_by_hand(arrived, error, after, command):
    state, found = approach_step(Approach(arrived), TrackingError(*error), SPEED)
    assert state == Approach(after)
    assert found == pytest.approx(command, abs=1e-12)


@pytest.mark.parametrize('start', [*itertools.product((-1.5, 1.5), (-1.5, 0.01, 1.5), (-1.5, math.pi))])
def test_the_robot_comes_to_rest_where_the_cart_goes_on(start):
    cart, pose, state = Pose(0.0, 0.0, 0.7), Pose(*start), Approach()
    for _ in range(1000):
        state, command = approach_step(state, tracking_error(cart, pose), SPEED)
        pose = carried_forward(pose, command, 0.02)
    assert command == BodyVelocity(0.0, 0.0)
    assert math.hypot(pose.x, pose.y) <= 0.08 < NEAR
    assert abs(tracking_error(cart, pose).heading) <= FACING < ALIGNED


@pytest.mark.parametrize(('velocity', 'still'), [((0.0, -0.0), True), ((0.0, 1e-9), False), ((1e-9, 0.0), False)])
def test_a_cart_stands_where_neither_velocity_is_other_than_zero(velocity, still):
    assert stands_still(Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(*velocity))) == still
