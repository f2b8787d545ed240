"""A law in a run: changed without a jump of the command, limited, and leading it."""

import math

import pytest
from helpers.observation import observed

from mobile_robot_control.control.backstepping import BacksteppingGains
from mobile_robot_control.control.bumpless_transfer import begin, change, step
from mobile_robot_control.control.compensation import Feedforward
from mobile_robot_control.control.hybrid_backstepping import TRACKING, HybridState
from mobile_robot_control.control.laws import PositionControl
from mobile_robot_control.control.limits import Limits
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose, Reference, TrackingError

DT = 0.05
BRISK = PositionControl(backstepping=BacksteppingGains(p=2.0, q=1.0, f=4.0, g=3.0))
GENTLE = PositionControl(backstepping=BacksteppingGains(p=1.0, q=1.0, f=1.0, g=1.0))
HYBRID = GENTLE._replace(controller_type='hybrid_backstepping')


def seen(error, velocity):
    return observed(TrackingError(*error), Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(*velocity)))


SEEN = seen((0.2, 0.1, -0.3), (0.5, 0.2))
ON_THE_CART = seen((0.0, 0.0, 0.0), (0.5, 0.2))


def test_new_gains_do_not_jump_and_the_difference_decays_in_a_fifth_of_a_second():
    running, before = step(begin(GENTLE, DT, under_way=False), SEEN, DT)
    running = change(running, BRISK, DT)
    _, new = step(begin(BRISK, DT, under_way=False), SEEN, DT)
    assert new != pytest.approx(before, rel=1e-3)
    for k in range(40):
        running, command = step(running, SEEN, DT)
        # law + (last before - first after) exp(-t / 0.2 s)
        fade = math.exp(-k * DT / 0.2)
        expected = tuple(after + (last - after) * fade for last, after in zip(before, new, strict=True))
        assert command == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(('under_way', 'state'), [(False, HybridState()), (True, TRACKING)])
def test_a_hybrid_law_seeks_the_cart_only_at_the_start_of_a_run_and_keeps_its_state_under_new_gains(under_way, state):
    running = begin(HYBRID, DT, under_way)
    assert running.state.law == state
    running, _ = step(running, SEEN, DT)
    changed = change(running, HYBRID._replace(backstepping=BRISK.backstepping), DT)
    assert (changed.state, changed.gains[0]) == (running.state, BRISK.backstepping)


def test_a_change_before_the_first_step_starts_from_rest():
    # no command has been published yet: the robot stands
    _, command = step(change(begin(GENTLE, DT, under_way=False), BRISK, DT), SEEN, DT)
    assert command == pytest.approx((0.0, 0.0), abs=1e-15)


def test_limits_changed_live_hold_for_the_running_law():
    running, _ = step(begin(PositionControl(), 0.1, under_way=False), seen((0.0, 0.0, 0.0), (1.0, 1.0)), 0.1)
    limits, faster = Limits(linear_velocity=0.4, angular_acceleration=1.0), seen((0.0, 0.0, 0.0), (1.0, 5.0))
    running, command = step(change(running, PositionControl(limits=limits), 0.1), faster, 0.1)
    assert command == pytest.approx((0.4, 1.0))
    # the step to 5 rad/s fades in within 0.2 s, faster than 1 rad/s² allows
    assert step(running, faster, 0.1)[1] == pytest.approx((0.4, 1.1))


def test_the_command_leads_before_its_limits_and_a_change_of_the_lead_is_no_jump():
    control = PositionControl(feedforward=Feedforward((0.15, 0.1), (0.05, 0.15)))
    acceleration = BodyAcceleration(1.0, -0.5)
    begun = begin(control, 0.02, under_way=False)
    running, command = step(begun, ON_THE_CART, 0.02, acceleration)
    assert command == pytest.approx((0.5 + 0.2 * 1.0, 0.2 - 0.25 * 0.5))
    slow = begun._replace(limits=Limits(linear_velocity=0.6))
    assert step(slow, ON_THE_CART, 0.02, acceleration)[1].linear == 0.6
    assert step(begun, ON_THE_CART, 0.02)[1] == pytest.approx((0.5, 0.2))
    running = change(running, PositionControl(), 0.02)
    for _ in range(100):
        last = command
        running, command = step(running, ON_THE_CART, 0.02, acceleration)
        assert abs(command.linear - last.linear) < 0.025
    assert command == pytest.approx((0.5, 0.2), abs=1e-4)
