"""Odometry is carried forward along the exact arc of its twist."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.control.latency import (
    NO_ODOMETRY,
    HeldOdometry,
    carried_forward,
    held_age,
    held_odometry,
)
from mobile_robot_control.quantities import BodyVelocity, Pose
from mobile_robot_control.simulation.rollout import rollout

SPEEDS = st.floats(-2.0, 2.0)


@given(SPEEDS, SPEEDS, st.floats(0.0, 1.0), st.floats(-3.0, 3.0))
def test_it_is_where_many_small_steps_lead(v, omega, age, heading):
    x, y, steps = 0.5, -0.2, 2000
    dt = age / steps
    for n in range(steps):
        middle = heading + omega * (n + 0.5) * dt
        x, y = x + v * dt * math.cos(middle), y + v * dt * math.sin(middle)
    carried = carried_forward(Pose(0.5, -0.2, heading), BodyVelocity(v, omega), age)
    assert carried[:2] == pytest.approx((x, y), abs=1e-6)
    assert math.remainder(carried.heading - heading - omega * age, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)


@given(SPEEDS, st.floats(-1e-3, 1e-3), st.floats(0.0, 1.0))
def test_nearly_straight_motions_are_as_exact(v, omega, age):
    carried = carried_forward(Pose(0.0, 0.0, 0.0), BodyVelocity(v, omega), age)
    turn = omega * age
    # the arc, by its own series
    assert carried.x == pytest.approx(v * age * (1.0 - turn * turn / 6.0), abs=1e-12)
    assert carried.y == pytest.approx(v * age * (turn / 2.0 - turn**3 / 24.0), abs=1e-12)


def test_ages_are_held_to_what_a_message_may_have():
    assert [held_age(age, 0.5) for age in (-0.1, 0.0, 0.2, 0.7)] == [0.0, 0.0, 0.2, 0.5]


def test_a_robot_that_moves_does_not_measure_the_same_twice():
    pose, velocity = Pose(1.0, 2.0, 3.0), BodyVelocity(0.5, 0.1)
    held = held_odometry(NO_ODOMETRY, pose, velocity)
    assert held == HeldOdometry(pose, velocity, 0)
    held = held_odometry(held_odometry(held, pose, velocity), pose, velocity)
    assert held.steps == 2
    assert held_odometry(held, Pose(1.0, 2.0, 3.1), velocity).steps == 0
    assert held_odometry(held, pose, BodyVelocity(0.5, 0.2)).steps == 0



def controlled(**values):
    return configure({'position_controller': values})


def test_the_law_sees_the_error_of_the_pose_that_is_carried_forward():
    parameters = controlled(compensate_latency=True, odom_latency=0.1)
    ticks = [sample.tick for sample in rollout(parameters, 1.0) if sample.tick.time == sample.time]
    for tick in ticks:
        ahead = carried_forward(tick.pose, tick.velocity, 0.1)
        apart = math.hypot(tick.reference.pose.x - ahead.x, tick.reference.pose.y - ahead.y)
        assert math.hypot(tick.error.longitudinal, tick.error.lateral) == pytest.approx(apart, abs=1e-12)
    # odometry has no latency here: a robot that trusts it drives behind by that much
    behind = ticks[-1].reference.velocity.linear * 0.1
    assert math.hypot(ticks[-1].pose.x - ticks[-1].reference.pose.x,
                      ticks[-1].pose.y - ticks[-1].reference.pose.y) == pytest.approx(behind, rel=0.3)
