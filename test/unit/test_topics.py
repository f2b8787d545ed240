"""The table of the loop's topics, and what follows from it."""

from each import each_row

from mobile_robot_control.configuration.nodes import NODES
from mobile_robot_control.topics import (
    LOOP_TOPICS,
    LOOPS,
    POSITION_TOPICS,
    first_silent,
    silent_node,
)

TORQUE, VELOCITY = LOOPS['torque'], LOOPS['velocity']
TICK = 10


def test_every_topic_has_one_rate_and_belongs_to_nodes_that_exist():
    assert {*TORQUE.velocity_topics, *POSITION_TOPICS} == set(LOOP_TOPICS)
    assert not {*TORQUE.velocity_topics} & {*POSITION_TOPICS}
    for topic in LOOP_TOPICS.values():
        assert {topic.publisher, *topic.subscribers} <= set(NODES)
        assert topic.publisher not in topic.subscribers


@each_row(('node', 'inputs'), [
    ('plant', {'wheel_torques': 'velocity_controller'}),
    ('velocity_controller', {'joint_states': 'plant', 'cmd_vel': 'position_controller'}),
    ('position_controller', {'odom': 'plant', 'reference': 'reference_cart'}),
    ('reference_cart', {'odom': 'plant'}),
])
def test_inputs_of_a_node_name_their_publishers(node, inputs):
    assert TORQUE.inputs_of(node) == inputs


def test_a_base_takes_cmd_vel_itself_and_no_node_needs_its_joint_states():
    assert VELOCITY.inputs_of('plant') == {'cmd_vel': 'position_controller'}
    assert VELOCITY.topics_of('plant') == ['joint_states', 'odom', 'cmd_vel']
    assert 'velocity_controller' not in VELOCITY.nodes
    assert VELOCITY.velocity_topics == ('joint_states',)
    assert [loop.command for loop in (TORQUE, VELOCITY)] == ['wheel_torques', 'cmd_vel']
    for node in ('position_controller', 'reference_cart'):
        assert VELOCITY.inputs_of(node) == TORQUE.inputs_of(node)


@each_row(('newest', 'node'), [
    ({}, 'reference_cart'),
    ({'reference': 10}, 'position_controller'),
    ({'reference': 0, 'cmd_vel': 10, 'wheel_torques': 12}, 'reference_cart'),
    ({'reference': 10, 'cmd_vel': 10}, 'velocity_controller'),
    ({'reference': 10, 'cmd_vel': 10, 'wheel_torques': 10}, 'velocity_controller'),
    ({'reference': 10, 'cmd_vel': 10, 'wheel_torques': 12}, None),
])
def test_the_first_node_without_an_answer_is_the_silent_one(newest, node):
    assert first_silent(newest, stamp=12, tick=10, loop=TORQUE) == node


@each_row(('newest', 'node'), [
    ({}, 'reference_cart'), ({'reference': 10}, 'position_controller'), ({'reference': 10, 'cmd_vel': 10}, None),
])
def test_a_base_waits_for_no_answer_between_position_ticks(newest, node):
    assert first_silent(newest, stamp=12, tick=10, loop=VELOCITY) == node
    assert silent_node(newest | {'joint_states': 12, 'odom': 10}, True, TICK, VELOCITY) == (node or 'plant')


def test_a_question_comes_before_its_answer_and_at_the_same_rate():
    for question, answer in TORQUE.answers + VELOCITY.answers:
        assert LOOP_TOPICS[question].rate == LOOP_TOPICS[answer].rate
        assert LOOP_TOPICS[question].publisher == 'plant'


ALL = {'joint_states': 20, 'odom': 20, 'reference': 20, 'cmd_vel': 20, 'wheel_torques': 20}


@each_row(('newest', 'lockstep', 'silent'), [
    ({}, True, 'plant'),
    (ALL, True, 'plant'),
    (ALL | {'reference': 10}, True, 'reference_cart'),
    (ALL | {'cmd_vel': 10}, True, 'position_controller'),
    (ALL | {'wheel_torques': 18}, True, 'velocity_controller'),
    (ALL | {'odom': 10, 'reference': 10}, True, 'plant'),
    (ALL | {'tracking_error': 20, 'reference': 5}, False, 'reference_cart'),
])
def test_the_node_that_owes_an_answer_is_named(newest, lockstep, silent):
    assert silent_node(newest, lockstep, TICK, TORQUE) == silent
