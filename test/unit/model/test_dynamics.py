"""Eq. (5)-(7), (13)-(15), (19): constants, kinematics, one period of the plant; deviation 8: the Coriolis pair."""

import math

import numpy as np
import pytest
from helpers import chapter
from scipy.linalg import expm

from mobile_robot_control.model import dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.kinematics import body_velocity, wheel_velocity
from mobile_robot_control.model.robot import Robot, angular_inertia, half_separation, linear_inertia
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque, WheelVelocity

ROBOT = Robot()
OTHER = Robot(wheel_radius=0.1, wheel_separation=0.5)


def moving(linear, angular, heading=0.0):
    return PlantState(Pose(0.0, 0.0, heading), BodyVelocity(linear, angular), 0.0, 0.0)


@pytest.mark.parametrize(('robot', 'wheels', 'body'), [
    # v = 0.0175 * 14, omega = 0.035 * 6 / 0.35
    (ROBOT, (10.0, 4.0), (0.245, 0.6)), (ROBOT, (-2.0, 2.0), (0.0, -0.4)),
    # v = 0.05 * 2, omega = 0.1 * 4 / 0.5
    (OTHER, (3.0, -1.0), (0.1, 0.8)),
])
def test_equations_5_6_7_and_19_with_hand_numbers(robot, wheels, body):
    assert body_velocity(WheelVelocity(*wheels), robot) == pytest.approx(body, abs=1e-15)
    assert wheel_velocity(BodyVelocity(*body), robot) == pytest.approx(wheels, abs=1e-13)


def test_equation_15_with_the_chapters_numbers_and_with_others():
    # A = 0.0030625 + 0.01025 + 0.001 and B = 0.0030625 - 0.01025
    assert linear_inertia(ROBOT) == pytest.approx(0.0143125 - 0.0071875, rel=1e-14)
    assert angular_inertia(ROBOT) == pytest.approx(0.0143125 + 0.0071875, rel=1e-14)
    # r = 1, R = 2: A + B = 4/2 + 0.5, A - B = (3 + 4 * 0.25) / 8 + 0.5
    robot = Robot(mass=4.0, inertia=3.0, wheel_radius=1.0, wheel_separation=4.0, com_offset=-0.5, wheel_inertia=0.5)
    assert (linear_inertia(robot), angular_inertia(robot), half_separation(robot)) == (2.5, 1.0, 2.0)


def test_the_offset_of_the_mass_centre_counts_by_its_square_and_for_turning_alone():
    ahead, behind, none = (Robot(com_offset=offset) for offset in (0.1, -0.1, 0.0))
    assert angular_inertia(ahead) == angular_inertia(behind)
    # M d² r² / (2 R²) with r/R = 1/5
    assert angular_inertia(ahead) - angular_inertia(none) == pytest.approx(10.0 * 0.01 / 50.0, rel=1e-12)
    assert linear_inertia(ahead) == linear_inertia(none)


@pytest.mark.parametrize('dt', [5e-5, 0.002, 0.1, 1.0, 7.0])
def test_equations_13_and_14_exactly_over_one_step(dt):
    # x' = F x + G tau, solved by the exponential of the augmented matrix
    inverse = np.linalg.inv([[chapter.A, chapter.B], [chapter.B, chapter.A]])
    augmented = np.block([[-chapter.K * inverse, inverse], [np.zeros((2, 4))]])
    end = dynamics.step(moving(0.4, -1.2), WheelTorque(0.7, -0.3), discretise(ROBOT, dt))
    expected = (expm(augmented * dt) @ [*chapter.wheels(0.4, -1.2), 0.7, -0.3])[:2]
    assert wheel_velocity(end.velocity, ROBOT) == pytest.approx(tuple(expected), rel=1e-12)


@pytest.mark.parametrize(('coupling', 'heading_bound', 'velocity_bound'), [(False, 1e-10, 1e-11), (True, 1e-9, 1e-9)])
def test_one_lap_of_varying_torques_against_a_solver(coupling, heading_bound, velocity_bound):
    dt = 0.016
    common, differential = ([base + size * math.sin(2.0 * math.pi * dt * k / period + phase) for k in range(1000)]
                            for base, size, period, phase in ((0.5, 0.6, 7.0, 0.0), (0.08, 0.5, 5.0, 1.0)))
    torques = [(both + apart, both - apart) for both, apart in zip(common, differential, strict=True)]
    plant, state = discretise(ROBOT, dt, coupling), dynamics.at_rest(Pose(1.0, -2.0, 0.5))
    solver = chapter.drive([1.0, -2.0, 0.5, 0, 0, 0, 0], torques, dt, coupling=coupling)
    fastest = 0.0
    for torque, (x, y, heading, right_angle, left_angle, right, left) in zip(torques, solver, strict=True):
        state = dynamics.step(state, WheelTorque(*torque), plant)
        assert state.pose[:2] == pytest.approx((x, y), abs=1e-9, rel=0.0)
        assert abs(chapter.wrapped_difference(state.pose.heading, heading)) < heading_bound
        assert state.velocity == pytest.approx(chapter.body(right, left), abs=velocity_bound, rel=0.0)
        # the wheels turn by some 1e3 rad
        assert state[2:] == pytest.approx((right_angle, left_angle), abs=1e-8, rel=0.0)
        fastest = max(fastest, state.velocity.linear)
    assert fastest > 2.0


