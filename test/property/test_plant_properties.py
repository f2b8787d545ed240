"""Properties of kinematics and plant, for drawn robots, motions and torques."""

import math

import chapter
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mobile_robot_control.model import dynamics
from mobile_robot_control.model.actuators import saturate
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.robot import Robot, angular_inertia, linear_inertia
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque, WheelVelocity

ROBOT = Robot()
ROBOTS = st.builds(
    Robot, mass=st.floats(0.1, 100.0), inertia=st.floats(0.01, 50.0), wheel_radius=st.floats(0.01, 0.5),
    wheel_separation=st.floats(0.05, 2.0), com_offset=st.floats(-0.5, 0.5), wheel_inertia=st.floats(1e-4, 0.1),
    viscous_friction=st.floats(0.0, 1.0))
SPEED = st.floats(-5.0, 5.0)
VELOCITIES = st.builds(BodyVelocity, SPEED, SPEED)
TORQUES = st.builds(WheelTorque, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
HEADINGS = st.floats(-math.pi, math.pi, exclude_min=True)
COUPLING = st.booleans()


@given(VELOCITIES, ROBOTS)
def test_equations_5_to_7_and_19_are_inverse_to_each_other(body, robot):
    assert body_velocity(wheel_velocity(body, robot), robot) == pytest.approx(body, rel=1e-12, abs=1e-13)


@given(st.floats(-200, 200), st.floats(-200, 200), HEADINGS, ROBOTS)
def test_equations_2_to_4_8_and_9_give_the_energy_10_with_A_and_B_of_15(right, left, heading, robot):
    v, omega = body_velocity(WheelVelocity(right, left), robot)
    # (8), (9): the velocity of the mass centre C
    x_c = v * math.cos(heading) - robot.com_offset * omega * math.sin(heading)
    y_c = v * math.sin(heading) + robot.com_offset * omega * math.cos(heading)
    energy = (0.5 * robot.mass * (x_c**2 + y_c**2) + 0.5 * robot.inertia * omega**2
              + 0.5 * robot.wheel_inertia * (right**2 + left**2))
    # (10): A/2 stands before the squares, B before the product
    a = 0.5 * (linear_inertia(robot) + angular_inertia(robot))
    b = 0.5 * (linear_inertia(robot) - angular_inertia(robot))
    assert 0.5 * a * (right**2 + left**2) + b * right * left == pytest.approx(energy, rel=1e-9, abs=1e-9)


@given(VELOCITIES, TORQUES, HEADINGS, ROBOTS, st.floats(1e-4, 0.02))
def test_an_exact_step_equals_two_half_steps(velocity, torque, heading, robot, dt):
    start = PlantState(Pose(0.3, -0.2, heading), velocity, 1.0, -1.0)
    whole = dynamics.step(start, torque, discretise(robot, dt))
    half = discretise(robot, 0.5 * dt)
    halves = dynamics.step(dynamics.step(start, torque, half), torque, half)
    largest = 1.0 + max(map(abs, (*whole.velocity, *velocity)))
    assert halves.velocity == pytest.approx(whole.velocity, abs=1e-13 * largest)
    assert chapter.wrapped_difference(halves.pose.heading, whole.pose.heading) == pytest.approx(0, abs=1e-13 * largest)
    assert (halves.right_angle, halves.left_angle) == pytest.approx(
        (whole.right_angle, whole.left_angle), abs=1e-12 * largest / robot.wheel_radius)


@given(VELOCITIES, TORQUES, HEADINGS, COUPLING)
def test_a_step_of_the_chapters_robot_is_accurate_to_a_picometre(velocity, torque, heading, coupling):
    start = PlantState(Pose(0.3, -0.2, heading), velocity, 0.0, 0.0)
    whole = dynamics.step(start, torque, discretise(ROBOT, 0.002, coupling))
    half = discretise(ROBOT, 0.001, coupling)
    halves = dynamics.step(dynamics.step(start, torque, half), torque, half)
    assert halves.pose[:2] == pytest.approx(whole.pose[:2], abs=1e-12)
    assert halves.velocity == pytest.approx(whole.velocity, abs=1e-11)


@given(VELOCITIES, TORQUES, HEADINGS, st.floats(-3.0, 3.0), COUPLING)
def test_the_motion_turns_with_the_heading(velocity, torque, heading, turn, coupling):
    plant = discretise(ROBOT, 0.002, coupling)
    here = dynamics.step(PlantState(Pose(0.0, 0.0, heading), velocity, 0.0, 0.0), torque, plant)
    there = dynamics.step(dynamics.at_rest(Pose(0.0, 0.0, heading + turn))._replace(velocity=velocity), torque, plant)
    cos, sin = math.cos(turn), math.sin(turn)
    x, y, _ = here.pose
    assert there.pose[:2] == pytest.approx((cos * x - sin * y, sin * x + cos * y), abs=1e-14)
    assert there.velocity == here.velocity


@given(VELOCITIES, TORQUES, HEADINGS, COUPLING)
def test_mirrored_wheels_drive_a_mirrored_path(velocity, torque, heading, coupling):
    plant = discretise(ROBOT, 0.002, coupling)
    one = dynamics.step(PlantState(Pose(0.0, 0.0, heading), velocity, 0.0, 0.0), torque, plant)
    mirrored = dynamics.step(
        PlantState(Pose(0.0, 0.0, -heading), BodyVelocity(velocity.linear, -velocity.angular), 0.0, 0.0),
        WheelTorque(torque.left, torque.right), plant)
    assert (mirrored.pose.x, -mirrored.pose.y) == pytest.approx(one.pose[:2], abs=1e-15)
    assert chapter.wrapped_difference(-mirrored.pose.heading, one.pose.heading) == pytest.approx(0.0, abs=1e-14)
    assert (mirrored.velocity.linear, -mirrored.velocity.angular) == pytest.approx(one.velocity, abs=1e-13)
    assert (mirrored.left_angle, mirrored.right_angle) == pytest.approx((one.right_angle, one.left_angle), abs=1e-13)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)


