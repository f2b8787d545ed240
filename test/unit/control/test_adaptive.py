"""The adaptive law: its Lyapunov function falls, estimates pause where they must, and follow the true robot."""

import math
from itertools import islice, pairwise

import numpy as np
import pytest
from helpers.observation import inputs

from mobile_robot_control.control.adaptive import AdaptiveGains, AdaptiveState, step
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.dynamics import at_rest
from mobile_robot_control.model.dynamics import step as move
from mobile_robot_control.model.robot import Robot, angular_inertia, linear_inertia
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose, WheelTorque

DT = 1e-3
TRUE = Robot(mass=15.0, inertia=1.5, viscous_friction=0.009)
NOMINAL, GAINS = Robot(), AdaptiveGains()
NOISE = 0.005, 0.028
"""[m/s], [rad/s]: 0.2 rad/s on each wheel."""


def driven(seconds, gains=GAINS, swing=1.0, noise=(0.0, 0.0), push=0.0, dt=DT):
    """Yield state and velocity of a heavier robot whose command swings, with noise [m/s], [rad/s] and a push [N m]."""
    plant, motion, state = discretise(TRUE, dt), at_rest(Pose(0.0, 0.0, 0.0)), AdaptiveState()
    rng = np.random.default_rng(1)
    for n in range(round(seconds / dt)):
        t = n * dt
        command = (swing * (0.3 + 0.3 * math.sin(3.0 * t)), swing * 1.5 * math.sin(2.0 * t))
        fed = BodyAcceleration(swing * 0.9 * math.cos(3.0 * t), swing * 3.0 * math.cos(2.0 * t))
        measured = rng.normal(motion.velocity, noise).tolist() if any(noise) else motion.velocity
        state, torque = step(state, inputs(command, measured, fed), gains, NOMINAL, 0.0, dt)
        motion = move(motion, WheelTorque(torque.right + push, torque.left + push), plant)
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


def test_a_standing_robot_keeps_its_estimates_under_noise_and_a_push():
    for state, _ in driven(5.0, swing=0.0, noise=NOISE, push=0.1):
        assert state[2:] == (1.0,) * 4


@pytest.mark.soak
@pytest.mark.timeout(1200)
def test_adapted_estimates_move_by_less_than_5_percent_in_an_hour_of_noise():
    hour = islice(driven(3900.0, noise=NOISE, dt=0.002), round(300.0 / 0.002), None, 100)
    adapted = [state[2:] for state, _ in hour]
    for factor in zip(*adapted, strict=True):
        print(f'{min(factor):.4f} to {max(factor):.4f}')
        assert max(factor) < 1.05 * min(factor)


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
