"""Properties of kinematics, plant, motors and friction, for drawn robots, motions and torques."""

import math

import numpy as np
import pytest
from helpers import chapter
from hypothesis import given, settings
from hypothesis import strategies as st

from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.driven import motorised_step
from mobile_robot_control.model.drivetrain import discretise_drivetrain
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.friction import Directions, Friction, released
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.motors import Motor, MotorState, saturate
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
FRICTIONS = st.sampled_from([0.0, chapter.K, 0.1])
NONE = WheelTorque(0.0, 0.0)


def begun(heading, velocity):
    return PlantState(Pose(0.0, 0.0, heading), velocity, 0.0, 0.0)


def energy(state, robot):
    """Eq. (10): A/2 stands before the squares of the wheels' velocities, B before their product."""
    a, b = linear_inertia(robot), angular_inertia(robot)
    right, left = wheel_velocity(state.velocity, robot)
    return 0.25 * (a * (right + left)**2 + b * (right - left)**2)


@given(VELOCITIES, ROBOTS)
def test_equations_5_to_7_and_19_are_inverse_to_each_other(body, robot):
    assert body_velocity(wheel_velocity(body, robot), robot) == pytest.approx(body, rel=1e-12, abs=1e-13)


@given(st.floats(-200, 200), st.floats(-200, 200), HEADINGS, ROBOTS)
def test_equations_2_to_4_8_and_9_give_the_energy_10_with_the_terms_of_15(right, left, heading, robot):
    v, omega = body_velocity(WheelVelocity(right, left), robot)
    # (8), (9): the velocity of the mass centre C
    x_c = v * math.cos(heading) - robot.com_offset * omega * math.sin(heading)
    y_c = v * math.sin(heading) + robot.com_offset * omega * math.cos(heading)
    expected = (0.5 * robot.mass * (x_c**2 + y_c**2) + 0.5 * robot.inertia * omega**2
                + 0.5 * robot.wheel_inertia * (right**2 + left**2))
    assert energy(begun(heading, BodyVelocity(v, omega)), robot) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def whole_and_halves(velocity, torque, heading, robot, dt, coupling=False):
    """Return the state after one step, and after two of half the length."""
    start = PlantState(Pose(0.3, -0.2, heading), velocity, 1.0, -1.0)
    half = discretise(robot, 0.5 * dt, coupling)
    return (dynamics.step(start, torque, discretise(robot, dt, coupling)),
            dynamics.step(dynamics.step(start, torque, half), torque, half))


@given(VELOCITIES, TORQUES, HEADINGS, ROBOTS, st.floats(1e-4, 0.02))
def test_an_exact_step_equals_two_half_steps(velocity, torque, heading, robot, dt):
    whole, halves = whole_and_halves(velocity, torque, heading, robot, dt)
    largest = 1.0 + max(map(abs, (*whole.velocity, *velocity)))
    assert halves.velocity == pytest.approx(whole.velocity, abs=1e-13 * largest)
    assert chapter.wrapped_difference(halves.pose.heading, whole.pose.heading) == pytest.approx(0, abs=1e-13 * largest)
    assert (halves.right_angle, halves.left_angle) == pytest.approx(
        (whole.right_angle, whole.left_angle), abs=1e-12 * largest / robot.wheel_radius)


@given(VELOCITIES, TORQUES, HEADINGS, COUPLING)
def test_a_step_of_the_chapters_robot_is_accurate_to_a_picometre(velocity, torque, heading, coupling):
    whole, halves = whole_and_halves(velocity, torque, heading, ROBOT, 0.002, coupling)
    assert halves.pose[:2] == pytest.approx(whole.pose[:2], abs=1e-12)
    assert halves.velocity == pytest.approx(whole.velocity, abs=1e-11)


