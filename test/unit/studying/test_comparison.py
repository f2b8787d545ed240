"""Controllers in the same scenarios: known differences are found, equal ones cannot be told apart."""

import math

import numpy as np
import pytest

from mobile_robot_control.loop.monte_carlo import Judged
from mobile_robot_control.studying.comparison import COMPARED, best_of, compare, compare_all, comparison_values
from mobile_robot_control.studying.comparison import comparison_texts as all_texts

RMS = ('rms_position_error',)
FAILED = Judged(False, dict.fromkeys(COMPARED, math.inf), 'diverged')
NAMES = ('one', 'other')


def judged(*errors):
    """Runs with these errors, late and RMS; None is one that failed."""
    return [FAILED if error is None else Judged(True, dict.fromkeys(COMPARED, float(error))) for error in errors]


def by_rms(ours, theirs):
    """Return a comparison by the RMS error alone, and what it shows of that."""
    found = compare(NAMES, (ours, theirs), RMS)
    return found, found.differences[0]


def drawn(seed, runs=60, spread=0.05):
    """The errors that the scenarios cause by themselves [m]."""
    return np.random.default_rng(seed).lognormal(-3.0, 1.0, runs) + spread


def texts(**controllers):
    return list(all_texts(controllers, RMS))


def test_a_known_difference_is_found_though_the_scenarios_differ_much_more():
    errors = drawn(1)
    ours, theirs = judged(*errors), judged(*(errors + np.random.default_rng(2).normal(0.003, 0.002, errors.size)))
    found, rms = by_rms(ours, theirs)
    assert np.std(errors) > 0.03
    assert rms.interval[0] < -0.003 < rms.interval[1] < 0.0
    assert found.better(rms) == 'one'
    assert found.more_successful == ''
    line, success = texts(one=ours, other=theirs)[1:]
    assert line.startswith('one and other, position error, RMS: that of one is smaller by 0.')
    assert line.endswith(' in the 60 scenarios in which both succeed')
    assert success == 'one and other, success: no significant difference: the same 60 of 60 succeed'


def test_the_numbers_of_a_small_comparison():
    ours, theirs = judged(0.10, 0.20, 0.30, None, 0.5), judged(0.11, 0.22, 0.33, 0.1, None)
    found, rms = by_rms(ours, theirs)
    assert (found.runs, found.both, found.only_first, found.only_second, rms.compared) == (5, 3, 1, 1, 3)
    assert rms.mean == pytest.approx(-0.02)
    # t of 2 degrees of freedom is 4.303, and the spread 0.01
    assert rms.interval == pytest.approx((-0.02 - 0.024841, -0.02 + 0.024841), abs=1e-6)
    assert texts(one=ours, other=theirs)[1:] == [
        'one and other, position error, RMS: no significant difference: that of one minus that of other is -2 cm '
        '(-4.48 to 0.484) in the 3 scenarios in which both succeed; 2 are left out',
        'one and other, success: no significant difference: one alone in 1, other alone in 1 of 5']


@pytest.mark.parametrize(('alone', 'winner'), [
    ((5, 0), ''), ((6, 0), 'one'), ((0, 6), 'other'), ((9, 2), ''), ((10, 2), 'one'),
])
def test_success_is_told_apart_where_the_sign_test_says_so(alone, winner):
    """All of 5 scenarios are 0.06 likely by chance, all of 6 are 0.03."""
    ours = judged(*[0.1] * alone[0], *[None] * alone[1], *[0.1] * 50)
    theirs = judged(*[None] * alone[0], *[0.1] * alone[1], *[0.1] * 50)
    assert compare(NAMES, (ours, theirs)).more_successful == winner
    line = texts(one=ours, other=theirs)[2]
    assert line.partition(', success: ')[2].startswith(f'{winner} succeeds more often' if winner
                                                       else 'no significant difference')


