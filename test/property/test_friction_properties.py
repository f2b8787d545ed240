"""Properties of motors and friction, for drawn robots, motions and torques."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.driven import motorised_step
from mobile_robot_control.model.drivetrain import discretise_drivetrain
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.friction import Directions, Friction, released
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.motors import Motor, MotorState
from mobile_robot_control.model.robot import Robot, angular_inertia, linear_inertia
from mobile_robot_control.quantities import Pose, WheelTorque, WheelVelocity

NONE = WheelTorque(0.0, 0.0)
# from 100 g to 300 kg, of any shape
ROBOTS = st.builds(
    lambda mass, gyration, radius, separation, offset, share, viscous: Robot(
        mass, mass * gyration * gyration, radius, separation, offset, share * mass * radius * radius, viscous),
    st.floats(0.1, 300.0), st.floats(0.02, 1.0), st.floats(0.01, 0.3), st.floats(0.05, 1.5), st.floats(-0.3, 0.3),
    st.floats(1e-4, 1.0), st.sampled_from([0.0, 1e-4, 0.007, 0.5]))
SPEED = st.sampled_from([0.0, 1e-9, 0.01]) | st.floats(-20.0, 20.0)
SPEEDS = st.builds(WheelVelocity, SPEED, SPEED) | SPEED.map(lambda speed: WheelVelocity(speed, speed))
TORQUE = st.sampled_from([0.0, 0.3, -0.3]) | st.floats(-3.0, 3.0)
TORQUES = st.builds(WheelTorque, TORQUE, TORQUE)
COULOMB = st.sampled_from([1e-3, 0.3, 5.0]) | st.floats(1e-6, 10.0)
PERIODS = st.sampled_from([0.00025, 0.002, 0.005, 0.033, 0.2])
MOTORS = st.builds(lambda line, time: Motor(*line, time), st.sampled_from([(0.0, 0.0), (1.4, 6.4), (0.3, 1.0)]),
                   st.sampled_from([0.0, 1e-4, 0.002, 0.05, 2.0]))


def moving(speeds, robot):
    return PlantState(Pose(0.0, 0.0, 0.3), body_velocity(speeds, robot), 0.0, 0.0)


def energy(state, robot):
    """Eq. (10)."""
    a, b = linear_inertia(robot), angular_inertia(robot)
    right, left = wheel_velocity(state.velocity, robot)
    return 0.25 * (a * (right + left)**2 + b * (right - left)**2)


def within_stall(torque, motor):
    limit = motor.stall_torque or 1e12
    return WheelTorque(*(max(-limit, min(limit, each)) for each in torque))


@settings(max_examples=150)
@given(ROBOTS, SPEEDS, TORQUES, TORQUES, COULOMB, PERIODS)
def test_no_energy_comes_out_of_friction(robot, speeds, torque, outside, coulomb, dt):
    robot = robot._replace(viscous_friction=0.0)
    drive = discretise_drivetrain(discretise(robot, dt), Motor(), Friction(coulomb))
    start = moving(speeds, robot)
    end, _, applied = motorised_step(start, MotorState(torque), torque, outside, drive)
    assert applied == torque
    # held torques do work over the angles; what is lacking is the work of the friction
    work = (torque.right + outside.right) * end.right_angle + (torque.left + outside.left) * end.left_angle
    scale = energy(start, robot) + energy(end, robot) + abs(work)
    assert energy(end, robot) - energy(start, robot) - work <= 1e-11 * scale
    # it does no more than the friction over the whole way, of which the angles are the least
    least = -coulomb * (abs(end.right_angle) + abs(end.left_angle))
    assert energy(end, robot) - energy(start, robot) - work <= least + 1e-11 * (scale - least) + 1e-25


@settings(max_examples=100)
@given(ROBOTS, SPEEDS, TORQUES, TORQUES, TORQUES, COULOMB | st.just(0.0), MOTORS, PERIODS, st.booleans())
def test_every_step_ends_within_what_the_torques_can_do(
        robot, speeds, begun, asked, outside, coulomb, motor, dt, coupling):
    # with the Coriolis pair a long period is many short ones
    dt = min(dt, 0.005) if coupling else dt
    drive = discretise_drivetrain(discretise(robot, dt, coupling), motor, Friction(coulomb))
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


@given(ROBOTS, TORQUES, TORQUES, MOTORS, PERIODS, st.booleans())
def test_at_rest_within_the_friction_nothing_changes_at_all(robot, begun, asked, motor, dt, coupling):
    begun, asked = within_stall(begun, motor), within_stall(asked, motor)
    coulomb = max(map(abs, (*begun, *asked))) + 1e-6
    drive = discretise_drivetrain(discretise(robot, dt, coupling), motor, Friction(coulomb))
    start = moving(WheelVelocity(0.0, 0.0), robot)
    end, motors = start, MotorState(begun)
    for _ in range(3):
        end, motors, _ = motorised_step(end, motors, asked, NONE, drive)
        assert end == start


@given(ROBOTS, SPEEDS, COULOMB, PERIODS, MOTORS)
def test_without_a_torque_every_robot_comes_to_rest_and_stays(robot, speeds, coulomb, dt, motor):
    drive = discretise_drivetrain(discretise(robot, dt), motor, Friction(coulomb))
    # each wheel's momentum is taken by its friction; the energy's root falls at a bounded rate
    largest = max(linear_inertia(robot), angular_inertia(robot))
    start = moving(speeds, robot)
    longest = math.sqrt(2.0 * energy(start, robot) * largest) / coulomb * 2.0
    drive = drive if longest < 50.0 * dt else discretise_drivetrain(
        discretise(robot, longest / 50.0 + dt), motor, Friction(coulomb))
    state, motors, last = start, MotorState(NONE), math.inf
    for _ in range(60):
        state, motors, _ = motorised_step(state, motors, NONE, NONE, drive)
        now = energy(state, robot)
        assert now <= last * (1.0 + 1e-12)
        last = now
    assert tuple(state.velocity) == (0.0, 0.0)
    assert motorised_step(state, motors, NONE, NONE, drive)[0] == state


@given(ROBOTS, SPEEDS, TORQUES, TORQUES, COULOMB, MOTORS, PERIODS)
def test_mirrored_wheels_move_a_mirrored_robot(robot, speeds, begun, asked, coulomb, motor, dt):
    drive = discretise_drivetrain(discretise(robot, dt), motor, Friction(coulomb))
    begun, asked = within_stall(begun, motor), within_stall(asked, motor)
    one, _, applied = motorised_step(moving(speeds, robot), MotorState(begun), asked, NONE, drive)
    other, _, mirrored = motorised_step(
        moving(WheelVelocity(speeds.left, speeds.right), robot), MotorState(WheelTorque(begun.left, begun.right)),
        WheelTorque(asked.left, asked.right), NONE, drive)
    largest = 1.0 + max(map(abs, (*speeds, *wheel_velocity(one.velocity, robot))))
    assert (other.left_angle, other.right_angle) == pytest.approx(
        (one.right_angle, one.left_angle), abs=1e-9 * largest)
    assert (mirrored.left, mirrored.right) == pytest.approx(applied, abs=1e-9)


@given(TORQUES, st.floats(-0.999, 0.999), COULOMB, st.sampled_from([-1.0, 0.0, 1.0]),
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