@given(VELOCITIES, TORQUES, HEADINGS, st.floats(-3.0, 3.0), COUPLING)
def test_the_motion_turns_with_the_heading(velocity, torque, heading, turn, coupling):
    plant = discretise(ROBOT, 0.002, coupling)
    here, there = (dynamics.step(begun(angle, velocity), torque, plant) for angle in (heading, heading + turn))
    cos, sin = math.cos(turn), math.sin(turn)
    x, y, _ = here.pose
    assert there.pose[:2] == pytest.approx((cos * x - sin * y, sin * x + cos * y), abs=1e-14)
    assert there.velocity == here.velocity


@given(VELOCITIES, TORQUES, HEADINGS, COUPLING)
def test_mirrored_wheels_drive_a_mirrored_path(velocity, torque, heading, coupling):
    plant = discretise(ROBOT, 0.002, coupling)
    one = dynamics.step(begun(heading, velocity), torque, plant)
    mirrored = dynamics.step(begun(-heading, BodyVelocity(velocity.linear, -velocity.angular)),
                             WheelTorque(torque.left, torque.right), plant)
    assert (mirrored.pose.x, -mirrored.pose.y) == pytest.approx(one.pose[:2], abs=1e-15)
    assert chapter.wrapped_difference(-mirrored.pose.heading, one.pose.heading) == pytest.approx(0.0, abs=1e-14)
    assert (mirrored.velocity.linear, -mirrored.velocity.angular) == pytest.approx(one.velocity, abs=1e-13)
    assert (mirrored.left_angle, mirrored.right_angle) == pytest.approx((one.right_angle, one.left_angle), abs=1e-13)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)


def energy_balance(velocity, torque, friction, coupling, dt):
    """Energy of Eq. (10) gained, and work of the torques less friction, over a period."""
    robot = Robot(viscous_friction=friction)
    start = begun(0.4, velocity)
    end = dynamics.step(start, torque, discretise(robot, dt, coupling))
    gained = (chapter.kinetic_energy(*chapter.wheels(*end.velocity))
              - chapter.kinetic_energy(*chapter.wheels(*velocity)))
    # held torques do work over the wheels' angles; friction's power is integrated over the period
    work = torque.right * end.right_angle + torque.left * end.left_angle
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        between = dynamics.step(start, torque, discretise(robot, 0.5 * (node + 1.0) * dt, coupling))
        work -= 0.5 * dt * weight * friction * sum(speed**2 for speed in chapter.wheels(*between.velocity))
    return gained, work


@given(VELOCITIES, TORQUES, FRICTIONS)
def test_the_energy_10_changes_by_the_work_of_torques_and_friction(velocity, torque, friction):
    gained, work = energy_balance(velocity, torque, friction, False, 0.05)
    assert gained == pytest.approx(work, rel=1e-10, abs=1e-10)


@settings(max_examples=50)
@given(VELOCITIES, TORQUES, FRICTIONS)
def test_deviation_8_the_coupling_does_no_work(velocity, torque, friction):
    gained, work = energy_balance(velocity, torque, friction, True, 0.01)
    assert gained == pytest.approx(work, rel=1e-9, abs=1e-9)


@given(VELOCITIES, HEADINGS, ROBOTS, COUPLING)
def test_without_torques_no_robot_gains_energy(velocity, heading, robot, coupling):
    start = begun(heading, velocity)
    end = dynamics.step(start, NONE, discretise(robot, 0.002, coupling))
    assert energy(end, robot) <= energy(start, robot) * (1.0 + 1e-9)


@given(TORQUES, st.floats(0.01, 5.0))
def test_limited_torques_stay_within_the_limit_and_keep_their_sign(torque, limit):
    limited = saturate(torque, limit)
    for requested, applied in zip(torque, limited, strict=True):
        assert abs(applied) == min(abs(requested), limit)
        assert applied * requested >= 0.0
    assert saturate(limited, limit) == limited


# from 100 g to 300 kg, of any shape
DRIVEN = st.builds(
    lambda mass, gyration, radius, separation, offset, share, viscous: Robot(
        mass, mass * gyration * gyration, radius, separation, offset, share * mass * radius * radius, viscous),
    st.floats(0.1, 300.0), st.floats(0.02, 1.0), st.floats(0.01, 0.3), st.floats(0.05, 1.5), st.floats(-0.3, 0.3),
    st.floats(1e-4, 1.0), st.sampled_from([0.0, 1e-4, 0.007, 0.5]))
