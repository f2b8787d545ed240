"""Deviation 8: the Coriolis pair that Eq. (13)-(14) lose."""

import math

import chapter
import numpy as np
import pytest
from each import each_row

from mobile_robot_control.model import coupled, dynamics
from mobile_robot_control.model.discretisation import discretise
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque

ROBOT = Robot()


def moving(linear, angular, heading=0.0):
    return PlantState(Pose(0.0, 0.0, heading), BodyVelocity(linear, angular), 0.0, 0.0)


def accelerations_with_constraint_forces(heading, right, left, torque):
    """
    Derive the motion from the energies (2)-(4) of five free coordinates, then put the rolling constraint in.

    Coordinates x_A, y_A, theta, and both wheel angles; Lagrange multipliers hold the wheels on the ground. Returns
    dv/dt and domega/dt of point A.
    """
    M, d, r, R, K = chapter.M, chapter.d, chapter.r, chapter.R, chapter.K
    cos, sin = math.cos(heading), math.sin(heading)
    v, omega = chapter.body(right, left)
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
    rates = np.array([v * cos, v * sin, omega, right, left])
    system = np.block([[H, -J.T], [J, np.zeros((3, 3))]])
    solution = np.linalg.solve(system, np.concatenate([applied - quadratic, -J_rate @ rates]))
    return chapter.body(solution[3], solution[4])


@each_row('velocity', [(1.0, 2.0), (1.0, -2.0), (-0.7, 3.0), (0.0, 4.0), (2.0, 0.0)])
def test_the_coriolis_pair_follows_from_the_constraint_forces(velocity):
    torque, dt = WheelTorque(0.3, -0.2), 1e-5
    plant = discretise(ROBOT, dt, centripetal_coupling=True)
    dv, domega = accelerations_with_constraint_forces(0.4, *chapter.wheels(*velocity), torque)
    after = dynamics.step(moving(*velocity, heading=0.4), torque, plant).velocity
    back = dynamics.step(moving(-velocity[0], -velocity[1], heading=0.4), torque, plant).velocity
    # a forward difference errs by dt/2 times the second derivative
    assert (after.linear - velocity[0]) / dt == pytest.approx(dv, abs=1e-3)
    assert (after.angular - velocity[1]) / dt == pytest.approx(domega, abs=1e-3)
    # backwards the quadratic forces are the same, while friction turns round
    dv, domega = accelerations_with_constraint_forces(0.4, *chapter.wheels(-velocity[0], -velocity[1]), torque)
    assert (back.linear + velocity[0]) / dt == pytest.approx(dv, abs=1e-3)
    assert (back.angular + velocity[1]) / dt == pytest.approx(domega, abs=1e-3)


def test_the_tests_own_equations_have_the_same_coriolis_pair():
    for velocity in ((1.0, 2.0), (-0.5, 3.0)):
        right, left = chapter.wheels(*velocity)
        accelerations = chapter.wheel_accelerations(right, left, (0.3, -0.2), coupling=True)
        expected = accelerations_with_constraint_forces(0.4, right, left, (0.3, -0.2))
        assert chapter.body(*accelerations) == pytest.approx(expected, rel=1e-12)


@each_row('dt', [5e-5, 2.5e-4, 0.001, 0.002, 0.01])
def test_long_periods_are_as_accurate_as_short_ones(dt):
    # the same 10 ms in one period or in many, to the accuracy that the method keeps
    torque, pose, velocity = WheelTorque(2.0, -1.0), Pose(0.0, 0.0, 0.3), BodyVelocity(2.0, 4.0)
    whole = coupled.advance(pose, velocity, torque, ROBOT, 0.01)
    state, plant = moving(2.0, 4.0, heading=0.3), discretise(ROBOT, dt, centripetal_coupling=True)
    for _ in range(round(0.01 / dt)):
        state = dynamics.step(state, torque, plant)
    assert (state.pose.x, state.pose.y) == pytest.approx((whole.x, whole.y), abs=1e-12)
    assert state.pose.heading == pytest.approx(0.3 + whole.turn, abs=1e-12)
    assert state.velocity == pytest.approx((whole.linear, whole.angular), abs=1e-12)


def test_a_fading_torque_moves_the_robot_as_its_means_over_short_periods():
    torque, fading, rate, h = WheelTorque(0.5, 0.2), WheelTorque(2.0, -1.0), 100.0, 5e-5
    times = np.arange(0.0, 0.01, h)
    share = (np.exp(-rate * times) - np.exp(-rate * (times + h))) / (rate * h)
    torques = [(0.5 + 2.0 * part, 0.2 - 1.0 * part) for part in share]
    *_, (x, y, _, _, _, right, left) = chapter.drive([0.0, 0.0, 0.3, 0, 0, 0, 0], torques, h, coupling=True)
    found = coupled.advance_fading(Pose(0.0, 0.0, 0.3), BodyVelocity(0.0, 0.0), torque, fading, rate, ROBOT, 0.01)
    assert (found.linear, found.angular) == pytest.approx(chapter.body(right, left), rel=1e-5)
    assert (found.x, found.y) == pytest.approx((x, y), rel=1e-4)
