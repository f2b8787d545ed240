"""The plant: Eq. (5)-(6) and (13)-(15) over one sampling period."""

import math
from decimal import Decimal, localcontext

import chapter
import numpy as np
import pytest
from each import each_row
from scipy.linalg import expm

from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque

ROBOT = Robot()


def moving(linear, angular, heading=0.0):
    return PlantState(Pose(0.0, 0.0, heading), BodyVelocity(linear, angular), 0.0, 0.0)


def exact_wheels(right, left, torque, dt):
    """Eq. (13)-(14) as x' = F x + G tau, solved by the exponential of the augmented matrix."""
    inertia = np.array([[chapter.A, chapter.B], [chapter.B, chapter.A]])
    augmented = np.zeros((4, 4))
    augmented[:2, :2] = -chapter.K * np.linalg.inv(inertia)
    augmented[:2, 2:] = np.linalg.inv(inertia)
    return (expm(augmented * dt) @ [right, left, *torque])[:2]


@each_row('dt', [5e-5, 0.002, 0.1, 1.0, 7.0])
def test_equations_13_and_14_exactly_over_one_step(dt):
    torque = WheelTorque(0.7, -0.3)
    end = dynamics.step(moving(0.4, -1.2), torque, discretise(ROBOT, dt))
    expected = exact_wheels(*chapter.wheels(0.4, -1.2), torque, dt)
    assert wheel_velocity(end.velocity, ROBOT) == pytest.approx(tuple(expected), rel=1e-12)


@each_row(('coupling', 'heading_bound', 'velocity_bound'), [(False, 1e-10, 1e-11), (True, 1e-9, 1e-9)])
def test_one_lap_of_varying_torques_against_a_solver(coupling, heading_bound, velocity_bound):
    torques, dt = [], 0.004
    for t in (dt * k for k in range(4000)):
        common = 0.5 + 0.6 * math.sin(2.0 * math.pi * t / 7.0)
        differential = 0.08 + 0.5 * math.sin(2.0 * math.pi * t / 5.0 + 1.0)
        torques.append((common + differential, common - differential))
    plant, solver = discretise(ROBOT, dt, coupling), chapter.drive([1.0, -2.0, 0.5, 0, 0, 0, 0], torques, dt,
                                                                   coupling=coupling)
    state = dynamics.at_rest(Pose(1.0, -2.0, 0.5))
    worst_position = worst_heading = worst_velocity = worst_angle = fastest = 0.0
    for torque, expected in zip(torques, solver, strict=True):
        state = dynamics.step(state, WheelTorque(*torque), plant)
        x, y, heading, right_angle, left_angle, right, left = expected
        v, omega = chapter.body(right, left)
        worst_position = max(worst_position, math.hypot(state.pose.x - x, state.pose.y - y))
        worst_heading = max(worst_heading, abs(chapter.wrapped_difference(state.pose.heading, heading)))
        worst_velocity = max(worst_velocity, abs(state.velocity.linear - v), abs(state.velocity.angular - omega))
        worst_angle = max(worst_angle, abs(state.right_angle - right_angle), abs(state.left_angle - left_angle))
        fastest = max(fastest, abs(v))
    assert fastest > 2.0
    assert worst_position < 1e-9
    assert worst_heading < heading_bound
    assert worst_velocity < velocity_bound
    # the wheels turn by some 1e3 rad
    assert worst_angle < 1e-8


def test_the_wheel_angles_are_the_integrals_of_the_wheel_velocities():
    # without friction and torque the wheels keep turning as they do
    plant = discretise(Robot(viscous_friction=0.0), 0.5)
    end = dynamics.step(moving(0.245, 0.6), WheelTorque(0.0, 0.0), plant)
    assert (end.right_angle, end.left_angle) == pytest.approx((5.0, 2.0), rel=1e-14)
    again = dynamics.step(end, WheelTorque(0.0, 0.0), plant)
    assert (again.right_angle, again.left_angle) == pytest.approx((10.0, 4.0), rel=1e-14)


@each_row('exponent', [1e-12, 1e-6, 1e-3, 0.1, 0.4999999, 0.5, 0.5000001, 1.0, 5.0, 40.0])
def test_the_step_response_is_exact_for_any_friction(exponent):
    # K = (A+B) * exponent over dt = 2 s, against sixty digits
    rate = exponent / 2.0
    response = discretise(Robot(viscous_friction=rate * 0.007125), 2.0).linear.end
    with localcontext() as context:
        context.prec = 60
        a, t = Decimal(rate), Decimal(2)
        decay = (-a * t).exp()
        gain = (1 - decay) / a
        travel = (t - gain) / a
    assert response == pytest.approx((float(decay), float(gain), float(travel)), rel=5e-15 * (1.0 + exponent))


def test_at_rest_nothing_moves_and_the_heading_is_wrapped():
    state = dynamics.at_rest(Pose(1.0, 2.0, -math.pi))
    assert state == PlantState(Pose(1.0, 2.0, math.pi), BodyVelocity(0.0, 0.0), 0.0, 0.0)
    assert dynamics.step(state, WheelTorque(0.0, 0.0), discretise(ROBOT, 0.002)) == state


@each_row('value', [1e6, -1e6, math.inf, -math.inf, math.nan])
@each_row('place', ['x', 'y', 'linear', 'angular'])
def test_a_large_or_nonfinite_component_counts_as_diverged(place, value):
    pose, velocity = Pose(0.0, 0.0, 0.0), BodyVelocity(0.0, 0.0)
    if place in ('x', 'y'):
        pose = pose._replace(**{place: value})
    else:
        velocity = velocity._replace(**{place: value})
    assert dynamics.diverged(PlantState(pose, velocity, 0.0, 0.0))


def test_ordinary_motion_does_not_count_as_diverged():
    assert not dynamics.diverged(PlantState(Pose(9e5, -9e5, 3.0), BodyVelocity(-9e5, 9e5), 1e9, -1e9))


@each_row('coupling', [False, True])
@each_row('torque', [(1e308, 0.0), (-1e308, 1e308), (1e300, 1e20), (1e154, 1e154)])
def test_absurd_torques_diverge_and_do_not_raise(coupling, torque):
    plant = discretise(ROBOT, 0.002, coupling)
    state = dynamics.at_rest(Pose(1.0, 0.0, 1.0))
    for _ in range(3):
        state = dynamics.step(state, WheelTorque(*torque), plant)
    assert dynamics.diverged(state)
