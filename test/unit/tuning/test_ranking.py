"""Ranks as far as paired differences tell controllers apart."""

import itertools

import numpy as np
import pytest

from mobile_robot_control.tuning.monte_carlo import Judged
from mobile_robot_control.tuning.ranking import better_pairs, quantile, rank_ranges, ranked, shared_scenarios

RUNS = 60


def _runs(errors, failing=()):
    return [Judged(n not in failing, {'rms_position_error': error}) for n, error in enumerate(errors)]


def _noisy(mean, seed, spread=0.001):
    return _runs(mean + spread * np.random.default_rng(seed).standard_normal(RUNS))


def test_laws_whose_errors_are_far_apart_have_a_rank_each_and_those_that_are_not_share_theirs():
    found = ranked({'slow': _noisy(0.03, 1), 'best': _noisy(0.01, 2), 'alike': _noisy(0.01, 3)})
    assert found == {'best': (1, 2), 'alike': (1, 2), 'slow': (3, 3)}


def test_success_counts_before_the_error():
    assert ranked({'small': _runs([0.01] * RUNS, range(20)), 'sure': _runs([0.05] * RUNS)}) == {
        'sure': (1, 1), 'small': (2, 2)}


def test_a_law_that_could_not_be_judged_comes_last_and_changes_no_other_rank():
    both = {'a': _noisy(0.01, 1), 'b': _noisy(0.02, 2)}
    assert ranked(both) == {'a': (1, 1), 'b': (2, 2)}
    assert ranked({'broken': [], **both, 'broken too': []}) == {
        'a': (1, 1), 'b': (2, 2), 'broken': (3, 4), 'broken too': (3, 4)}
    assert ranked({'broken': []}) == {'broken': (1, 1)}


def test_two_that_cannot_be_told_apart_have_a_rank_in_common_whatever_the_others_are():
    names = 'abcd'
    pairs = list(itertools.combinations(names, 2))
    for winners in itertools.product((0, 1, 2), repeat=len(pairs)):
        better = [pair if won == 1 else pair[::-1] for pair, won in zip(pairs, winners, strict=True) if won]
        ranks = rank_ranges(names, better)
        for pair, won in zip(pairs, winners, strict=True):
            (a, last_a), (b, last_b) = (ranks[name] for name in pair)
            if not won:
                assert max(a, b) <= min(last_a, last_b)
        assert all(1 <= first <= last <= len(names) for first, last in ranks.values())


def test_ranks_hold_together_with_95_per_cent_where_no_law_is_better():
    """With 0.05 for each of the 21 pairs, some law of seven would be placed wrongly in most tables."""
    rng = np.random.default_rng(5)
    tables = 200
    wrong = sum(bool(better_pairs({str(n): _runs(0.01 + 0.001 * rng.standard_normal(RUNS)) for n in range(7)}))
                for _ in range(tables))
    # 0.025 of these tables are expected: success and error have a half of 5 % each
    assert wrong <= 13


def test_errors_are_compared_where_all_succeed_but_those_that_fail_mostly():
    runs = {'a': _runs([0.01] * 10, {1}), 'b': _runs([0.02] * 10, {2, 3}), 'hopeless': _runs([0.1] * 10, range(6))}
    assert shared_scenarios(runs) == [0, 4, 5, 6, 7, 8, 9]


@pytest.mark.parametrize(('fraction', 'value'), [(0.5, 2.0), (0.75, 3.0), (1.0, None)])
def test_a_quantile_is_that_of_a_study_and_none_where_it_is_infinite(fraction, value):
    assert quantile([3.0, float('inf'), 1.0, 2.0], fraction) == value
    assert quantile([], fraction) is None
