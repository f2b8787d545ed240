"""Tail probabilities and quantiles: those of SciPy, at the edges too, and of a million runs."""

import itertools
import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy import special, stats

from mobile_robot_control.analysis import intervals as tails

SIZES = st.floats(-0.3, 6.0).map(lambda exponent: 10.0**exponent)


@given(SIZES, SIZES, st.floats(0.0, 1.0))
@example(0.5, 0.5, 0.0)
@example(2.0, 7.5, 1.0)
@example(0.5, 1e3, 1e-9)
@example(5e5, 5e5, 0.4999)
def test_the_incomplete_beta_function_is_that_of_scipy(a, b, x):
    assert tails.incomplete_beta(a, b, x) == pytest.approx(special.betainc(a, b, x), rel=1e-7, abs=1e-12)


@given(SIZES, SIZES, st.floats(0.0007, 0.9993))
@example(1.0, 1e6, 0.0007)
@example(0.5, 0.5, 0.975)
def test_its_quantile_is_that_of_scipy(a, b, probability):
    assert tails.beta_quantile(a, b, probability) == pytest.approx(special.betaincinv(a, b, probability), rel=1e-6)


@pytest.mark.parametrize('case', [*itertools.product([1, 2, 19, 299, 10**6], [0.95, 1.0 - 0.05 / 36])])
def test_the_quantile_of_student_is_that_of_scipy(case):
    freedom, confidence = case
    assert tails.student_quantile(confidence, freedom) == pytest.approx(
        stats.t.ppf(0.5 + 0.5 * confidence, freedom), rel=1e-6)


@pytest.mark.parametrize('case', [(0, 1), (1, 1), (0, 7), (7, 7), (6, 7), (18, 20), (1000, 400_000)])
def test_the_interval_of_a_rate_is_the_exact_one(case):
    successes, trials = case
    exact = stats.binomtest(successes, trials).proportion_ci(0.95, 'exact')
    assert tails.binomial_interval(successes, trials, 0.95) == pytest.approx(tuple(exact), rel=1e-6, abs=1e-12)


@pytest.mark.parametrize('case', [
    (10, 57, 12, 300), (12, 12, 12, 300), (194, 196, 258, 300), (5, 5, 5, 5), (1, 1, 1, 2), (700, 5000, 1000, 10_000),
])
def test_the_tail_of_marked_ones_among_those_drawn_is_that_of_scipy(case):
    found, drawn, marked, total = case
    assert tails.log_hypergeometric_tail(found, drawn, marked, total) == pytest.approx(
        stats.hypergeom.logsf(found - 1, total, marked, drawn), rel=1e-6, abs=1e-9)


def test_the_tail_of_a_million_runs_is_found_where_it_is_far_below_every_float():
    assert -math.inf < tails.log_hypergeometric_tail(50_000, 100_000, 100_000, 1_000_000) < -10_000.0
