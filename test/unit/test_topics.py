"""The table of the loop's topics, and what follows from it."""


import pytest

from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.topics import LOOP_TOPICS, LOOPS, POSITION_TOPICS, first_silent, silent_node

TORQUE, VELOCITY = LOOPS['torque'], LOOPS['velocity']
ALL = {'joint_states': 20, 'odom': 20, 'reference': 20, 'cmd_vel': 20, 'wheel_torques': 20}


def test_every_topic_has_one_rate_and_belongs_to_nodes_that_exist():
    assert {name for name, topic in LOOP_TOPICS.items() if topic.rate == 'position_rate'} == {*POSITION_TOPICS}
    assert {topic.rate for topic in LOOP_TOPICS.values()} == {'position_rate', 'velocity_rate'}
    for topic in LOOP_TOPICS.values():
        assert {topic.publisher, *topic.subscribers} <= set(NODES)
        assert topic.publisher not in topic.subscribers
    # a question comes before its answer and at the same rate
    for question, answer in TORQUE.answers + VELOCITY.answers:
        assert LOOP_TOPICS[question].rate == LOOP_TOPICS[answer].rate
        assert LOOP_TOPICS[question].publisher == 'plant'


@pytest.mark.parametrize(('loop', 'node', 'inputs'), [
    (TORQUE, 'plant', {'wheel_torques': 'velocity_controller'}),
    (TORQUE, 'velocity_controller', {'joint_states': 'plant', 'cmd_vel': 'position_controller'}),
    # a base takes cmd_vel itself
    (VELOCITY, 'plant', {'cmd_vel': 'position_controller'}),
    *((loop, *row) for loop in (TORQUE, VELOCITY) for row in (
        ('position_controller', {'odom': 'plant', 'reference': 'reference_cart'}),
        ('reference_cart', {'odom': 'plant'}))),
])
def test_inputs_of_a_node_name_their_publishers(loop, node, inputs):
    assert loop.inputs_of(node) == inputs


def test_no_node_needs_the_joint_states_of_a_base():
    assert VELOCITY.topics_of('plant') == ['joint_states', 'odom', 'cmd_vel']
    assert 'velocity_controller' not in VELOCITY.nodes
    assert [loop.command for loop in (TORQUE, VELOCITY)] == ['wheel_torques', 'cmd_vel']


@pytest.mark.parametrize(('loop', 'newest', 'node'), [
    (TORQUE, {}, 'reference_cart'),
    (TORQUE, {'reference': 10}, 'position_controller'),
    (TORQUE, {'reference': 0, 'cmd_vel': 10, 'wheel_torques': 12}, 'reference_cart'),
    (TORQUE, {'reference': 10, 'cmd_vel': 10}, 'velocity_controller'),
    (TORQUE, {'reference': 10, 'cmd_vel': 10, 'wheel_torques': 10}, 'velocity_controller'),
    (TORQUE, {'reference': 10, 'cmd_vel': 10, 'wheel_torques': 12}, None),
    # a base waits for no answer between position ticks
    (VELOCITY, {}, 'reference_cart'),
    (VELOCITY, {'reference': 10}, 'position_controller'),
    (VELOCITY, {'reference': 10, 'cmd_vel': 10}, None),
])
def test_the_first_node_without_an_answer_is_the_silent_one(loop, newest, node):
    assert first_silent(newest, stamp=12, tick=10, loop=loop) == node


@pytest.mark.parametrize(('newest', 'lockstep', 'loop', 'silent'), [
    ({}, True, TORQUE, 'plant'),
    (ALL, True, TORQUE, 'plant'),
    (ALL | {'reference': 10}, True, TORQUE, 'reference_cart'),
    (ALL | {'cmd_vel': 10}, True, TORQUE, 'position_controller'),
    (ALL | {'wheel_torques': 18}, True, TORQUE, 'velocity_controller'),
    (ALL | {'odom': 10, 'reference': 10}, True, TORQUE, 'plant'),
    (ALL | {'tracking_error': 20, 'reference': 5}, False, TORQUE, 'reference_cart'),
    ({'joint_states': 12, 'odom': 10}, True, VELOCITY, 'reference_cart'),
    ({'joint_states': 12, 'odom': 10, 'reference': 10, 'cmd_vel': 10}, True, VELOCITY, 'plant'),
])
def test_the_node_that_owes_an_answer_is_named(newest, lockstep, loop, silent):
    assert silent_node(newest, lockstep, 10, loop) == silent