@pytest.mark.parametrize(('ours', 'theirs', 'both'), [((None, 0.1), (0.1, None), 0), ((0.1, None), (0.2, 0.1), 1)])
def test_fewer_than_two_shared_successes_are_not_compared(ours, theirs, both):
    pair, = comparison_values({'one': judged(*ours), 'other': judged(*theirs)}, RMS)
    value, = pair['metrics']
    assert (value['difference_interval'], value['better'], value['difference'] is None) == (None, None, both == 0)
    assert texts(one=judged(*ours), other=judged(*theirs))[1] == (
        f'one and other, position error, RMS: not compared: {both} of 2 scenarios in which both succeed, and two are '
        'needed')


def test_the_intervals_of_all_pairs_hold_together():
    names = ['a', 'b', 'c', 'd']
    made = compare_all({name: judged(*drawn(k)) for k, name in enumerate(names)})
    assert [(one.first, one.second) for one in made] == [(x, y) for k, x in enumerate(names) for y in names[k + 1:]]
    assert {round(one.confidence, 12) for one in made} == {round(1.0 - 0.05 / 6, 12)}
    # of 6 pairs and 2 metrics
    assert {round(found.confidence, 12) for one in made for found in one.differences} == {round(1.0 - 0.05 / 12, 12)}


def test_of_several_each_is_compared_with_the_best_one():
    errors = drawn(1)
    controllers = {'far': judged(*(errors + 0.02)), 'lost': judged(*[None] * 10, *errors[10:]), 'near': judged(*errors)}
    assert best_of(controllers) == 'near'
    head, *lines = all_texts(controllers, RMS)
    assert head == ('compared in the same scenarios with near, the best; the 3 intervals of all pairs and metrics hold '
                    'together with 95 % (each 98.33 %, Bonferroni):')
    assert [line.partition(':')[0] for line in lines] == [
        'far and near, position error, RMS', 'far and near, success', 'lost and near, position error, RMS',
        'lost and near, success']
    assert 'near succeeds more often: lost alone in 0, near alone in 10 of 60' in lines[-1]


def test_a_larger_share_of_the_time_is_better_and_what_is_not_known_is_left_out():
    metrics = ('share_within_band', 'settling_time', 'energy')
    ours, theirs = ([Judged(True, dict(zip(metrics, (*row, math.nan), strict=True))) for row in rows] for rows in (
        ((0.9, 3.0), (0.8, math.inf), (0.9, 4.0), (0.7, 5.0)), ((0.5, 8.0), (0.3, 9.0), (0.45, 9.5), (0.3, 9.9))))
    share, settling, energy = comparison_values({'one': ours, 'other': theirs}, metrics)[0]['metrics']
    assert (share['better'], settling['better'], energy['better']) == ('one', 'one', None)
    assert (share['left_out'], settling['left_out'], energy['compared']) == (0, 1, 0)
    lines = list(all_texts({'one': ours, 'other': theirs}, metrics, band=0.05))[1:]
    assert lines[0].startswith('one and other, share of time within 0.05 m: that of one is larger by 0.438 (')
    assert lines[1].endswith(
        's (3.71 to 6.55) in the 3 scenarios in which both succeed and have a value; 1 is left out')
    assert 'energy: not compared: 0 of 4 scenarios in which both succeed and have a value, and two are' in lines[2]


def test_equal_runs_cannot_be_told_apart_and_a_constant_difference_is_found():
    runs = judged(*drawn(3))
    found, rms = by_rms(runs, runs)
    assert (rms.mean, rms.interval, found.better(rms), found.more_successful) == (0.0, (0.0, 0.0), '', '')
    assert all('no significant difference' in line for line in texts(one=runs, other=runs)[1:])
    found, rms = by_rms(judged(0.5, 0.25, 1.0), judged(0.25, 0.0, 0.75))
    assert (rms.interval, found.better(rms)) == ((0.25, 0.25), 'other')


def test_an_interrupt_or_a_single_controller_leaves_what_can_be_compared():
    assert compare(NAMES, (judged(*drawn(1)), judged(*drawn(1)[:7]))).runs == 7
    assert best_of({'long': judged(0.2, 0.2, 0.2), 'short': judged(0.1, 0.1)}) == 'short'
    assert best_of({'one': judged(None, None), 'other': judged(None, None)}) == 'one'
    assert (texts(one=judged(0.1, 0.2)), comparison_values({'one': judged(0.1, 0.2)})) == ([], [])
