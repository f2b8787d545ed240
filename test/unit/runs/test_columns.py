"""A sample and the numbers of its topics are one another's inverse, in the columns of the topics' rows."""

import pytest
from helpers.measuring import configuration

from mobile_robot_control.runs.columns import COLUMNS, TRUE_ERROR, held_of, numbers_of, sample_of
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.topics import GROUND_TRUTH, LOOP_TOPICS


@pytest.mark.parametrize('noise', [0.0, 0.01])
def test_a_sample_has_the_columns_of_every_topic_in_their_order_and_is_made_of_them_again(noise):
    *_, sample = rollout(configuration(plant={'noise.velocity': noise}), 0.025)
    numbers = numbers_of(sample)
    assert list(numbers) == [*LOOP_TOPICS, *([GROUND_TRUTH, TRUE_ERROR] if noise else [])]
    assert {topic: len(values) for topic, values in numbers.items()} == {
        topic: len(COLUMNS[topic]) for topic in numbers}
    assert sample_of(sample.time, held_of(sample.tick.time, numbers), numbers) == sample
    named = {topic: dict(zip(COLUMNS[topic], values, strict=True)) for topic, values in numbers.items()}
    assert named['joint_states']['left_velocity'] == sample.wheels.left
    assert named['joint_states']['right_effort'] == sample.applied.right
    assert named['wheel_torques']['left_effort'] == sample.torque.left
    assert named['odom']['heading'] == sample.tick.pose.heading
    assert named['reference']['angular'] == sample.tick.reference.velocity.angular
    assert named['cmd_vel']['linear'] == sample.command.linear
    assert named['tracking_error']['lateral'] == sample.tick.error.lateral
