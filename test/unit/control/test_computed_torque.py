"""The computed-torque law: exact constants make the error linear, also with the Coriolis pair."""

import math

import pytest
from helpers.observation import inputs

from mobile_robot_control.control.computed_torque import ComputedTorqueGains, IntegralState, step
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.dynamics import at_rest
from mobile_robot_control.model.dynamics import step as move
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose

DT = 1e-4
COMMAND = (0.6, 1.5)


@pytest.mark.parametrize('coupled', [False, True])
@pytest.mark.parametrize(('k', 'ki'), [(10.0, 25.0), (8.0, 0.0)])
def test_the_error_obeys_the_linear_equation_of_the_gains(coupled, k, ki):
    robot = Robot(com_offset=0.15)
    plant = discretise(robot, DT, centripetal_coupling=coupled)
    motion, state = at_rest(Pose(0.0, 0.0, 0.0)), IntegralState()
    gains = ComputedTorqueGains(k=(k, k), ki=(ki, ki), centripetal_coupling=coupled)
    for n in range(1, 5001):
        state, torque = step(state, inputs(COMMAND, motion.velocity), gains, robot, 0.0, DT)
        motion = move(motion, torque, plant)
        if n % 500 == 0:
            t = n * DT
            # from rest e(0) = v_c, and de/dt(0) = -k v_c: a double root -k/2, or a single one without an integral
            share = (1.0 - 0.5 * k * t) * math.exp(-0.5 * k * t) if ki else math.exp(-k * t)
            left = [command * share for command in COMMAND]
            assert [c - v for c, v in zip(COMMAND, motion.velocity, strict=True)] == pytest.approx(left, abs=2e-3)


def test_a_channel_at_its_limit_does_not_integrate():
    state, torque = step(IntegralState(), inputs((5.0, 0.0)), ComputedTorqueGains(), Robot(), 0.1, DT)
    assert torque == (0.1, 0.1)
    assert state == IntegralState()


def test_the_coriolis_pair_is_that_of_the_plant():
    robot, velocity = Robot(com_offset=0.2), BodyVelocity(0.7, 2.0)
    gains = ComputedTorqueGains(centripetal_coupling=True)
    _, torque = step(IntegralState(), inputs(velocity, velocity), gains, robot, 0.0, DT)
    before = at_rest(Pose(0.0, 0.0, 0.0))._replace(velocity=velocity)
    after = move(before, torque, discretise(robot, DT, centripetal_coupling=True)).velocity
    assert after == pytest.approx(velocity, abs=1e-9)
