"""The table of metrics: readable units with the exact value beside them, the best one, differences to the first run."""

import math
import re

import pytest

from mobile_robot_control.pages.metrics_table import metrics_table
from mobile_robot_control.pages.page import html_table
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.series import Series
from mobile_robot_control.runs.words import described_change, quantity, readable_unit


def table(*metrics):
    runs = [Run(f'run_{n}', Series({}), (), {'outcome': 'completed', 'duration': 1.0} | found,
                        None) for n, found in enumerate(metrics)]
    return {row[0]: row[1:] for row in (re.findall(r'<t[dh][^>]*>(.*?)</t[dh]>', line)
                                        for line in re.findall(r'<tr>(.*?)</tr>', metrics_table(runs)))}


def text(cell):
    return re.sub(r'<[^>]*>', ' ', cell).split()


@pytest.mark.parametrize('case', [
    (0.009667, 'm', '9.67 mm'), (1.4674588, 'm', '1.47 m'), (0.2042654, 'rad', '11.7°'), (0.0, 'm', '0 m'),
    (0.05, 'N m', '50 mN m'), (12345.6, 'W', '12300 W'), (63.9501, 'J', '64 J'), (-0.25, 'm', '-0.25 m'),
    (0.00004, 'm', '40 µm'), (9.7688, '', '9.77'), (5512.3, 'N m', '5510 N m'), (16.0, 's', '16 s'),
])
def test_a_quantity_is_shown_in_a_readable_unit_with_its_exact_value(case):
    value, unit, shown = case
    found = quantity(value, unit)
    assert ' '.join(text(found)) == shown
    assert f'title="{value!r}{" " if unit else ""}{unit}"' in found
    assert f'value="{value!r}"' in found


@pytest.mark.parametrize('values', [[None], [], [math.inf], [0.0]])
def test_a_unit_of_nothing_is_the_si_unit(values):
    assert readable_unit(values, 'm').name == 'm'


def test_the_best_is_marked_and_others_have_their_difference_to_the_first():
    for metrics, expected in (
            (({'energy': 12.0}, {'energy': 9.0}, {'energy': 13.5}, {'energy': None}),
             ['12 J', '★ 9 J −3 J, −25 %', '13.5 J +1.5 J, +12.5 %', '–']),
            (({'energy': 12.0}, {'energy': 9.0, 'outcome': 'diverged'}, {'energy': 6.0}),
             ['12 J', '9 J', '★ 6 J −6 J, −50 %']),
            (({'energy': 12.0, 'outcome': 'diverged'}, {'energy': 9.0}, {'energy': 6.0}), ['12 J', '9 J', '★ 6 J'])):
        assert [' '.join(text(cell)) for cell in table(*metrics)['energy']] == expected
    # none is the best of equal ones
    assert not any('★' in cell for cell in table({'energy': 12.0}, {'energy': 12.0})['energy'])


def test_true_and_measured_errors_are_not_compared():
    row = table({'max_position_error': 1.0, 'error': 'true'}, {'max_position_error': 0.5, 'error': 'measured'})
    assert [' '.join(text(cell)) for cell in row['position error, largest']] == ['1 m', '0.5 m']
    assert [' '.join(text(cell)) for cell in row['errors are those of']] == ['the true pose', 'odometry']


def test_a_row_has_one_unit():
    for largest, shown in ((2.0, [['★', '12.3', 'mm'], ['2000', 'mm', '+1.99']]),
                           (20.0, [['★', '0.0123', 'm'], ['20', 'm', '+20']])):
        row = table({'rms_position_error': 0.0123}, {'rms_position_error': largest})['position error, RMS']
        assert [text(cell)[:3] for cell in row] == shown


def test_the_best_has_the_largest_share_of_the_time_or_the_smallest_error():
    rows = table({'share_within_band': 0.9, 'iae': 0.5, 'settling_time': None},
                 {'share_within_band': 0.4, 'iae': 0.2, 'settling_time': 0.7})
    # the larger share of the time is the better one, and what never settles has no time to compare
    assert ['★' in cell for cell in rows['share of time within 0.02 m']] == [True, False]
    assert ['★' in cell for cell in rows['position error, ∫ d dt (IAE)']] == [False, True]
    assert [' '.join(text(cell)) for cell in rows['settling time, to 0.02 m']] == ['–', '0.7 s']
    assert 'cross-track error, RMS' not in rows


def test_poses_and_the_ratio_of_peak_torques_have_their_rows():
    rows = table({'final_pose': (1.0, 2.0, 0.5), 'peak_wheel_torque': {'right': 1.0, 'left': 0.5}},
                 {'final_pose': (1.0, 2.0, 0.5), 'peak_wheel_torque': {'right': 0.25, 'left': 2.5}})
    assert [text(cell)[-2:] for cell in rows['final y']] == [['2', 'm']] * 2
    assert 'value="0.5"' in rows['final heading'][0]
    assert [' '.join(text(cell)) for cell in rows['peak torque against the least']] == ['1 times', '2.5 times']


@pytest.mark.parametrize('case', [
    (2.0, 1.0, '+1 J, +100 %'), (1.0, 1.0, '±0 J'), (1.0, 0.0, '+1 J'), (-1.0, -2.0, '+1 J, +50 %'),
])
def test_a_change_has_its_sign(case):
    value, base, shown = case
    assert described_change(value, base, 'J').replace('\xa0', ' ') == shown


def test_names_break_behind_underscores():
    assert '>hybrid_<wbr>backstepping<' in html_table(['', 'hybrid_backstepping'], [])
