"""The sentence that opens a report is right whatever became of a run; the numbers of charts keep every peak."""

import base64
import math

import numpy as np
import pytest
from helpers.measuring import configuration

from mobile_robot_control.figures.figure import Line
from mobile_robot_control.loop.indices import MEASURED, TRUE
from mobile_robot_control.pages.page_parts import chart_data, deviation, key_numbers, sentence
from mobile_robot_control.report.report_writing import step_note
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES, PanelOf, difference, over_time, torque_limit
from mobile_robot_control.runs.samples import Messages, collect
from mobile_robot_control.runs.series import Series

LIMIT = {'plant': {'max_wheel_torque': 3.0}, 'velocity_controller': {'max_wheel_torque': 2.0}}
PARAMETERS = configuration(plant={'duration': 1.0})
WHOLE = {
    'outcome': 'completed', 'duration': 16.0, 'error': TRUE, 'rms_position_error': 0.009667,
    'measured_rms_position_error': 0.009667, 'max_position_error': 0.0285, 'rms_heading_error': 0.02,
    'peak_wheel_torque': {'right': 0.86, 'left': 1.28}, 'energy': 52.0,
}
LINEARIZED = configuration(plant={'duration': 16.0}, reference_cart={'curve': 'lemniscate'},
                      position_controller={'controller_type': 'dynamic_feedback_linearization'})
BASE = configuration(plant={'duration': 16.0, 'drive': 'velocity'})


def _series(stamps=range(0, 100, 10), received=True, origin=0):
    """Odometry and reference at stamps [ms]."""
    messages = Messages()
    for stamp in stamps:
        for topic in ('odom', 'reference'):
            messages.add(topic, origin + stamp * 10**6, (0.0,) * 5, 5 if received else None)
    return Series(messages.last_run().signals)


def _run(name='run', parameters=LINEARIZED, problems=(), series=None, **changes):
    return Run(name, series or _series(), problems, WHOLE | changes, parameters)


def _sentence(*runs):
    return sentence(runs).replace('\xa0', ' ')


BEGIN = 'On the lemniscate, dynamic feedback linearization '
ERRORS = 'RMS error 9.67 mm, largest 28.5 mm'
END = f': {ERRORS}, peak torque 1.28 N m; no message was lost.'


def test_a_whole_run_is_told_by_law_curve_errors_torque_and_messages():
    assert _sentence(_run()) == f'{BEGIN}completed 16 s{END}'
    assert _sentence(_run(series=_series(origin=10**18))) == f'{BEGIN}completed 16 s on the wall clock{END}'
    assert len(_sentence(_run('x' * 3000), _run('y' * 3000))) < 400


@pytest.mark.parametrize(('changes', 'words'), [
    *(({'outcome': outcome, 'duration': 3.2}, f'{BEGIN}{words}{END}') for outcome, words in (
        ('diverged', 'diverged after 3.2 s of 16 s'),
        ('law_failed', 'was stopped after 3.2 s of 16 s, when its law failed'),
        ('node_died', 'was broken off after 3.2 s of 16 s, when a node gave no answer'),
        ('broken off', 'was recorded for 3.2 s of 16 s only'), ('not known', 'drove for 3.2 s'),
        ('odd {} \u2028', r'ended after 3.2 s of 16 s (odd {} \u2028)'))),
    *((changes, f'{BEGIN}completed 16 s: {words}, peak torque 1.28 N m; no message was lost.') for changes, words in (
        ({'error': MEASURED}, 'RMS error 9.67 mm and largest 28.5 mm as odometry saw it'),
        ({'measured_rms_position_error': 0.005},
         'true RMS error 9.67 mm (5 mm as odometry saw it), largest 28.5 mm'),
        ({'measured_rms_position_error': None}, ERRORS),
        ({'rms_position_error': None, 'max_position_error': None}, 'its error is not known'),
        ({'max_position_error': None}, 'RMS error 9.67 mm, largest –'))),
    *(({'parameters': parameters, 'peak_wheel_torque': peaks}, f', {words}; ') for parameters, peaks, words in (
        (LINEARIZED, None, 'torque not known'), (LINEARIZED, {'right': None, 'left': None}, 'torque not known'),
        (LINEARIZED, {'right': None, 'left': 0.05}, 'peak torque 50 mN m'), (None, None, 'torque not known'),
        (BASE, None, 'no torque, as its base takes velocities'))),
    ({'problems': ('gaps',), 'series': _series([0, 10, 20, 50, 60, 70])},
     '; 4 messages are missing from the recording.'),
    ({'problems': ('cut off',)}, '; its recording is not complete, see what is missing below.'),
    ({'series': _series(range(0, 60, 10), received=False)}, '; its table is complete.'),
])
def test_outcome_true_or_measured_error_torque_and_what_is_missing_are_told(changes, words):
    assert words in _sentence(_run(**changes))


def test_a_run_without_metrics_has_no_error():
    run = Run('run', Series({}), ('no metrics',), {'outcome': 'diverged'}, None)
    assert _sentence(run) == (
        'The robot was not measured (outcome diverged): its error is not known, torque not known; its recording is not '
        'complete, see what is missing below.')
    assert [number.text for number in key_numbers([run])[0]] == ['0', '–', '–', '–', '–']


def test_the_best_of_several_runs_is_told_with_what_became_of_the_others():
    best, worse = _run('a'), _run('b', rms_position_error=0.02, problems=('gaps',))
    failed = _run('c', outcome='diverged', duration=3.0, rms_position_error=0.001)
    assert _sentence(worse, best, failed) == (
        f'Of 3 runs, a has the smallest error: {ERRORS}, peak torque 1.28 N m; next is b with 20 mm; c diverged after '
        '3 s of 16 s; the recording of b is not complete, see what is missing below.')
    assert _sentence(best, failed).startswith(f'Of 2 runs, a alone is whole, and as long as the longest: {ERRORS}')
    assert _sentence(failed, failed).startswith('None of 2 runs can be compared with another; c diverged')
    assert _sentence(_run('a'), _run('b', error=MEASURED)).startswith(
        '2 runs are not ranked, as the errors of some are true and those of others measured; no message is missing')


def test_five_numbers_have_readable_units():
    found = key_numbers([_run()])[0]
    assert [(number.label, number.text.replace('\xa0', ' ')) for number in found] == [
        ('RMS error', '9.67 mm'), ('largest error', '28.5 mm'), ('RMS heading error', '1.15°'),
        ('peak torque', '1.28 N m'), ('energy', '52 J')]
    # of several runs the same
    found = key_numbers([_run(max_position_error=0.0285), _run(max_position_error=0.102)])
    assert [row[1].text.replace('\xa0', ' ') for row in found] == ['28.5 mm', '102 mm']


def test_numbers_that_no_run_has_make_room_for_others_and_all_runs_have_the_same():
    of_base = {'peak_wheel_torque': None, 'energy': None}
    labels = [number.label for number in key_numbers([_run(**of_base)])[0]]
    assert labels == ['RMS error', 'largest error', 'RMS heading error', 'duration', 'messages missing']
    first, second = key_numbers([_run(), _run(**of_base)])
    assert [number.label for number in first] == [number.label for number in second]
    assert second[3].text == '–'


@pytest.fixture(scope='module')
def series():
    return collect(rollout(PARAMETERS, 1.0))


def numbers(packed):
    return np.frombuffer(base64.b64decode(packed), '<f4')


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


def test_a_difference_of_runs_is_interpolated_and_ends_with_the_shorter_one():
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
