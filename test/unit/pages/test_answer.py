"""The sentence that opens a report is right whatever became of a run, and whatever is not known of it."""

import pytest
from helpers.measuring import configuration

from mobile_robot_control.loop.indices import MEASURED, TRUE
from mobile_robot_control.pages.page_parts import key_numbers, sentence
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import Messages
from mobile_robot_control.runs.series import Series

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
        ('law_failed', 'was stopped after 3.2 s of 16 s, when its position law failed'),
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
