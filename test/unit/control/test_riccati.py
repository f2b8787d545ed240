"""The discrete algebraic Riccati equation in plain Python, against SciPy's."""

import numpy as np
import pytest
from each import each_row
from scipy.linalg import solve_discrete_are

from mobile_robot_control.control.riccati import diagonal, optimal_feedback, riccati, solved


def _tuples(array):
    return tuple(tuple(map(float, row)) for row in array)


def test_scalar_equations_by_hand():
    # x = x - x² / (1 + x) + 1: x² - x - 1 = 0, and k = x / (1 + x)
    golden = 0.5 * (1.0 + 5.0 ** 0.5)
    one = diagonal((1.0,) * 3)
    x, k = np.array(riccati(one, one, one, one)), np.array(optimal_feedback(one, one, one, one))
    assert x == pytest.approx(golden * np.eye(3), rel=1e-14)
    assert k == pytest.approx(golden / (1.0 + golden) * np.eye(3), rel=1e-14)


def test_a_system_of_equations_whose_pivots_must_be_exchanged():
    assert solved(((0.0, 2.0), (4.0, 1.0)), ((6.0,), (7.0,))) == ((1.0,), (3.0,))


@each_row('seed', range(32))
def test_random_systems_have_the_solution_of_scipy(seed):
    draws = np.random.default_rng(seed)
    inputs = draws.integers(1, 4)
    a, b = draws.normal(size=(3, 3)), draws.normal(size=(3, inputs))
    q, r = np.diag(draws.uniform(0.1, 9.0, 3)), np.diag(draws.uniform(0.1, 9.0, inputs))
    expected = solve_discrete_are(a, b, q, r)
    found = np.array(riccati(*map(_tuples, (a, b, q, r))))
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-8 * abs(expected).max())
    gains = np.array(optimal_feedback(*map(_tuples, (a, b, q, r))))
    assert gains == pytest.approx(np.linalg.solve(r + b.T @ expected @ b, b.T @ expected @ a), rel=1e-7, abs=1e-8)
    assert abs(np.linalg.eigvals(a - b @ gains)).max() < 1.0


def test_a_system_that_no_input_stabilises_is_refused():
    with pytest.raises(ValueError, match='no stabilising solution'):
        riccati(diagonal((2.0, 0.5, 0.5)), ((0.0,), (1.0,), (1.0,)), diagonal((1.0, 1.0, 1.0)), ((1.0,),))
