"""The linear-quadratic law, its model, table and Riccati equation in plain Python, against SciPy's."""

import math

import numpy as np
import pytest
from helpers.observation import ask
from scipy.linalg import expm, solve_discrete_are

from mobile_robot_control.control import lqr
from mobile_robot_control.control.lqr import (
    SPEEDS,
    TURNS,
    LqrWeights,
    error_dynamics,
    feedback,
    optimal_feedback,
    prepare,
    riccati,
)

WEIGHTS, DT = LqrWeights(q1=4.0, q2=30.0, q3=2.0), 0.01
TABLE = prepare(WEIGHTS, DT)


def gains_at(*velocity):
    """K, read from the commands for small errors."""
    here, *there = (np.array(ask(lqr, error, velocity, TABLE, DT)[1])
                    for error in [(0.0, 0.0, 0.0), *map(tuple, 1e-6 * np.eye(3))])
    return np.array([(command - here) / 1e-6 for command in there]).T


def optimal(a, b, q, r):
    """Return the solution of the equation and the gains, by SciPy."""
    a, b, q, r = map(np.array, (a, b, q, r))
    x = solve_discrete_are(a, b, q, r)
    return x, np.linalg.solve(r + b.T @ x @ b, b.T @ x @ a)


@pytest.mark.parametrize(('v_r', 'omega_r'), [(0.4, 0.0), (0.4, 1e-3), (0.4, -0.02), (-0.7, 2.0), (0.0, 1.0)])
@pytest.mark.parametrize('dt', [0.01, 0.5])
def test_the_model_is_the_linearised_one_exactly_over_a_period(v_r, omega_r, dt):
    whole = np.zeros((5, 5))
    whole[:3] = [[0.0, omega_r, 0.0, 1.0, 0.0], [-omega_r, 0.0, v_r, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0]]
    assert np.hstack(error_dynamics(v_r, omega_r, dt)) == pytest.approx(expm(whole * dt)[:3], abs=1e-11)


@pytest.mark.parametrize('v_r', [SPEEDS[0], SPEEDS[4], -SPEEDS[4], SPEEDS[-1]])
@pytest.mark.parametrize('omega_r', [0.0, TURNS[5], -TURNS[5], TURNS[-1]])
def test_at_the_nodes_of_the_table_the_command_is_optimal_for_all_signs(v_r, omega_r):
    # sin and cos of e3 are 1e-12 from linear
    _, expected = optimal(*error_dynamics(v_r, omega_r, DT), np.diag(WEIGHTS), np.eye(2))
    assert gains_at(v_r, omega_r) == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(('v_r', 'omega_r'), [(0.4, 0.2), (0.22, -1.1), (0.65, 1.9), (-1.0, 0.6)])
def test_between_the_nodes_the_gains_are_near_the_optimal_ones(v_r, omega_r):
    exact = np.reshape(feedback(WEIGHTS, v_r, omega_r, DT), (2, 3))
    assert gains_at(v_r, omega_r) == pytest.approx(exact, abs=0.06 * abs(exact).max())


def test_beyond_the_table_its_edge_holds_and_the_lateral_gain_fades_where_the_cart_stands():
    assert gains_at(5.0, 9.0) == pytest.approx(gains_at(SPEEDS[-1], TURNS[-1]), abs=1e-4)
    lateral = [gains_at(share * SPEEDS[0], 0.0)[1, 1] for share in (1.0, 0.5, 0.0, -0.5)]
    full = math.sqrt(WEIGHTS.q2)
    assert lateral == pytest.approx([full, 0.5 * full, 0.0, -0.5 * full], rel=0.05)


def test_scalar_equations_by_hand():
    # x = x - x² / (1 + x) + 1: x² - x - 1 = 0, and k = x / (1 + x)
    golden, one = 0.5 * (1.0 + 5.0 ** 0.5), tuple(map(tuple, np.eye(3).tolist()))
    # the third state has no input, and decays at once
    found = np.array(riccati((*one[:2], (0.0, 0.0, 0.0)), ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0)), (1.0, 1.0, 1.0)))
    assert found == pytest.approx(np.diag([golden, golden, 1.0]), rel=1e-14)


@pytest.mark.parametrize('seed', range(32))
def test_random_systems_have_the_solution_of_scipy(seed):
    draws = np.random.default_rng(seed)
    a, b, q = draws.normal(size=(3, 3)), draws.normal(size=(3, 2)), draws.uniform(0.1, 9.0, 3)
    x, gains = optimal(a, b, np.diag(q), np.eye(2))
    plain = (*(tuple(map(tuple, array.tolist())) for array in (a, b)), tuple(q.tolist()))
    assert np.array(riccati(*plain)) == pytest.approx(x, rel=1e-8, abs=1e-8 * abs(x).max())
    assert np.reshape(optimal_feedback(*plain), (2, 3)) == pytest.approx(gains, rel=1e-7, abs=1e-8)


def test_a_system_that_no_input_stabilises_is_refused():
    with pytest.raises(ValueError, match='no stabilising solution'):
        riccati(((2.0, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.0, 0.5)), ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), (1.0,) * 3)
