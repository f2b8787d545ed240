"""The approach through the law runner: within the limits of the command, and the law goes on from it smoothly."""

import math
import types

import pytest
from each import each_row

from mobile_robot_control.control.command_limits import Limits
from mobile_robot_control.control.laws import LAWS, PositionControl
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose, Reference, TrackingError
from mobile_robot_control.ros.nodes.law_runner import LawRunner

DT = 0.02
AHEAD = TrackingError(1.0, 0.0, 0.0)
NODE = types.SimpleNamespace(get_logger=lambda: types.SimpleNamespace(error=lambda text: None))


def driving(error):
    return Observation(error, Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.4, 0.1)), BodyVelocity(0.0, 0.0))


def test_the_approach_keeps_the_limits_of_the_command():
    control = PositionControl(limits=Limits(linear_velocity=0.15, linear_acceleration=2.0))
    law = LawRunner(NODE, control, DT, lambda: None)
    linear = [law.approach(AHEAD, 0.2, control).linear for _ in range(6)]
    assert linear == pytest.approx([0.04, 0.08, 0.12, 0.15, 0.15, 0.15])


# the command of dynamic feedback linearisation is a state, which an error that stays moves on
@each_row('name', [name for name in LAWS if name != 'dynamic_feedback_linearization'])
def test_the_law_goes_on_from_the_present_command(name):
    control = PositionControl(controller_type=name)
    law = LawRunner(NODE, control, DT, lambda: None)
    last = law.approach(AHEAD, 0.2, control)
    assert last == (0.2, 0.0)
    error = TrackingError(0.1, 0.02, 0.1)
    assert law.command(driving(error), None, math.inf) == pytest.approx(last)
    # after ten time constants of 0.2 s it is the law's own: a hybrid law takes the cart as in sight
    for _ in range(100):
        command = law.command(driving(error), None, math.inf)
    alone = LawRunner(NODE, control, DT, lambda: None)
    alone.begin(control, under_way=True)
    assert command == pytest.approx(alone.command(driving(error), None, math.inf), abs=1e-3)


def test_a_law_that_has_failed_does_not_approach():
    law = LawRunner(NODE, PositionControl(), DT, lambda: None)
    law.command(driving(TrackingError(math.nan, 0.0, 0.0)), None, math.inf)
    assert law.failure
    assert law.approach(AHEAD, 0.2, PositionControl()) == (0.0, 0.0)
