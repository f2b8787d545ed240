"""The rows of the topics and the forms of their messages agree."""

import math
from functools import reduce

import pytest
from rosbags.typesys import Stores, get_typestore

from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, serialised_stamp
from mobile_robot_control.messages.topic_forms import Conventions, columns_reader, reader, writer
from mobile_robot_control.quantities import (
    BodyAcceleration,
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.runs.columns import COLUMNS
from mobile_robot_control.topics import RUN_TOPICS, TOPICS, WHEEL_JOINTS

STAMP = 12_345_678_901
TYPES = get_typestore(Stores.ROS2_KILTED)
CONVENTIONS = Conventions('odom', 'base_link', 'cart', ticks=1, period=10_000_000)
MOTION = Pose(1.5, -2.5, 1.0), BodyVelocity(0.3, -0.7)
AHEAD = Reference(*MOTION, BodyAcceleration(0.2, 0.4))
VALUES = {
    'joint_states': ((1.1, 2.2), WheelVelocity(3.3, 4.4), WheelTorque(0.1, -0.2)),
    'wheel_torques': WheelTorque(0.1, -0.2), 'cmd_vel': BodyVelocity(0.1, 0.7), 'cmd_accel': BodyAcceleration(0.3, 0.9),
    'tracking_error': TrackingError(0.1, 0.2, 0.3), 'odom_time': 3_000_000_007, 'reference_horizon': (AHEAD, AHEAD),
}
"""What a node publishes on a topic, if it is neither a motion nor numbers that have no name."""


def _value(row):
    unnamed = MOTION if row.kind == 'nav_msgs/msg/Odometry' else tuple(n + 0.5 for n in range(len(row.fields)))
    return VALUES.get(row.name, unnamed)


def _flat(value):
    return [number for part in value for number in (_flat(part) if isinstance(part, tuple) else [part])]


def _at(message, field):
    """The number in a field of a message; of joint states, that of a joint."""
    owner, _, joint = field.partition('.')
    if joint in WHEEL_JOINTS:
        return getattr(message, owner)[message.name.index(joint)]
    return reduce(getattr, field.split('.'), message)


@pytest.mark.parametrize('row', TOPICS.values(), ids=TOPICS)
def test_what_is_written_by_the_name_of_a_topic_is_read_back_by_it(row):
    value = _value(row)
    message = writer(row.name, CONVENTIONS)(STAMP, value)
    # rosbags refuses what is too long or too short
    assert message == bytes(TYPES.serialize_cdr(TYPES.deserialize_cdr(message, row.kind), row.kind))
    assert serialised_stamp(message) == STAMP
    read = reader(row.name, CONVENTIONS)(deserialise(row.kind, message))
    assert read == (value[1] if row.name == 'joint_states' else value)
    assert type(read) is type(value) or row.name == 'joint_states'


@pytest.mark.parametrize('row', RUN_TOPICS.values(), ids=RUN_TOPICS)
def test_columns_and_fields_of_a_row_hold_the_numbers_of_its_message(row):
    numbers = _flat(_value(row))
    message = writer(row.name, CONVENTIONS)(STAMP, _value(row))
    assert list(columns_reader(row.name)(deserialise(row.kind, message))) == numbers
    assert len(numbers) == len(row.columns) == len(COLUMNS[row.name])
    assert len(row.short) in (0, len(numbers))
    if row.kind == 'nav_msgs/msg/Odometry':  # whose quaternion holds the heading
        numbers[2:3] = math.sin(0.5), math.cos(0.5)
    raw = TYPES.deserialize_cdr(message, row.kind)
    assert [_at(raw, field) for field in row.fields] == pytest.approx(numbers, abs=1e-15)


def test_a_message_in_another_frame_is_refused():
    for topic in ('odom', 'reference', 'cmd_vel', 'cmd_accel', 'reference_horizon'):
        message = deserialise(TOPICS[topic].kind, writer(topic, CONVENTIONS)(STAMP, _value(TOPICS[topic])))
        with pytest.raises(RefusedMessageError, match='is not elsewhere'):
            reader(topic, CONVENTIONS._replace(odom='elsewhere', base='elsewhere'))(message)
