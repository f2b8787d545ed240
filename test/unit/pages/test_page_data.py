"""The numbers of charts and of a replay: every peak stays, few points, gaps where nothing is known."""

import base64
import json
import math

import numpy as np
import pytest
from helpers.measuring import configuration

from mobile_robot_control.figures.figure import Line
from mobile_robot_control.figures.palette import LINES
from mobile_robot_control.pages.page_parts import chart_data, deviation
from mobile_robot_control.pages.replay_data import SHAPES, largest_since, replay_data
from mobile_robot_control.report.report_writing import step_note
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES, PanelOf, difference, over_time, torque_limit
from mobile_robot_control.runs.samples import Messages, collect
from mobile_robot_control.runs.series import Series

LIMIT = {'plant': {'max_wheel_torque': 3.0}, 'velocity_controller': {'max_wheel_torque': 2.0}}
PARAMETERS = configuration(plant={'duration': 1.0})


@pytest.fixture(scope='module')
def series():
    return collect(rollout(PARAMETERS, 1.0))


def numbers(packed):
    return np.frombuffer(base64.b64decode(packed), '<f4')


def long_run(count):
    """A run of so many messages with one peak each of torque and error, and one point far out."""
    messages = Messages()
    for n in range(count):
        peak = n == count // 3 + 1
        messages.add('odom', n * 10**7, (9.0 if n == count // 2 + 1 else 0.0, 0.0, 0.0, 0.0, 0.0))
        messages.add('tracking_error', n * 10**7, (5.0 if peak else 0.1, 0.0, 0.0))
        messages.add('joint_states', n * 10**7, (0.1 * n, 0.1 * n, 1.0, 1.0, -7.0 if peak else 0.2, 0.1))
    return Run('long', Series(messages.last_run().signals), (), {}, None)


def run(name='run', duration=0.5, **nodes):
    parameters = configuration(**nodes)
    return Run(name, collect(rollout(parameters, duration)), (), {}, parameters)


@pytest.fixture(scope='module')
def pair():
    return [run('first', **LIMIT), run('second', position_controller={'controller_type': 'fuzzy'})]


def charted(runs):
    return chart_data([figure for kind in RUN_FIGURES if (figure := kind.of_runs(runs))], runs)


def unpacked(data, line):
    return Line(*(numbers(data['columns'][line[part]]) for part in ('time', 'value')))


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


def test_six_runs_are_told_apart_each_column_stands_once_and_differences_are_to_the_first(pair):
    data = charted([*pair, *pair, *pair])
    for look in ('light', 'dark', 'dash', 'width'):
        assert len({str(one[look]) for one in data['runs']}) == 6
    assert len(set(data['columns'])) == len(data['columns'])
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


def test_a_short_run_keeps_every_pose_and_its_numbers(series):
    run = Run('run', series, (), {}, PARAMETERS)
    data = replay_data([run])
    assert (data['start'], data['end'], data['trail']) == (0.0, 1.0, 16.0)
    assert numbers(data['runs'][0]['columns']['time']).size == 101
    np.testing.assert_allclose(numbers(data['runs'][0]['columns']['x']), series.line('odom', 'x').value, rtol=1e-6)
    robot = PARAMETERS.plant.shared.robot
    assert data['runs'][0]['wheelSeparation'] == robot.wheel_separation
    peaks = [np.abs(series.torque(wheel).value).max() for wheel in ('right', 'left')]
    assert data['runs'][0]['limit'] == pytest.approx(max(peaks))


def test_a_long_run_is_thinned_and_keeps_its_extremes():
    data = replay_data([long_run(40_000)])
    assert numbers(data['runs'][0]['columns']['time']).size < 12_010
    assert numbers(data['runs'][0]['columns']['error']).max() == 5.0
    assert numbers(data['runs'][0]['columns']['rightTorque']).min() == -7.0
    assert numbers(data['runs'][0]['columns']['x']).max() == 9.0
    assert len(json.dumps(data)) < 1_000_000
    assert len(set(SHAPES)) == len(LINES)
    # six share the room of two
    assert len(json.dumps(replay_data([long_run(15_000)] * 6))) < 2_000_000


def test_the_largest_value_since_the_time_before_stays_and_silence_is_not_filled():
    line = Line(np.array([0.0, 0.1, 0.2, 0.3, 0.4]), np.array([1.0, -9.0, 2.0, np.nan, 3.0]))
    found = largest_since(line, np.array([-1.0, 0.0, 0.25, 0.45, 0.5, 2.0]))
    np.testing.assert_array_equal(found, [np.nan, 1.0, -9.0, 3.0, 3.0, np.nan])


def test_what_no_run_has_is_left_out(series):
    signals = series.signals
    alone = Series({'odom': signals['odom']})
    data = replay_data([Run('run', alone, (), {}, None)])
    assert set(data['runs'][0]['columns']) == {'time', 'x', 'y', 'heading'}
    assert data['runs'][0]['wheelSeparation'] is None
    assert data['errorScale'] == 0.0
    nothing = Run('run', Series({}), (), {}, None)
    assert replay_data([nothing]) is None
    assert replay_data([nothing, Run('run', alone, (), {}, None)])['end'] == 1.0


def test_a_number_that_no_float_of_a_page_can_hold_is_not_known():
    messages = Messages()
    for n, x in enumerate([0.0, 1.0, 1e300, float('nan')]):
        messages.add('odom', n * 10**7, (x, 0.0, 0.0, 0.0, 0.0))
    data = replay_data([Run('run', Series(messages.last_run().signals), (), {}, None)])
    np.testing.assert_array_equal(numbers(data['runs'][0]['columns']['x']), [0.0, 1.0, np.nan, np.nan])


def test_the_path_is_a_whole_lap_where_the_cart_followed_the_curve_and_its_trace_elsewhere(series):
    def path(parameters):
        return numbers(replay_data([Run('run', series, (), {}, parameters)])['path']['x'])

    recorded = series.line('reference', 'x').value
    assert np.nanmin(path(PARAMETERS)) < -0.4 < recorded.min()
    other = configuration(reference_cart={'curve': 'circle'})
    np.testing.assert_allclose(path(other)[:-1], recorded, rtol=1e-6)
    np.testing.assert_allclose(path(None)[:-1], recorded, rtol=1e-6)
