"""Motors and Coulomb friction: torque-speed line, lag, which wheel stands, and what a step with them reports."""

import math

import pytest

from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.disturbance import Disturbance
from mobile_robot_control.model.driven import driven_step, is_uneventful, motorised_step, stands
from mobile_robot_control.model.drivetrain import discretise_drivetrain, has_ideal_motors
from mobile_robot_control.model.dynamics import PlantState, at_rest
from mobile_robot_control.model.friction import Directions, Friction, released
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.motors import Delay, Motor, MotorState, delayed, empty_line, motors_at_rest
from mobile_robot_control.model.plant import Imperfections, actuated_step
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.model.wheels import Forcing
from mobile_robot_control.parameters.declaration import ParameterError, build
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque, WheelVelocity

ROBOT, DT = Robot(), 0.002
NONE, REST = WheelTorque(0.0, 0.0), Directions(0.0, 0.0)
IDEAL, LINE = Motor(), Motor(stall_torque=1.4, no_load_speed=6.4)


def turning(right, left, robot=ROBOT):
    return PlantState(Pose(0.0, 0.0, 0.3), body_velocity(WheelVelocity(right, left), robot), 0.0, 0.0)


def drivetrain(motor=IDEAL, coulomb=0.0, dt=DT, robot=ROBOT):
    return discretise_drivetrain(discretise(robot, dt), motor, Friction(coulomb))


@pytest.mark.parametrize(('motor', 'coulomb', 'ideal'), [
    (IDEAL, 0.0, True), (LINE, 0.0, False), (Motor(time_constant=0.01), 0.0, False), (IDEAL, 0.01, False)])
def test_both_groups_are_ideal_by_default_and_then_alone(motor, coulomb, ideal):
    assert has_ideal_motors(motor, Friction(coulomb)) is ideal


@pytest.mark.parametrize(('given', 'missing'), [
    ({'stall_torque': 1.4}, 'needs motor.no_load_speed'), ({'no_load_speed': 6.4}, 'needs motor.stall_torque'),
    ({'time_constant': 1e-300}, 'write a larger number, or 0'),
    ({'stall_torque': 1.0, 'no_load_speed': 1e-300}, 'write a larger number, or 0'),
])
def test_half_a_line_and_what_cannot_be_divided_by_is_refused_with_the_remedy(given, missing):
    with pytest.raises(ParameterError, match=missing) as refused:
        build(Motor, given)
    assert len(refused.value.violations) == 1


def test_the_lag_is_a_first_order_one_and_its_mean_is_applied():
    drive = drivetrain(Motor(time_constant=0.01))
    state, motors, impulse = at_rest(Pose(0.0, 0.0, 0.0)), motors_at_rest(), 0.0
    for n in range(1, 21):
        state, motors, applied = motorised_step(state, motors, WheelTorque(1.0, -0.5), NONE, drive)
        reached = 1.0 - math.exp(-n * DT / 0.01)
        assert motors.torque == pytest.approx((reached, -0.5 * reached), rel=1e-13)
        impulse += applied.right * DT
        assert impulse == pytest.approx(n * DT - 0.01 * reached, rel=1e-12)


def test_with_ideal_motors_delay_limit_and_disturbance_are_those_of_the_plant_without_motors():
    plant = discretise(ROBOT, DT)
    imperfect = Imperfections(delay=Delay(1), disturbance=Disturbance(0.0, (0.001, 0.0), (0.0, 0.3)))
    old, line = turning(2.0, 1.0), empty_line(imperfect.delay)
    new, motors, other = old, motors_at_rest(), line
    for k, torque in enumerate([WheelTorque(2.0, -0.3), WheelTorque(0.1, 0.2), WheelTorque(0.0, 0.0)]):
        old, line, *torques = actuated_step(old, line, torque, k, plant, imperfect, 0.5, ())
        new, motors, other, *others = driven_step(
            new, motors, other, torque, k, drivetrain(), imperfect, 0.5)
        assert (new, other, others) == (old, line, torques)


