"""Coulomb friction: which wheel stands, and that it does."""

import math

import pytest
from each import each_row

from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.driven import motorised_step
from mobile_robot_control.model.drivetrain import discretise_drivetrain
from mobile_robot_control.model.dynamics import PlantState, at_rest
from mobile_robot_control.model.friction import Directions, Friction, released
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.motors import Motor, motors_at_rest
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.parameters.checking import ParameterError, build
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque, WheelVelocity

ROBOT, NONE = Robot(), WheelTorque(0.0, 0.0)
FREE = Robot(viscous_friction=0.0)
REST = Directions(0.0, 0.0)


def drivetrain(coulomb, dt=0.005, robot=ROBOT):
    return discretise_drivetrain(discretise(robot, dt), Motor(), Friction(coulomb))


def turning(right, left, robot=ROBOT):
    return PlantState(Pose(0.0, 0.0, 0.3), body_velocity(WheelVelocity(right, left), robot), 0.0, 0.0)


def advanced(state, torque, drive, steps=1):
    motors = motors_at_rest()
    for _ in range(steps):
        state, motors, _ = motorised_step(state, motors, torque, NONE, drive)
    return state


def test_negative_friction_is_refused():
    with pytest.raises(ParameterError, match='coulomb'):
        build(Friction, {'coulomb': -0.1})


@each_row(('directions', 'torque', 'expected'), [
    # with B/A = -0.5 and a friction of 1 N m
    (REST, (0.9, -1.0), (0.0, 0.0)),
    (REST, (1.1, 0.0), (1.0, 0.0)),
    # the left wheel holds 0.9 + 0.5 (2 - 1) = 1.4 N m, more than it can
    (REST, (2.0, 0.9), (1.0, 1.0)),
    (REST, (2.0, -0.9), (1.0, 0.0)),
    (REST, (-1.2, 1.3), (-1.0, 1.0)),
    (REST, (0.9, 2.0), (1.0, 1.0)),
    # beside a wheel that turns: 0 + 0.5 (3 - 1) = 1.0, and a little more
    (Directions(1.0, 0.0), (3.0, 0.0), (1.0, 0.0)), (Directions(1.0, 0.0), (3.1, 0.0), (1.0, 1.0)),
    (Directions(0.0, -1.0), (0.0, -3.1), (-1.0, -1.0)), (Directions(0.0, -1.0), (0.9, -3.1), (0.0, -1.0)),
    (Directions(-1.0, 1.0), (5.0, -5.0), (-1.0, 1.0)),
])
def test_which_wheels_break_away_by_hand(directions, torque, expected):
    assert released(directions, WheelTorque(*torque), -0.5, 1.0) == expected


@each_row('torque', [(0.3001, 0.3001), (-0.3001, 0.0), (0.0, 0.31), (0.301, -0.301)])
def test_it_moves_beyond_its_friction(torque):
    end = advanced(at_rest(Pose(1.0, 2.0, 0.3)), WheelTorque(*torque), drivetrain(0.3))
    for speed, asked in zip(wheel_velocity(end.velocity, ROBOT), torque, strict=True):
        assert math.copysign(1.0, speed) == math.copysign(1.0, asked) if asked else speed == 0.0


def test_a_coasting_robot_stops_where_the_friction_has_taken_its_energy():
    # without viscous friction: (A+B) w²/2 = F × angle, in w (A+B)/F = 0.7125 s
    state, drive = turning(10.0, 10.0, FREE), drivetrain(0.1, 0.033, FREE)
    before = advanced(state, NONE, drive, 21)
    assert wheel_velocity(before.velocity, FREE).right > 0.0
    end = advanced(state, NONE, drive, 22)
    assert end.velocity == BodyVelocity(0.0, 0.0)
    angle = 0.007125 * 10.0**2 / 2.0 / 0.1
    assert (end.right_angle, end.left_angle) == pytest.approx((angle, angle), rel=1e-12)
    assert end.pose[:2] == pytest.approx((0.035 * angle * math.cos(0.3), 0.035 * angle * math.sin(0.3)), rel=1e-12)
    assert advanced(end, NONE, drive, 5) == end


def test_a_wheel_stands_again_when_the_other_one_no_longer_drags_it_along():
    # B/A < 0 here: as long as the left wheel accelerates, it pulls the right one with it
    state, drive = at_rest(Pose(0.0, 0.0, 0.0)), drivetrain(0.3, 0.033)
    stood = []
    for _ in range(300):
        state = advanced(state, WheelTorque(0.2, 1.0), drive)
        stood.append(wheel_velocity(state.velocity, ROBOT).right == 0.0)
    assert not stood[0]
    assert stood[-1]
    assert sorted(stood) == stood
