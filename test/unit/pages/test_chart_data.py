"""The numbers of the charts: every peak stays, few points, the same bytes each time, and texts that cannot escape."""

import base64
import math

import numpy as np
import pytest
from measuring import configuration

from mobile_robot_control.figures.lines import Line
from mobile_robot_control.pages.chart_data import chart_data, deviation
from mobile_robot_control.pages.report_writing import step_note
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES, PanelOf, difference, over_time, torque_limit
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.simulation.rollout import rollout

LIMIT = {'plant': {'max_wheel_torque': 3.0}, 'velocity_controller': {'max_wheel_torque': 2.0}}


def run(name='run', duration=0.5, **nodes):
    parameters = configuration(**nodes)
    return Run(name, collect(rollout(parameters, duration)), (), {}, parameters)


@pytest.fixture(scope='module')
def pair():
    return [run('first', **LIMIT), run('second', position_controller={'controller_type': 'fuzzy'})]


def charted(runs):
    return chart_data([figure for kind in RUN_FIGURES if (figure := kind.of_runs(runs))], runs)


def unpacked(data, line):
    return Line(*(np.frombuffer(base64.b64decode(data['columns'][line[part]]), '<f4') for part in ('time', 'value')))


def drawn(line):
    """The only line of a chart, as its numbers."""
    runs = [run(duration=0.1)]
    data = chart_data([over_time([PanelOf('x', 'm', lambda _: line)], runs)], runs)
    return unpacked(data, data['charts'][0]['lines'][0])


def test_a_long_line_keeps_every_peak_in_few_points():
    value = np.sin(np.arange(1_100_000) / 900.0)
    value[[7, 500_001, 1_099_998]] = [4.0, -7.0, 5.0]
    line = drawn(Line(np.arange(value.size) / 500.0, value))
    assert line.time.size <= 4002
    assert {4.0, -7.0, 5.0} <= set(line.value.tolist())
    assert line.time[np.argmin(line.value)] == pytest.approx(500_001 / 500.0)
    assert (np.diff(line.time) > 0.0).all()


def test_a_short_line_is_complete_and_its_gaps_have_times_of_their_own():
    # an angle that jumps has a gap at the very time of the next value
    line = drawn(Line(np.array([0.0, 1.0, 1.0, 2.0]), np.array([3.0, math.nan, -3.0, -2.0])))
    assert line.time.tolist() == [0.0, 0.5, 1.0, 2.0]
    assert line.value[[0, 2, 3]].tolist() == [3.0, -3.0, -2.0]
    assert math.isnan(line.value[1])
    # what no chart can hold is a gap
    line = drawn(Line(np.arange(3.0), np.array([1e300, 1.0, -math.inf])))
    assert np.isnan(line.value).tolist() == [True, False, True]


def test_six_runs_are_told_apart_and_each_column_stands_once(pair):
    data = charted([*pair, *pair, *pair])
    for look in ('light', 'dark', 'dash', 'width'):
        assert len({str(one[look]) for one in data['runs']}) == 6
    assert len(set(data['columns'])) == len(data['columns'])


def test_differences_are_to_the_first_run_at_the_same_time(pair):
    data = charted(pair)
    chart = next(chart for chart in data['charts'] if chart['figure'] == 'distance')
    lines = {(line['kind'], line['run']): unpacked(data, line) for line in chart['lines']}
    expected = lines['value', 1].value - lines['value', 0].value
    assert np.abs(expected).max() > 0.0
    assert lines['difference', 1].value == pytest.approx(expected, abs=1e-6)


def test_a_difference_of_runs_of_other_times_is_interpolated_and_ends_with_the_shorter_one():
    first = Line(np.array([0.0, 2.0, 4.0]), np.array([0.0, 2.0, 4.0]))
    found = difference(Line(np.array([1.0, 3.0, 5.0]), np.array([1.5, 3.5, 5.5])), first)
    assert found.value[:2].tolist() == [0.5, 0.5]
    assert math.isnan(found.value[2])
    assert not difference(first, Line(np.zeros(0), np.zeros(0))).time.size


def test_torque_charts_have_the_smallest_limit_of_each_run(pair):
    data = charted(pair)
    limits = {chart['figure']: chart['limits'] for chart in data['charts']}
    assert limits.pop('torque') == [{'run': 0, 'value': 2.0}]
    assert not any(limits.values())
    assert torque_limit(pair[0]._replace(parameters=None)) is None


def test_the_deviation_is_that_of_the_robot_from_the_cart(pair):
    series = pair[0].series
    found = deviation(series)
    x, y = (series.line('odom', axis).value for axis in 'xy')
    assert found['x'] + found['x_error'] == pytest.approx(x)
    assert found['y'] + found['y_error'] == pytest.approx(y)
    distance = np.hypot(series.error('longitudinal').value, series.error('lateral').value)
    assert np.hypot(found['x_error'], found['y_error']) == pytest.approx(distance)


def test_torques_of_a_faster_loop_have_their_steps_explained(pair):
    assert '500 times a second' in step_note(pair)
    slow = run('slow', 0.1, velocity_rate=100.0, position_rate=100.0)
    assert step_note([slow]) == ''
    assert step_note([*pair, slow]).startswith('The velocity loop')
    fast = run('fast', 0.1, velocity_rate=1000.0, position_rate=100.0)
    assert step_note([*pair, fast]).startswith('first, second: The velocity loop')
