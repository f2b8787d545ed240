"""The package's deserialiser of the loop's messages agrees with that of rosbags."""

import numpy as np
import pytest
from each import each_row
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from mobile_robot_control.messages.cdr import deserialise

STORE = get_typestore(Stores.ROS2_KILTED)
TYPES = STORE.types

numbers = st.floats(allow_nan=False)
names = st.text(st.characters(blacklist_categories=['Cs'], blacklist_characters='\0'), max_size=20)
doubles = st.lists(numbers, max_size=4).map(lambda values: np.array(values, dtype=np.float64))


def _make(kind):
    return TYPES[kind]


headers = st.builds(
    _make('std_msgs/msg/Header'), frame_id=names,
    stamp=st.builds(_make('builtin_interfaces/msg/Time'), sec=st.integers(0, 2**31 - 1), nanosec=st.integers(0, 10**9)),
)
vectors = st.builds(_make('geometry_msgs/msg/Vector3'), x=numbers, y=numbers, z=numbers)
points = st.builds(_make('geometry_msgs/msg/Point'), x=numbers, y=numbers, z=numbers)
quaternions = st.builds(_make('geometry_msgs/msg/Quaternion'), x=numbers, y=numbers, z=numbers, w=numbers)
poses = st.builds(_make('geometry_msgs/msg/Pose'), position=points, orientation=quaternions)
twists = st.builds(_make('geometry_msgs/msg/Twist'), linear=vectors, angular=vectors)
covariances = st.floats(-1e9, 1e9).map(lambda value: np.full(36, value))
pairs = st.builds(_make('diagnostic_msgs/msg/KeyValue'), key=names, value=names)
transforms = st.builds(_make('geometry_msgs/msg/Transform'), translation=vectors, rotation=quaternions)
trajectory_points = st.builds(
    _make('trajectory_msgs/msg/MultiDOFJointTrajectoryPoint'), transforms=st.lists(transforms, max_size=2),
    velocities=st.lists(twists, max_size=2), accelerations=st.lists(twists, max_size=2),
    time_from_start=st.builds(_make('builtin_interfaces/msg/Duration'), sec=st.integers(-2**31, 2**31 - 1),
                              nanosec=st.integers(0, 10**9)))
statuses = st.builds(_make('diagnostic_msgs/msg/DiagnosticStatus'), level=st.integers(0, 3), name=names, message=names,
                     hardware_id=names, values=st.lists(pairs, max_size=3))
HEAD = TYPES['std_msgs/msg/Header'](TYPES['builtin_interfaces/msg/Time'](1, 2), 'odom')
MESSAGES = {
    'sensor_msgs/msg/JointState': st.builds(
        _make('sensor_msgs/msg/JointState'), header=headers, name=st.lists(names, max_size=3), position=doubles,
        velocity=doubles, effort=doubles),
    'nav_msgs/msg/Odometry': st.builds(
        _make('nav_msgs/msg/Odometry'), header=headers, child_frame_id=names,
        pose=st.builds(_make('geometry_msgs/msg/PoseWithCovariance'), pose=poses, covariance=covariances),
        twist=st.builds(_make('geometry_msgs/msg/TwistWithCovariance'), twist=twists, covariance=covariances)),
    'geometry_msgs/msg/TwistStamped': st.builds(
        _make('geometry_msgs/msg/TwistStamped'), header=headers, twist=twists),
    'geometry_msgs/msg/AccelStamped': st.builds(
        _make('geometry_msgs/msg/AccelStamped'), header=headers,
        accel=st.builds(_make('geometry_msgs/msg/Accel'), linear=vectors, angular=vectors)),
    'geometry_msgs/msg/Vector3Stamped': st.builds(
        _make('geometry_msgs/msg/Vector3Stamped'), header=headers, vector=vectors),
    'geometry_msgs/msg/Twist': twists,
    'geometry_msgs/msg/WrenchStamped': st.builds(
        _make('geometry_msgs/msg/WrenchStamped'), header=headers,
        wrench=st.builds(_make('geometry_msgs/msg/Wrench'), force=vectors, torque=vectors)),
    'sensor_msgs/msg/TimeReference': st.builds(
        _make('sensor_msgs/msg/TimeReference'), header=headers, source=names,
        time_ref=st.builds(_make('builtin_interfaces/msg/Time'), sec=st.integers(0, 2**31 - 1),
                           nanosec=st.integers(0, 10**9))),
    'trajectory_msgs/msg/MultiDOFJointTrajectory': st.builds(
        _make('trajectory_msgs/msg/MultiDOFJointTrajectory'), header=headers, joint_names=st.lists(names, max_size=3),
        points=st.lists(trajectory_points, max_size=3)),
    'diagnostic_msgs/msg/DiagnosticArray': st.builds(
        _make('diagnostic_msgs/msg/DiagnosticArray'), header=headers, status=st.lists(statuses, max_size=3)),
}


def _assert_same(ours, theirs):
    """Compare every field that we have."""
    if hasattr(ours, '_fields'):
        for field in ours._fields:
            _assert_same(getattr(ours, field), getattr(theirs, field))
    elif type(theirs).__name__.endswith(('Duration', 'Time')):
        assert ours == theirs.sec * 10**9 + theirs.nanosec
    elif isinstance(ours, tuple):
        assert len(ours) == len(theirs)
        for one, other in zip(ours, theirs, strict=True):
            _assert_same(one, other)
    else:
        assert ours == theirs


@each_row('kind', MESSAGES)
def test_every_field_equals_that_of_rosbags(kind):
    @settings(max_examples=20)
    @given(MESSAGES[kind], st.sampled_from([b'', b'\0\0\0', b'padding!']))
    def check(message, behind):
        for little_endian in (True, False):
            data = bytes(STORE.serialize_cdr(message, kind, little_endian=little_endian))
            _assert_same(deserialise(kind, data + behind), STORE.deserialize_cdr(data, kind))

    check()


@given(st.sampled_from([*MESSAGES]), st.binary(max_size=200))
def test_random_bytes_are_read_or_refused_with_a_value_error(kind, garbage):
    for data in (garbage, b'\0\1\0\0' + garbage):
        try:
            deserialise(kind, data)
        except ValueError:
            continue
        assert data[:2] in (b'\0\1', b'\0\0')


@each_row('mark', [b'\0\2', b'\0\3', b'\0\6', b'\0\7', b'\1\1', b''])
def test_what_is_no_plain_cdr_is_refused(mark):
    with pytest.raises(ValueError, match='not plain CDR'):
        deserialise('geometry_msgs/msg/Vector3Stamped', mark + bytes(100 if mark else 0))


def test_a_text_that_ends_behind_the_message_is_refused():
    array = bytes(STORE.serialize_cdr(STORE.types['diagnostic_msgs/msg/DiagnosticArray'](header=HEAD, status=[
        STORE.types['diagnostic_msgs/msg/DiagnosticStatus'](level=0, name='n', message='m', hardware_id='h', values=[
            STORE.types['diagnostic_msgs/msg/KeyValue'](key='k', value='long')])]),
        'diagnostic_msgs/msg/DiagnosticArray'))
    assert deserialise('diagnostic_msgs/msg/DiagnosticArray', array).status[0].values == (('k', 'long'),)
    for end in range(4, len(array)):
        with pytest.raises(ValueError, match=r'behind the message|unpack_from'):
            deserialise('diagnostic_msgs/msg/DiagnosticArray', array[:end])
