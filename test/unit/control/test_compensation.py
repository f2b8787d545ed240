"""What is computed ahead: odometry along the arc of its twist, and the torques of an acceleration."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobile_robot_control.control.compensation import (
    NO_ODOMETRY,
    HeldOdometry,
    carried_forward,
    held_age,
    held_odometry,
    inverse_dynamics,
)
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.dynamics import at_rest
from mobile_robot_control.model.dynamics import step as move
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, Pose
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import configure

SPEEDS = st.floats(-2.0, 2.0)
RATES = st.floats(-3.0, 3.0)


@given(SPEEDS, SPEEDS | st.floats(-1e-3, 1e-3), st.floats(0.0, 1.0), st.floats(-3.0, 3.0))
def test_a_pose_is_carried_to_where_the_arc_ends(v, omega, age, heading):
    turn = omega * age
    # the chord of the arc, by the series of sin x / x
    chord = v * age * sum((-1)**n * (0.5 * turn)**(2 * n) / math.factorial(2 * n + 1) for n in range(10))
    x, y, end = carried_forward(Pose(0.5, -0.2, heading), BodyVelocity(v, omega), age)
    assert (x, y) == pytest.approx((0.5 + chord * math.cos(heading + 0.5 * turn),
                                    -0.2 + chord * math.sin(heading + 0.5 * turn)), abs=1e-12)
    assert math.remainder(end - heading - turn, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)
    assert -math.pi < end <= math.pi


def test_ages_are_held_to_what_a_message_may_have():
    assert [held_age(age, 0.5) for age in (-0.1, 0.2, 0.7)] == [0.0, 0.2, 0.5]


def test_a_robot_that_moves_does_not_measure_the_same_twice():
    pose, velocity = Pose(1.0, 2.0, 3.0), BodyVelocity(0.5, 0.1)
    held = held_odometry(NO_ODOMETRY, pose, velocity)
    assert held == HeldOdometry(pose, velocity, 0)
    held = held_odometry(held_odometry(held, pose, velocity), pose, velocity)
    assert held.steps == 2
    assert held_odometry(held, Pose(1.0, 2.0, 3.1), velocity).steps == 0
    assert held_odometry(held, pose, BodyVelocity(0.5, 0.2)).steps == 0


def test_the_law_sees_the_error_of_the_pose_that_is_carried_forward():
    parameters = configure({'position_controller': {'compensate_latency': True, 'odom_latency': 0.1}})
    ticks = [sample.tick for sample in rollout(parameters, 1.0) if sample.tick.time == sample.time]
    for tick in ticks:
        ahead = carried_forward(tick.pose, tick.velocity, 0.1)
        apart = math.dist(tick.reference.pose[:2], ahead[:2])
        assert math.hypot(*tick.error[:2]) == pytest.approx(apart, abs=1e-12)
    # odometry has no latency here: a robot that trusts it drives behind by that much
    behind = ticks[-1].reference.velocity.linear * 0.1
    assert math.dist(ticks[-1].pose[:2], ticks[-1].reference.pose[:2]) == pytest.approx(behind, rel=0.3)


@given(RATES, RATES, RATES, RATES)
def test_equations_13_and_14_solved_for_the_torques(v, omega, v_rate, omega_rate):
    robot, dt = Robot(), 1e-6
    torque = inverse_dynamics(BodyVelocity(v, omega), BodyAcceleration(v_rate, omega_rate), robot)
    begun = at_rest(Pose(0.0, 0.0, 0.0))._replace(velocity=BodyVelocity(v, omega))
    after = move(begun, torque, discretise(robot, dt)).velocity
    assert ((after.linear - v) / dt, (after.angular - omega) / dt) == pytest.approx((v_rate, omega_rate), abs=1e-3)