WHEEL = st.sampled_from([0.0, 1e-9, 0.01]) | st.floats(-20.0, 20.0)
WHEELS = st.builds(WheelVelocity, WHEEL, WHEEL) | WHEEL.map(lambda speed: WheelVelocity(speed, speed))
SIDE = st.sampled_from([0.0, 0.3, -0.3]) | st.floats(-3.0, 3.0)
PAIRS = st.builds(WheelTorque, SIDE, SIDE)
COULOMB = st.sampled_from([1e-3, 0.3, 5.0]) | st.floats(1e-6, 10.0)
PERIODS = st.sampled_from([0.00025, 0.002, 0.005, 0.033, 0.2])
MOTORS = st.builds(lambda line, time: Motor(*line, time), st.sampled_from([(0.0, 0.0), (1.4, 6.4), (0.3, 1.0)]),
                   st.sampled_from([0.0, 1e-4, 0.002, 0.05, 2.0]))


def drivetrain(robot, dt, coulomb, motor=Motor(), coupling=False):  # noqa: B008 (immutable)
    return discretise_drivetrain(discretise(robot, dt, coupling), motor, Friction(coulomb))


def moving(speeds, robot):
    return begun(0.3, body_velocity(speeds, robot))


def within_stall(torque, motor):
    limit = motor.stall_torque or 1e12
    return WheelTorque(*(max(-limit, min(limit, each)) for each in torque))


@settings(max_examples=150)
@given(DRIVEN, WHEELS, PAIRS, PAIRS, COULOMB, PERIODS)
def test_no_energy_comes_out_of_friction(robot, speeds, torque, outside, coulomb, dt):
    robot = robot._replace(viscous_friction=0.0)
    drive = drivetrain(robot, dt, coulomb)
    start = moving(speeds, robot)
    end, _, applied = motorised_step(start, MotorState(torque), torque, outside, drive)
    assert applied == torque
    # held torques do work over the angles; what is lacking is the work of the friction
    work = (torque.right + outside.right) * end.right_angle + (torque.left + outside.left) * end.left_angle
    before, after = energy(start, robot), energy(end, robot)
    scale = before + after + abs(work)
    assert after - before - work <= 1e-11 * scale
    # it does no more than the friction over the whole way, of which the angles are the least
    least = -coulomb * (abs(end.right_angle) + abs(end.left_angle))
    assert after - before - work <= least + 1e-11 * (scale - least) + 1e-25


@settings(max_examples=100)
@given(DRIVEN, WHEELS, PAIRS, PAIRS, PAIRS, COULOMB | st.just(0.0), MOTORS, PERIODS, st.booleans())
def test_every_step_ends_within_what_the_torques_can_do(
        robot, speeds, begun, asked, outside, coulomb, motor, dt, coupling):
    # with the Coriolis pair a long period is many short ones
    dt = min(dt, 0.005) if coupling else dt
    drive = drivetrain(robot, dt, coulomb, motor, coupling)
    begun, asked = within_stall(begun, motor), within_stall(asked, motor)
    start = moving(speeds, robot)
    end, motors, applied = motorised_step(start, MotorState(begun), asked, outside, drive)
    assert all(map(math.isfinite, (*end.pose, *end.velocity, end.right_angle, end.left_angle, *applied)))
    for now, before, then in zip(motors.torque, begun, asked, strict=True):
        assert min(before, then) <= now <= max(before, then)
    # dE/dt <= Σ |torque| |speed| <= P sqrt(E), so that sqrt(E) grows by at most P dt / 2
    least_inertia = min(linear_inertia(robot), angular_inertia(robot))
    most = sum(max(abs(one), abs(other)) + abs(third)
               for one, other, third in zip(begun, asked, outside, strict=True))
    grown = most * dt * math.sqrt(0.5 / least_inertia)
    assert math.sqrt(energy(end, robot)) <= (math.sqrt(energy(start, robot)) + grown) * (1.0 + 1e-4)


