"""Bumpless transfer: gains and laws change without a jump of the command."""

import math

import pytest
from each import each_row
from observation import observed

from mobile_robot_control.control import bumpless_transfer
from mobile_robot_control.control.backstepping import BacksteppingGains
from mobile_robot_control.control.hybrid_backstepping import TRACKING, HybridState
from mobile_robot_control.control.laws import LAWS, PositionControl
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError

REFERENCE = Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.5, 0.2))
ERROR = TrackingError(0.2, 0.1, -0.3)
SEEN = observed(ERROR, REFERENCE)
DT = 0.05
GENTLE = PositionControl(backstepping=BacksteppingGains(p=1.0, q=1.0, f=1.0, g=1.0))
BRISK = PositionControl(backstepping=BacksteppingGains(p=2.0, q=1.0, f=4.0, g=3.0))


def settled(parameters):
    law = LAWS[parameters.controller_type]
    return law.step(law.start, SEEN, getattr(parameters, parameters.controller_type), DT)[1]


def test_new_gains_do_not_jump_and_the_difference_decays_in_a_fifth_of_a_second():
    running, before = bumpless_transfer.step(bumpless_transfer.begin(GENTLE, DT, under_way=False), SEEN, DT)
    running = bumpless_transfer.change(running, BRISK, DT)
    new = settled(BRISK)
    assert new != pytest.approx(before, rel=1e-3)
    for k in range(40):
        running, command = bumpless_transfer.step(running, SEEN, DT)
        # law + (last before - first after) exp(-t / 0.2 s)
        fade = math.exp(-k * DT / 0.2)
        expected = tuple(after + (last - after) * fade for last, after in zip(before, new, strict=True))
        assert command == pytest.approx(expected, rel=1e-12)


@each_row(('under_way', 'state'), [(False, HybridState()), (True, TRACKING)])
def test_a_hybrid_law_seeks_the_cart_only_at_the_start_of_a_run(under_way, state):
    hybrid = GENTLE._replace(controller_type='hybrid_backstepping')
    assert bumpless_transfer.begin(hybrid, DT, under_way).state == state


def test_new_gains_keep_the_state_of_the_law():
    hybrid = GENTLE._replace(controller_type='hybrid_backstepping')
    running, _ = bumpless_transfer.step(bumpless_transfer.begin(hybrid, DT, under_way=False), SEEN, DT)
    assert running.state.seek != 0.0
    changed = bumpless_transfer.change(running, hybrid._replace(backstepping=BRISK.backstepping), DT)
    assert changed.state == running.state
    assert changed.gains[0] == BRISK.backstepping


def test_a_change_before_the_first_step_starts_from_rest():
    # no command has been published yet: the robot stands
    running = bumpless_transfer.change(bumpless_transfer.begin(GENTLE, DT, under_way=False), BRISK, DT)
    _, command = bumpless_transfer.step(running, SEEN, DT)
    assert command == pytest.approx((0.0, 0.0), abs=1e-15)
