"""The adaptive law: its Lyapunov function falls, estimates pause where they must, and follow the true robot."""

import math
from itertools import pairwise

import pytest
from helpers.observation import inputs

from mobile_robot_control.control.adaptive import AdaptiveGains, AdaptiveState, step
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.dynamics import at_rest
from mobile_robot_control.model.dynamics import step as move
from mobile_robot_control.model.robot import Robot, angular_inertia, linear_inertia
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose

DT = 1e-3
TRUE = Robot(mass=15.0, inertia=1.5, viscous_friction=0.009)
NOMINAL, GAINS = Robot(), AdaptiveGains()


def driven(seconds, gains=GAINS):
    """Yield state and velocity of a heavier robot whose command swings."""
    plant, motion, state = discretise(TRUE, DT), at_rest(Pose(0.0, 0.0, 0.0)), AdaptiveState()
    for n in range(round(seconds / DT)):
        t = n * DT
        command = (0.3 + 0.3 * math.sin(3.0 * t), 1.5 * math.sin(2.0 * t))
        fed = BodyAcceleration(0.9 * math.cos(3.0 * t), 3.0 * math.cos(2.0 * t))
        state, torque = step(state, inputs(command, motion.velocity, fed), gains, NOMINAL, 0.0, DT)
        motion = move(motion, torque, plant)
        yield state, motion.velocity


def lyapunov(state, velocity):
    """Return V of the linear channel."""
    s = state.linear - velocity.linear
    inertia, friction = linear_inertia(NOMINAL), NOMINAL.viscous_friction
    wrong = state.inertia - linear_inertia(TRUE) / inertia, state.friction - TRUE.viscous_friction / friction
    return 0.5 * (linear_inertia(TRUE) * s * s + inertia * wrong[0]**2 / GAINS.inertia_rate[0]
                  + friction * wrong[1]**2 / GAINS.friction_rate[0])


def test_the_lyapunov_function_falls_and_the_estimates_reach_the_true_robot():
    values, last = [], None
    for n, last in enumerate(driven(60.0)):
        if n % 500 == 0:
            values.append(lyapunov(*last))
    # sampled, it may rise by the square of the period
    assert all(later <= earlier * 1.001 + 1e-9 for earlier, later in pairwise(values))
    assert values[-1] < 1e-3 * values[0]
    state = last[0]
    assert state.inertia == pytest.approx(linear_inertia(TRUE) / linear_inertia(NOMINAL), rel=0.05)
    assert state.turning_inertia == pytest.approx(angular_inertia(TRUE) / angular_inertia(NOMINAL), rel=0.05)
    assert state.friction == pytest.approx(TRUE.viscous_friction / NOMINAL.viscous_friction, rel=0.05)


@pytest.mark.parametrize(('gains', 'limit'), [(GAINS._replace(dead_zone=(1.0, 9.0)), 0.0), (GAINS, 0.01)])
def test_estimates_pause_within_the_dead_zone_and_at_the_limit(gains, limit):
    state, _ = step(AdaptiveState(), inputs((0.5, 1.0), (-0.2, -0.5)), gains, NOMINAL, limit, DT)
    assert state[2:] == (1.0,) * 4


def test_the_model_follows_the_command_where_nothing_is_fed():
    state = AdaptiveState()
    for _ in range(500):
        state, _ = step(state, inputs((0.5, 1.0), BodyVelocity(state.linear, state.angular)), GAINS, NOMINAL, 0.0, DT)
    left = (1.0 - GAINS.model[0] * DT) ** 500
    assert (state.linear, state.angular) == pytest.approx((0.5 * (1.0 - left), 1.0 - left), rel=1e-9)