@given(DRIVEN, PAIRS, PAIRS, MOTORS, PERIODS, st.booleans())
def test_at_rest_within_the_friction_nothing_changes_at_all(robot, begun, asked, motor, dt, coupling):
    begun, asked = within_stall(begun, motor), within_stall(asked, motor)
    coulomb = max(map(abs, (*begun, *asked))) + 1e-6
    drive = drivetrain(robot, dt, coulomb, motor, coupling)
    start, motors = moving(WheelVelocity(0.0, 0.0), robot), MotorState(begun)
    for _ in range(3):
        end, motors, _ = motorised_step(start, motors, asked, NONE, drive)
        assert end == start


@given(DRIVEN, WHEELS, COULOMB, PERIODS, MOTORS)
def test_without_a_torque_every_robot_comes_to_rest_and_stays(robot, speeds, coulomb, dt, motor):
    drive = drivetrain(robot, dt, coulomb, motor)
    # each wheel's momentum is taken by its friction; the energy's root falls at a bounded rate
    largest = max(linear_inertia(robot), angular_inertia(robot))
    start = moving(speeds, robot)
    longest = math.sqrt(2.0 * energy(start, robot) * largest) / coulomb * 2.0
    if longest >= 50.0 * dt:
        drive = drivetrain(robot, longest / 50.0 + dt, coulomb, motor)
    state, motors, last = start, MotorState(NONE), math.inf
    for _ in range(60):
        state, motors, _ = motorised_step(state, motors, NONE, NONE, drive)
        now = energy(state, robot)
        assert now <= last * (1.0 + 1e-12)
        last = now
    assert tuple(state.velocity) == (0.0, 0.0)
    assert motorised_step(state, motors, NONE, NONE, drive)[0] == state


@given(DRIVEN, WHEELS, PAIRS, PAIRS, COULOMB, MOTORS, PERIODS)
def test_mirrored_wheels_move_a_mirrored_robot(robot, speeds, begun, asked, coulomb, motor, dt):
    drive = drivetrain(robot, dt, coulomb, motor)
    begun, asked = within_stall(begun, motor), within_stall(asked, motor)
    one, _, applied = motorised_step(moving(speeds, robot), MotorState(begun), asked, NONE, drive)
    other, _, mirrored = motorised_step(
        moving(WheelVelocity(speeds.left, speeds.right), robot), MotorState(WheelTorque(begun.left, begun.right)),
        WheelTorque(asked.left, asked.right), NONE, drive)
    largest = 1.0 + max(map(abs, (*speeds, *wheel_velocity(one.velocity, robot))))
    assert (other.left_angle, other.right_angle) == pytest.approx(
        (one.right_angle, one.left_angle), abs=1e-9 * largest)
    assert (mirrored.left, mirrored.right) == pytest.approx(applied, abs=1e-9)


@given(PAIRS, st.floats(-0.999, 0.999), COULOMB, st.sampled_from([-1.0, 0.0, 1.0]),
       st.sampled_from([-1.0, 0.0, 1.0]))
def test_what_is_decided_at_rest_solves_the_equations_of_motion(torque, coupling, coulomb, right, left):
    directions = released(Directions(right, left), torque, coupling, coulomb)
    # with A = 1 and B the coupling, by Eq. (13)-(14)
    pushes = [each - coulomb * direction for each, direction in zip(torque, directions, strict=True)]
    if 0.0 not in directions:
        determinant = 1.0 - coupling * coupling
        accelerations = [(pushes[0] - coupling * pushes[1]) / determinant,
                         (pushes[1] - coupling * pushes[0]) / determinant]
    else:
        accelerations = [push if direction else 0.0 for push, direction in zip(pushes, directions, strict=True)]
    for n, before in enumerate((right, left)):
        if before != 0.0:
            assert directions[n] == before
        elif directions[n] != 0.0:
            assert accelerations[n] * directions[n] > 0.0
        else:
            held = torque[n] - coupling * accelerations[1 - n]
            assert abs(held) <= coulomb + 1e-11 * (coulomb + abs(held) + sum(map(abs, torque)))
