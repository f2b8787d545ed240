"""Ranks as far as paired differences tell controllers apart."""

import itertools

import numpy as np
import pytest

from mobile_robot_control.benchmarking.ranking import better_pairs, quantile, rank_ranges, ranked, shared_scenarios
from mobile_robot_control.loop.monte_carlo import Judged

RUNS = 60


def _runs(errors, failing=()):
    return [Judged(n not in failing, {'rms_position_error': error}) for n, error in enumerate(errors)]


def _noisy(mean, seed):
    return _runs(mean + 0.001 * np.random.default_rng(seed).standard_normal(RUNS))


@pytest.mark.parametrize(('runs', 'ranks'), [
    # far apart, and not
    ({'slow': _noisy(0.03, 1), 'best': _noisy(0.01, 2), 'alike': _noisy(0.01, 3)},
     {'best': (1, 2), 'alike': (1, 2), 'slow': (3, 3)}),
    # success counts before the error
    ({'small': _runs([0.01] * RUNS, range(20)), 'sure': _runs([0.05] * RUNS)}, {'sure': (1, 1), 'small': (2, 2)}),
    # what could not be judged comes last and changes no other rank
    ({'a': _noisy(0.01, 1), 'b': _noisy(0.02, 2)}, {'a': (1, 1), 'b': (2, 2)}),
    ({'broken': [], 'a': _noisy(0.01, 1), 'b': _noisy(0.02, 2), 'broken too': []},
     {'a': (1, 1), 'b': (2, 2), 'broken': (3, 4), 'broken too': (3, 4)}),
    ({'broken': []}, {'broken': (1, 1)}),
])
def test_laws_that_can_be_told_apart_have_a_rank_each_and_others_share_theirs(runs, ranks):
    assert ranked(runs) == ranks


def test_two_that_cannot_be_told_apart_have_a_rank_in_common_whatever_the_others_are():
    names = 'abcd'
    pairs = list(itertools.combinations(names, 2))
    for winners in itertools.product((0, 1, 2), repeat=len(pairs)):
        better = [pair if won == 1 else pair[::-1] for pair, won in zip(pairs, winners, strict=True) if won]
        ranks = rank_ranges(names, better)
        for (a, b), won in zip(pairs, winners, strict=True):
            assert won or max(ranks[a][0], ranks[b][0]) <= min(ranks[a][1], ranks[b][1])
        assert all(1 <= first <= last <= len(names) for first, last in ranks.values())


def test_ranks_hold_together_with_95_per_cent_where_no_law_is_better():
    """With 0.05 for each of the 21 pairs, some law of seven would be placed wrongly in most tables."""
    rng = np.random.default_rng(5)
    wrong = sum(bool(better_pairs({str(n): _runs(0.01 + 0.001 * rng.standard_normal(RUNS)) for n in range(7)}))
                for _ in range(200))
    # 0.025 of these tables are expected: success and error have a half of 5 % each
    assert wrong <= 13


def test_errors_are_compared_where_all_succeed_but_those_that_fail_mostly():
    runs = {'a': _runs([0.01] * 10, {1}), 'b': _runs([0.02] * 10, {2, 3}), 'hopeless': _runs([0.1] * 10, range(6))}
    assert shared_scenarios(runs) == [0, 4, 5, 6, 7, 8, 9]


def test_a_quantile_is_that_of_a_study_and_none_where_it_is_infinite():
    assert [quantile([3.0, float('inf'), 1.0, 2.0], fraction) for fraction in (0.5, 0.75, 1.0)] == [2.0, 3.0, None]
    assert quantile([], 0.5) is None
