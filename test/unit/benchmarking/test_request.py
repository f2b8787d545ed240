"""The cells of a benchmark, and the laws that are published with their errors."""


import pytest
from helpers.small_benchmark import read, run

import mobile_robot_control as mrc
from mobile_robot_control.benchmarking.request import Benchmark, BenchmarkRequest, published_rows
from mobile_robot_control.settings.configure import (
    ParameterSources,
)
from mobile_robot_control.settings.tracks import read_track

UNCHANGED = ParameterSources()


def test_the_published_laws_have_the_published_errors():
    rows = {row['law']: row for row in published_rows(read_track('published'), UNCHANGED)}
    for law in ('ramsete', 'periodic'):
        assert rows[law]['ours'] == pytest.approx(rows[law]['published'], rel=5e-5)
    # its listing begins otherwise: docs/base.md
    row = rows['dynamic_feedback_linearization']
    assert row['ours']['rms_position_error'] == pytest.approx(row['published']['rms_position_error'], rel=0.05)


def test_each_budget_is_searched_and_judged_as_alone(track, tmp_path):
    # after 25, the first of SMALL
    assert run(track, tmp_path / 'both', '--laws', 'ramsete', '--budgets', 25, 50) == 0
    both = {row['budget']: row['values'] for row in read(tmp_path / 'both')[0]['results'] if row['gains'] == 'searched'}
    alone = mrc.benchmark(laws=['ramsete'], tracks=[track], budgets=[50], scenarios=1, runs=4, workers=1)
    assert both[50] == alone.results[0]['values'] != both[25]


def test_pairs_of_position_and_velocity_law_compete_each_with_its_own_gains(track, tmp_path):
    track.write_text(track.read_text().replace('{drive: velocity}', '{max_wheel_torque: 3.0}'))
    command = ('--laws', 'kanayama', '--velocity-laws', 'pi', 'computed_torque')
    assert run(track, tmp_path / 'both', *command) == 0
    values, rows = read(tmp_path / 'both')
    assert values['laws'] == ['kanayama+pi', 'kanayama+computed_torque']
    pi, other = (row for row in values['results'] if row['gains'] == 'searched')
    assert {'velocity_controller.gains.k1', 'velocity_controller.gains.ti2'} <= {*pi['values']}
    groups = {'.'.join(name.split('.')[:2]) for name in other['values']}
    assert groups == {'velocity_controller.computed_torque', 'position_controller.kanayama'}
    assert pi['rms'] != other['rms']
    assert [row['law'] for row in rows].count('kanayama+pi') == 2


def _drawn(track, law):
    """Return 50 scenarios for training and 50 for judging, of three tracks."""
    cells = Benchmark(BenchmarkRequest(ParameterSources(), (law,), (str(track), 'noise', 'delay'))).cells
    return [[cell.drawn(use, cell.configuration(), 50) for use in ('training', 'judging')] for cell in cells]


def test_training_and_judging_have_no_scenario_in_common(track):
    assert not any(set(training) & set(judging) for training, judging in _drawn(track, 'kanayama'))


def test_every_law_has_the_same_scenarios(track):
    assert _drawn(track, 'kanayama') == _drawn(track, 'lqr')


def test_on_the_track_of_delays_every_delay_is_drawn(track):
    assert {one.delay for one in _drawn(track, 'kanayama')[2][1]} == {1, 2}
