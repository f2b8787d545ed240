"""The approach through the law runner: within the limits of the command, and the law goes on from it smoothly."""

import math
import types

import pytest

from mobile_robot_control.control.dead_zone import DeadZone
from mobile_robot_control.control.laws import LAWS, PositionControl
from mobile_robot_control.control.limits import Limits
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose, Reference, TrackingError
from mobile_robot_control.ros.position.law_runner import LawRunner

AHEAD = TrackingError(1.0, 0.0, 0.0)
STANDING = Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.0, 0.0))
NODE = types.SimpleNamespace(get_logger=lambda: types.SimpleNamespace(error=lambda text: None))


def _runner(control):
    return LawRunner(NODE, control, 0.02, lambda: None)


def _command(law, *error):
    return law.command(Observation(TrackingError(*error), Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.4, 0.1)),
                                   BodyVelocity(0.0, 0.0)), None, math.inf)


def test_the_approach_keeps_the_limits_of_the_command():
    control = PositionControl(limits=Limits(linear_velocity=0.15, linear_acceleration=2.0))
    law = _runner(control)
    linear = [law.approach(AHEAD, STANDING, 0.2, control).linear for _ in range(6)]
    assert linear == pytest.approx([0.04, 0.08, 0.12, 0.15, 0.15, 0.15])


def test_a_law_that_has_failed_does_not_approach():
    control = PositionControl()
    law = _runner(control)
    _command(law, math.nan, 0.0, 0.0)
    assert law.failure
    assert law.approach(AHEAD, STANDING, 0.2, control) == (0.0, 0.0)


# the command of dynamic feedback linearisation is a state, which an error that stays moves on
@pytest.mark.parametrize('name', [name for name in LAWS if name != 'dynamic_feedback_linearization'])
def test_the_law_goes_on_from_the_present_command(name):
    control = PositionControl(controller_type=name)
    law, alone, error = _runner(control), _runner(control), (0.1, 0.02, 0.1)
    assert law.approach(AHEAD, STANDING, 0.2, control) == (0.2, 0.0)
    assert _command(law, *error) == pytest.approx((0.2, 0.0))
    # after ten time constants of 0.2 s it is the law's own: a hybrid law takes the cart as in sight
    for _ in range(100):
        command = _command(law, *error)
    alone.begin_law(control, under_way=True)
    assert command == pytest.approx(_command(alone, *error), abs=1e-3)


def test_an_approach_within_the_dead_zone_of_the_base_is_given_in_pulses():
    control = PositionControl(dead_zone=DeadZone(0.5, 0.0))
    law = _runner(control)
    given = [law.approach(AHEAD, STANDING, 0.2, control).linear for _ in range(100)]
    assert {*given} == {0.0, 0.5}
    assert sum(given) == pytest.approx(100 * 0.2, abs=1.0)
