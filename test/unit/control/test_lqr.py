"""The linear-quadratic law: its model, its table, its symmetries."""


import math

import numpy as np
import pytest
from each import each_row
from observation import observed
from scipy.linalg import expm, solve_discrete_are

from mobile_robot_control.control import lqr
from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.lqr import SPEEDS, TURNS, LqrWeights, error_dynamics, feedback, prepare
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError

WEIGHTS, DT = LqrWeights(q1=4.0, q2=30.0, q3=2.0), 0.01
TABLE = prepare(WEIGHTS, DT)


def ask(error, velocity, table=TABLE):
    return lqr.step(NoState(), observed(
        TrackingError(*error), Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(*velocity))), table, DT)[1]


def gains_at(velocity, table=TABLE):
    """K, read from the commands for small errors."""
    columns = []
    for n in range(3):
        error = [1e-6 if m == n else 0.0 for m in range(3)]
        columns.append([(there - here) / 1e-6
                        for there, here in zip(
                            ask(error, velocity, table), ask((0.0,) * 3, velocity, table), strict=True)])
    return np.array(columns).T


@each_row(('v_r', 'omega_r'), [(0.4, 0.0), (0.4, 1e-3), (0.4, -0.02), (-0.7, 2.0), (0.0, 1.0)])
@each_row('dt', [0.01, 0.5])
def test_the_model_is_the_linearised_one_exactly_over_a_period(v_r, omega_r, dt):
    whole = np.zeros((5, 5))
    whole[:3] = [[0.0, omega_r, 0.0, 1.0, 0.0], [-omega_r, 0.0, v_r, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0]]
    step = expm(whole * dt)
    phi, gamma = error_dynamics(v_r, omega_r, dt)
    assert np.array(phi) == pytest.approx(step[:3, :3], abs=1e-13)
    assert np.array(gamma) == pytest.approx(step[:3, 3:], abs=1e-11)


def test_the_gains_are_those_of_a_discrete_riccati_solution():
    weights, dt = WEIGHTS, 0.1
    for row, v_r in [*zip(prepare(weights, dt), SPEEDS, strict=True)][::4]:
        for gains, omega_r in [*zip(row, TURNS, strict=True)][::3]:
            phi, gamma = map(np.array, error_dynamics(v_r, omega_r, dt))
            x = solve_discrete_are(phi, gamma, np.diag(weights), np.eye(2))
            expected = np.linalg.solve(np.eye(2) + gamma.T @ x @ gamma, gamma.T @ x @ phi)
            assert np.reshape(gains, (2, 3)) == pytest.approx(expected, rel=1e-8, abs=1e-8)
            assert abs(np.linalg.eigvals(phi - gamma @ expected)).max() < 1.0


@each_row('v_r', [SPEEDS[0], SPEEDS[4], -SPEEDS[4], SPEEDS[-1]])
@each_row('omega_r', [0.0, TURNS[5], -TURNS[5], TURNS[-1]])
def test_at_the_nodes_of_the_table_the_command_is_optimal_for_all_signs(v_r, omega_r):
    # sin and cos of e3 are 1e-12 from linear
    assert gains_at((v_r, omega_r)) == pytest.approx(np.array(feedback(WEIGHTS, v_r, omega_r, DT)), abs=1e-5)


@each_row(('v_r', 'omega_r'), [(0.4, 0.2), (0.22, -1.1), (0.65, 1.9), (-1.0, 0.6)])
def test_between_the_nodes_the_gains_are_near_the_optimal_ones_and_stabilise(v_r, omega_r):
    exact, found = np.array(feedback(WEIGHTS, v_r, omega_r, DT)), gains_at((v_r, omega_r))
    assert found == pytest.approx(exact, abs=0.06 * abs(exact).max())
    phi, gamma = map(np.array, error_dynamics(v_r, omega_r, DT))
    assert abs(np.linalg.eigvals(phi - gamma @ found)).max() < 1.0


def test_beyond_the_table_its_edge_holds():
    assert gains_at((5.0, 9.0)) == pytest.approx(gains_at((SPEEDS[-1], TURNS[-1])), abs=1e-4)


def test_the_lateral_gain_fades_where_the_cart_stands():
    lateral = [gains_at((v_r, 0.0))[1, 1] for v_r in (SPEEDS[0], 0.5 * SPEEDS[0], 0.0, -0.5 * SPEEDS[0])]
    full = math.sqrt(WEIGHTS.q2)
    assert lateral == pytest.approx([full, 0.5 * full, 0.0, -0.5 * full], rel=0.05)
