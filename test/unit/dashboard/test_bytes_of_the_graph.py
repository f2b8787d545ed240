"""Bytes from anywhere, on any topic, change nothing but a counter."""

import math

from hypothesis import given
from hypothesis import strategies as st

from mobile_robot_control.dashboard.node_states import NodeStates
from mobile_robot_control.dashboard.sampling import COLUMNS, Sampler, message_text
from mobile_robot_control.messages import writing
from mobile_robot_control.quantities import BodyVelocity, Pose
from mobile_robot_control.topics import LOOP_TOPICS

BYTES = st.one_of(st.binary(max_size=300), st.binary(max_size=300).map(lambda rest: b'\0\1\0\0' + rest))


def _odometry(stamp, x=1.0):
    return writing.odometry_writer('odom', 'base_link')(stamp, Pose(x, 2.0, 0.5), BodyVelocity(0.1, 0.2))


def _column(sampler, name):
    return sampler.row(math.nan)[COLUMNS.index(name)]


@given(st.sampled_from(sorted(LOOP_TOPICS)), BYTES)
def test_any_bytes_leave_the_row_and_are_counted(topic, message):
    sampler = Sampler()
    sampler.take('odom', LOOP_TOPICS['odom'].kind, _odometry(0))
    sampler.take(topic, LOOP_TOPICS[topic].kind, message)
    assert all(math.isnan(number) or math.isfinite(number) for number in sampler.row(math.nan))
    assert sampler.refused.total() <= 1
    assert message_text(LOOP_TOPICS[topic].kind, message)


@given(BYTES)
def test_any_bytes_are_no_state(message):
    states = NodeStates()
    states.take(message)
    assert states.of(['/plant'])[0]['text'] == 'no report yet'


def test_a_message_that_is_too_short_is_counted_by_topic_and_reason():
    sampler = Sampler()
    sampler.take('odom', LOOP_TOPICS['odom'].kind, b'\0\1\0\0')
    assert sampler.refused == {'odom: not readable': 1}


def test_a_stamp_that_falls_begins_a_new_run():
    sampler = Sampler()
    sampler.take('odom', LOOP_TOPICS['odom'].kind, _odometry(5_000_000_000))
    assert (_column(sampler, 'run'), _column(sampler, 'time')) == (1.0, 5.0)
    sampler.take('odom', LOOP_TOPICS['odom'].kind, _odometry(0, x=3.0))
    assert (_column(sampler, 'run'), _column(sampler, 'time'), _column(sampler, 'x')) == (2.0, 0.0, 3.0)


def test_on_the_wall_clock_time_is_counted_from_the_first_odometry():
    sampler = Sampler()
    begun = 1_700_000_000_000_000_000
    sampler.take('odom', LOOP_TOPICS['odom'].kind, _odometry(begun))
    sampler.take('odom', LOOP_TOPICS['odom'].kind, _odometry(begun + 250_000_000))
    assert _column(sampler, 'time') == 0.25