def energy_balance(velocity, torque, friction, coupling, dt):
    """Energy of Eq. (10) gained, and work of the torques less friction, over a period."""
    robot = Robot(viscous_friction=friction)
    start = PlantState(Pose(0.0, 0.0, 0.4), velocity, 0.0, 0.0)
    end = dynamics.step(start, torque, discretise(robot, dt, coupling))
    gained = (chapter.kinetic_energy(*chapter.wheels(*end.velocity))
              - chapter.kinetic_energy(*chapter.wheels(*velocity)))
    # held torques do work over the wheels' angles; friction's power is integrated over the period
    work = torque.right * end.right_angle + torque.left * end.left_angle
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        between = dynamics.step(start, torque, discretise(robot, 0.5 * (node + 1.0) * dt, coupling))
        work -= 0.5 * dt * weight * friction * sum(speed**2 for speed in chapter.wheels(*between.velocity))
    return gained, work


@given(VELOCITIES, TORQUES, st.sampled_from([0.0, chapter.K, 0.1]))
def test_the_energy_10_changes_by_the_work_of_torques_and_friction(velocity, torque, friction):
    gained, work = energy_balance(velocity, torque, friction, False, 0.05)
    assert gained == pytest.approx(work, rel=1e-10, abs=1e-10)


@settings(max_examples=50)
@given(VELOCITIES, TORQUES, st.sampled_from([0.0, chapter.K, 0.1]))
def test_deviation_8_the_coupling_does_no_work(velocity, torque, friction):
    gained, work = energy_balance(velocity, torque, friction, True, 0.01)
    assert gained == pytest.approx(work, rel=1e-9, abs=1e-9)


@given(VELOCITIES, HEADINGS, ROBOTS, COUPLING)
def test_without_torques_no_robot_gains_energy(velocity, heading, robot, coupling):
    start = PlantState(Pose(0.0, 0.0, heading), velocity, 0.0, 0.0)
    end = dynamics.step(start, WheelTorque(0.0, 0.0), discretise(robot, 0.002, coupling))

    def energy(body):
        a, b = linear_inertia(robot), angular_inertia(robot)
        half = 0.5 * robot.wheel_separation
        return (a * body.linear**2 + b * half**2 * body.angular**2) / robot.wheel_radius**2

    assert energy(end.velocity) <= energy(velocity) * (1.0 + 1e-9)


@given(TORQUES, st.floats(0.01, 5.0))
def test_limited_torques_stay_within_the_limit_and_keep_their_sign(torque, limit):
    limited = saturate(torque, limit)
    for requested, applied in zip(torque, limited, strict=True):
        assert abs(applied) == min(abs(requested), limit)
        assert applied * requested >= 0.0
    assert saturate(limited, limit) == limited
