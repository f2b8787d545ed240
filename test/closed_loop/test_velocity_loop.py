"""Theorem 1: the velocity loop tracks its commands with zero steady-state error, one channel at a time."""

import pytest
from helpers import chapter
from helpers.observation import inputs

from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.velocity_pi import VelocityGains, VelocityPiState
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose

ROBOT = Robot()
RATE = 2000.0


def respond(command, gains, seconds, rate=RATE, limit=0.0):
    """Yield the body velocity after each period of a step of the command, from rest."""
    plant, state, pi = discretise(ROBOT, 1.0 / rate), dynamics.at_rest(Pose(0.0, 0.0, 0.0)), VelocityPiState()
    for _ in range(round(seconds * rate)):
        pi, torque = velocity_pi.step(pi, inputs(command, state.velocity), gains, ROBOT, limit, 1.0 / rate)
        state = dynamics.step(state, torque, plant)
        yield state.velocity


@pytest.mark.parametrize(('command', 'stepped', 'other'), [
    (BodyVelocity(1.0, 0.0), 'linear', 'angular'),
    pytest.param(BodyVelocity(0.0, 1.0), 'angular', 'linear', marks=pytest.mark.soak),
])
def test_theorem_1_a_step_of_one_channel_leaves_no_error_and_the_other_channel_alone(command, stepped, other):
    gains, worst_other = VelocityGains(**chapter.STEP_GAINS), 0.0
    stepped, other = BodyVelocity._fields.index(stepped), BodyVelocity._fields.index(other)
    response = respond(command, gains, 7.0 * (gains.ti1, gains.ti2)[stepped])
    for k, velocity in enumerate(response):
        worst_other = max(worst_other, abs(velocity[other]))
        if k == 10 * RATE:
            after_seconds = abs(velocity[stepped] - 1.0)
    assert abs(velocity[stepped] - 1.0) < 1e-6
    assert worst_other < 1e-9
    # it is the integral that brings it there: friction would leave more
    assert after_seconds > 1e-5


def test_anti_windup_reduces_the_overshoot():
    gains = VelocityGains(k1=1.0, ti1=0.2, k2=0.3, ti2=0.2)
    # 0.25 N m a wheel could hold 1.22 m/s; it takes seconds to reach 1 m/s
    limited, free = ([velocity.linear for velocity in respond(BodyVelocity(1.0, 0.0), gains, 15.0, 500.0, limit)]
                     for limit in (0.25, 0.0))
    assert max(limited) < max(free)
    assert limited[-1] == pytest.approx(1.0, abs=1e-6)
