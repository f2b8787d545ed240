"""Bytes from anywhere, on any topic, change nothing but a counter."""

import math

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message

from mobile_robot_control.dashboard.graph import NodeStates
from mobile_robot_control.dashboard.sampling import COLUMNS, Sampler, message_text
from mobile_robot_control.messages import writing
from mobile_robot_control.messages.topic_forms import writer
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque
from mobile_robot_control.topics import LOOP_TOPICS

BYTES = st.one_of(st.binary(max_size=300), st.binary(max_size=300).map(lambda rest: b'\0\1\0\0' + rest))


def _odometry(stamp, x=1.0):
    return writing.odometry_writer('odom', 'base_link')(stamp, Pose(x, 2.0, 0.5), BodyVelocity(0.1, 0.2))


def _error(stamp, e1):
    return writer('tracking_error')(stamp, (e1, 0.0, 0.0))


def _torques(stamp, right):
    return writing.torque_writer()(stamp, WheelTorque(right, 0.0))


def _taken(sampler, **messages):
    """Have a sampler take messages by topic, a list each, and fill its row."""
    for topic, some in messages.items():
        sampler.take(topic, LOOP_TOPICS[topic].kind, some)
    sampler.fill()
    return sampler


def _columns(sampler, *names):
    return [sampler.row(math.nan)[COLUMNS.index(name)] for name in names]


@given(st.sampled_from(sorted(LOOP_TOPICS)), BYTES)
def test_any_bytes_leave_the_row_and_are_counted(topic, message):
    sampler = _taken(Sampler(), odom=[_odometry(0)])
    _taken(sampler, **{topic: [message]})
    assert all(math.isnan(number) or math.isfinite(number) for number in sampler.row(math.nan))
    assert sampler.refused.total() <= 1
    assert message_text(LOOP_TOPICS[topic].kind, message)


@given(BYTES)
def test_any_bytes_are_no_state(message):
    states = NodeStates()
    states.take(message)
    assert states.of(['/plant'])[0]['text'] == 'no report yet'


def test_refusals_and_unchanged_plans_of_a_report_are_counts():
    values = {'refused': '3', 'refused path: stale': '3', 'plans unchanged': '12', 'plans taken': '7', 'refused x': '²'}
    states = NodeStates()
    states.take(serialize_message(DiagnosticArray(status=[DiagnosticStatus(
        name='plant', values=[KeyValue(key=key, value=value) for key, value in values.items()])])))
    [state] = states.of(['/plant'])
    assert (state['refused'], state['reasons'], state['unchanged']) == (3, {'path: stale': 3, 'x': 0}, 12)


def test_a_message_that_is_too_short_is_counted_by_topic_and_reason():
    assert _taken(Sampler(), odom=[b'\0\1\0\0']).refused == {'odom: not readable': 1}


def test_a_reset_begins_one_new_run_whether_stamps_fall_or_not():
    sampler = _taken(Sampler(), odom=[_odometry(10_000_000)])
    sampler.note_reset()
    # the row is of the old run until the new one has come, which is farther by now than the old one ever was
    assert _columns(sampler, 'run', 'time') == [1.0, 0.01]
    _taken(sampler, odom=[_odometry(500_000_000)])
    assert _columns(sampler, 'run', 'time') == [2.0, 0.5]
    for told_first in (True, False):
        if told_first:
            sampler.note_reset()
        _taken(sampler, odom=[_odometry(0)])
        if not told_first:
            sampler.note_reset()
        _taken(sampler, odom=[_odometry(500_000_000)])
    assert _columns(sampler, 'run') == [4.0]


def test_a_reset_right_after_a_restart_of_the_plant_can_be_told_from_it():
    sampler = _taken(Sampler(), odom=[_odometry(10_000_000)])
    _taken(sampler, odom=[_odometry(0)])
    counted = sampler.run, sampler.matched
    # of the run that the restart began, no more was seen
    sampler.note_reset()
    _taken(sampler, odom=[_odometry(0)])
    assert counted == (2, 0)
    assert (sampler.run, sampler.matched) == (2, 1)
    sampler.count_run()
    assert _columns(sampler, 'run', 'time') == [3.0, 0.0]


def test_a_stamp_that_falls_begins_a_new_run_whose_row_has_nothing_of_the_run_before():
    late = 5_000_000_000
    sampler = _taken(Sampler(), odom=[_odometry(late)], tracking_error=[_error(late, 0.4)],
                     wheel_torques=[_torques(late, 0.398)])
    assert _columns(sampler, 'run', 'time', 'right_asked') == [1.0, 5.0, 0.398]
    # the page looks when the new run has its first odometry alone
    _taken(sampler, odom=[_odometry(0, x=3.0)])
    assert _columns(sampler, 'run', 'time', 'x') == [2.0, 0.0, 3.0]
    assert all(map(math.isnan, _columns(sampler, 'e1', 'right_asked')))
    _taken(sampler, tracking_error=[_error(0, 0.0)], wheel_torques=[_torques(0, 0.079)])
    assert _columns(sampler, 'run', 'time', 'e1', 'right_asked') == [2.0, 0.0, 0.0, 0.079]


def test_a_row_belongs_to_the_newest_stamp_that_all_topics_have():
    names = 'time', 'x', 'e1', 'right_asked'
    sampler = _taken(Sampler(), odom=[_odometry(0, x=1.0), _odometry(10_000_000, x=2.0)],
                     tracking_error=[_error(0, 0.1)], wheel_torques=[_torques(k * 2_000_000, k / 10) for k in range(8)])
    assert _columns(sampler, *names) == [0.0, 1.0, 0.1, 0.0]
    _taken(sampler, tracking_error=[_error(10_000_000, 0.2)])
    assert _columns(sampler, *names) == [0.01, 2.0, 0.2, 0.5]
    # a run that is faster than the page looks leaves the fast loop out rather than mix stamps
    _taken(sampler, odom=[_odometry(90_000_000)], tracking_error=[_error(90_000_000, 0.3)],
           wheel_torques=[_torques(96_000_000, 0.9)])
    assert _columns(sampler, 'time', 'e1') == [0.09, 0.3]
    assert math.isnan(*_columns(sampler, 'right_asked'))


def test_nodes_with_clocks_of_their_own_fill_a_row_with_their_newest_messages():
    begun = 1_700_000_000_000_000_000
    sampler = _taken(Sampler(), odom=[_odometry(begun)])
    _taken(sampler, odom=[_odometry(begun + 250_000_000)], tracking_error=[_error(begun + 240_000_000, 0.1)])
    assert _columns(sampler, 'time', 'e1') == [0.25, 0.1]
