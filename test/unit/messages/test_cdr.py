"""The package's deserialiser of the loop's messages agrees with that of rosbags."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from mobile_robot_control.messages.cdr import deserialise

STORE = get_typestore(Stores.ROS2_KILTED)
ARRAY = 'diagnostic_msgs/msg/DiagnosticArray'
KINDS = [
    'sensor_msgs/msg/JointState', 'nav_msgs/msg/Odometry', 'geometry_msgs/msg/TwistStamped',
    'geometry_msgs/msg/AccelStamped', 'geometry_msgs/msg/Vector3Stamped', 'geometry_msgs/msg/Twist',
    'geometry_msgs/msg/WrenchStamped', 'sensor_msgs/msg/TimeReference', 'trajectory_msgs/msg/MultiDOFJointTrajectory',
    ARRAY]
NUMBERS = {
    'float64': st.floats(allow_nan=False), 'int32': st.integers(-2**31, 2**31 - 1), 'uint32': st.integers(0, 10**9),
    'byte': st.integers(0, 3), 'string': st.text(st.characters(
        blacklist_categories=['Cs'], blacklist_characters='\0'), max_size=20)}


def messages(kind):
    """Draw messages of a kind by its definition."""
    return st.builds(STORE.types[kind], **{name: _field(*field) for name, field in STORE.fielddefs[kind][1]})


def _field(node, content):
    if node.name == 'BASE':
        return NUMBERS[content[0]]
    if node.name == 'NAME':
        return messages(content)
    element, length = content
    drawn = st.lists(_field(*element), min_size=0, max_size=2) if node.name == 'SEQUENCE' else (
        _field(*element).map(lambda value: [value] * length))
    return drawn.map(np.array) if element[1][0] == 'float64' else drawn


def _assert_same(ours, theirs):
    """Compare every field that we have."""
    if hasattr(ours, '_fields'):
        for field in ours._fields:
            _assert_same(getattr(ours, field), getattr(theirs, field))
    elif type(theirs).__name__.endswith(('Duration', 'Time')):
        assert ours == theirs.sec * 10**9 + theirs.nanosec
    elif isinstance(ours, tuple):
        for one, other in zip(ours, theirs, strict=True):
            _assert_same(one, other)
    else:
        assert ours == theirs


@pytest.mark.parametrize('kind', KINDS)
def test_every_field_equals_that_of_rosbags(kind):
    @settings(max_examples=20)
    @given(messages(kind), st.sampled_from([b'', b'\0\0\0', b'padding!']))
    def check(message, behind):
        for little_endian in (True, False):
            data = bytes(STORE.serialize_cdr(message, kind, little_endian=little_endian))
            _assert_same(deserialise(kind, data + behind), STORE.deserialize_cdr(data, kind))

    check()


def test_no_plain_cdr_and_a_text_that_ends_behind_the_message_are_refused():
    for mark in (b'\0\2', b'\0\3', b'\0\6', b'\0\7', b'\1\1', b''):
        with pytest.raises(ValueError, match='not plain CDR'):
            deserialise('geometry_msgs/msg/Vector3Stamped', mark + bytes(100 if mark else 0))
    types = STORE.types
    head = types['std_msgs/msg/Header'](types['builtin_interfaces/msg/Time'](1, 2), 'odom')
    status = types['diagnostic_msgs/msg/DiagnosticStatus'](0, 'n', 'm', 'h', [
        types['diagnostic_msgs/msg/KeyValue']('k', 'long')])
    array = bytes(STORE.serialize_cdr(types[ARRAY](head, [status]), ARRAY))
    assert deserialise(ARRAY, array).status[0].values == (('k', 'long'),)
    for end in range(4, len(array)):
        with pytest.raises(ValueError, match=r'behind the message|unpack_from'):
            deserialise(ARRAY, array[:end])