def test_the_stall_torque_limits_the_motor_and_not_the_disturbance():
    imperfect = Imperfections(disturbance=Disturbance(0.0, (0.0, 0.0), (5.0, 5.0)))
    state, _, _, acting, applied = driven_step(
        turning(-3.0, -3.0), motors_at_rest(), (), WheelTorque(3.0, 3.0), 0, drivetrain(LINE), imperfect, 0.0)
    assert (acting, applied) == (WheelTorque(3.0, 3.0), WheelTorque(1.4, 1.4))
    # (A+B) dw/dt = 1.4 + 5
    assert wheel_velocity(state.velocity, ROBOT).right == pytest.approx(-3.0 + DT * 6.4 / 0.007125, rel=1e-2)


def test_a_motor_at_its_stall_torque_is_not_held_there_by_rounding():
    # asked + (begun - asked) is a little more than begun, which is all that a motor at rest can give
    asked, dt = WheelTorque(0.0, -0.057514901958833714), 0.005
    assert asked.left + (0.3 - asked.left) > 0.3
    drive = drivetrain(Motor(0.3, 6.4, 0.002), 1.0, dt)
    _, _, applied = motorised_step(turning(-1.0, 0.0), MotorState(WheelTorque(0.0, 0.3)), asked, NONE, drive)
    mean = asked.left + (0.3 - asked.left) * 0.002 / dt * (1.0 - math.exp(-dt / 0.002))
    assert applied.left == pytest.approx(mean, rel=1e-12)


@pytest.mark.parametrize(('directions', 'torque', 'expected'), [
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


@pytest.mark.parametrize(('speed', 'asked', 'fading', 'expected'), [
    (0.0, 0.5, 0.1, True), (1.0, 0.5, 0.1, False), (0.0, 0.9, 0.1, False), (0.0, 0.5, 0.5, False)])
def test_a_wheel_stands_while_no_torque_exceeds_its_friction(speed, asked, fading, expected):
    assert stands(speed, asked, fading, 0.2, 1.0) is expected


@pytest.mark.parametrize(('motor', 'coulomb', 'speed', 'asked', 'expected'), [
    (IDEAL, 0.0, 0.0, 1.0, True), (IDEAL, 0.1, 0.0, 1.0, False), (IDEAL, 0.1, 5.0, 1.0, True),
    (LINE, 0.0, 1.0, 0.5, True), (LINE, 0.0, 6.0, 1.4, False), (LINE, 0.1, 1.0, 0.5, True),
    (LINE, 0.0, -1.0, -0.5, True), (LINE, 0.0, -6.0, -1.4, False),
])
def test_a_period_without_friction_or_line_to_meet_has_no_event(motor, coulomb, speed, asked, expected):
    wheels, forcing = WheelVelocity(speed, speed), Forcing(WheelTorque(asked, asked), NONE, 0.0)
    assert is_uneventful(wheels, NONE, forcing, drivetrain(motor, coulomb)) is expected


@pytest.mark.parametrize('side', ['right', 'left'])
def test_a_wheel_that_stands_beside_one_that_turns_has_no_speed_at_all(side):
    drive = drivetrain(coulomb=0.5)
    for n in range(1, 40):
        start = turning(**{'right': 0.37 * n, 'left': 0.37 * n, side: 0.0})
        end, _, _ = motorised_step(start, motors_at_rest(), NONE, NONE, drive)
        assert getattr(wheel_velocity(end.velocity, ROBOT), side) == 0.0
        assert end.velocity != BodyVelocity(0.0, 0.0)


@pytest.mark.parametrize('steps', [0, 1, 3])
def test_torques_are_applied_late_by_the_delay(steps):
    line, acting, asked = empty_line(Delay(steps)), [], [WheelTorque(float(k), -float(k)) for k in range(1, 7)]
    for one in asked:
        line, torque = delayed(line, one)
        acting.append(torque)
        assert len(line) == steps
    assert acting == ([WheelTorque(0.0, 0.0)] * steps + asked)[:6]