def test_at_rest_nothing_moves_and_the_heading_is_wrapped():
    state = dynamics.at_rest(Pose(1.0, 2.0, -math.pi))
    assert state == PlantState(Pose(1.0, 2.0, math.pi), BodyVelocity(0.0, 0.0), 0.0, 0.0)
    assert dynamics.step(state, WheelTorque(0.0, 0.0), discretise(ROBOT, 0.002)) == state


@pytest.mark.parametrize('value', [1e6, -1e6, math.inf, -math.inf, math.nan])
def test_a_large_or_nonfinite_component_counts_as_diverged(value):
    # at the origin, at the coordinates of a map, and anywhere else
    for start in (Pose(0.0, 0.0, 0.0), Pose(431254.1, 3771020.25, 1.0), Pose(-1e11, 1e11, 0.0)):
        ordinary = PlantState(Pose(start.x + 9e5, start.y - 9e5, 3.0), BodyVelocity(-9e5, 9e5), 1e9, -1e9)
        assert not dynamics.diverged(ordinary, start)
        for part, name in (('pose', 'x'), ('pose', 'y'), ('velocity', 'linear'), ('velocity', 'angular')):
            one = getattr(ordinary, part)._replace(**{name: value + getattr(start, name, 0.0)})
            assert dynamics.diverged(ordinary._replace(**{part: one}), start), name


@pytest.mark.parametrize('coupling', [False, True])
@pytest.mark.parametrize('torque', [(1e308, 0.0), (-1e308, 1e308), (1e300, 1e20), (1e154, 1e154)])
def test_absurd_torques_diverge_and_do_not_raise(coupling, torque):
    start, plant = Pose(1.0, 0.0, 1.0), discretise(ROBOT, 0.002, coupling)
    state = dynamics.at_rest(start)
    for _ in range(3):
        state = dynamics.step(state, WheelTorque(*torque), plant)
    assert dynamics.diverged(state, start)


def accelerations_with_constraint_forces(heading, v, omega, torque):
    """
    Derive the motion from the energies (2)-(4) of five free coordinates, then put the rolling constraint in.

    Coordinates x_A, y_A, theta, and both wheel angles; Lagrange multipliers hold the wheels on the ground. Returns
    dv/dt and domega/dt of point A.
    """
    M, d, r, R, K = chapter.M, chapter.d, chapter.r, chapter.R, chapter.K
    cos, sin = math.cos(heading), math.sin(heading)
    right, left = chapter.wheels(v, omega)
    # (8), (9): the velocity of C is that of A plus d theta' (-sin, cos), so T = 1/2 q'^T H(q) q'
    H = np.diag([M, M, chapter.I_A + M * d**2, chapter.I_0, chapter.I_0])
    H[0, 2] = H[2, 0] = -M * d * sin
    H[1, 2] = H[2, 1] = M * d * cos
    # d/dt(dT/dq') - dT/dq, without the accelerations
    quadratic = np.array([-M * d * omega**2 * cos, -M * d * omega**2 * sin, 0.0, 0.0, 0.0])
    applied = np.array([0.0, 0.0, 0.0, torque[0] - K * right, torque[1] - K * left])
    # J q' = 0: no sideways slip, and each wheel rolls
    J = np.array([[-sin, cos, 0, 0, 0], [cos, sin, R, -r, 0], [cos, sin, -R, 0, -r]])
    J_rate = omega * np.array([[-cos, -sin, 0, 0, 0], [-sin, cos, 0, 0, 0], [-sin, cos, 0, 0, 0]])
    system = np.block([[H, -J.T], [J, np.zeros((3, 3))]])
    solution = np.linalg.solve(system, np.concatenate([
        applied - quadratic, -J_rate @ [v * cos, v * sin, omega, right, left]]))
    return chapter.body(solution[3], solution[4])


@pytest.mark.parametrize(('v', 'omega'), [(1.0, 2.0), (-1.0, -2.0), (1.0, -2.0), (-0.7, 3.0), (0.0, 4.0), (2.0, 0.0)])
def test_the_coriolis_pair_follows_from_the_constraint_forces(v, omega):
    torque, dt = WheelTorque(0.3, -0.2), 1e-5
    after = dynamics.step(moving(v, omega, 0.4), torque, discretise(ROBOT, dt, centripetal_coupling=True)).velocity
    # a forward difference errs by dt/2 times the second derivative
    assert ((after.linear - v) / dt, (after.angular - omega) / dt) == pytest.approx(
        accelerations_with_constraint_forces(0.4, v, omega, torque), abs=1e-3, rel=0.0)


@pytest.mark.parametrize('dt', [5e-5, 2.5e-4, 0.001, 0.002, 0.01])
def test_long_periods_are_as_accurate_as_short_ones(dt):
    # the same 10 ms in one period or in many, to the accuracy that the method keeps
    torque, state = WheelTorque(2.0, -1.0), moving(2.0, 4.0, heading=0.3)
    whole = dynamics.advance(state.pose, state.velocity, torque, ROBOT, 0.01)
    plant = discretise(ROBOT, dt, centripetal_coupling=True)
    for _ in range(round(0.01 / dt)):
        state = dynamics.step(state, torque, plant)
    assert (*state.pose, *state.velocity) == pytest.approx(
        (whole.x, whole.y, 0.3 + whole.turn, whole.linear, whole.angular), abs=1e-12, rel=0.0)
