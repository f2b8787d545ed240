"""Quantities written into messages are read back."""

import math
import struct
from functools import partial

import pytest
from geometry_msgs.msg import Twist
from helpers.watching import stamp_nanoseconds
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import MultiDOFJointTrajectory

from mobile_robot_control.messages import parsing, writing
from mobile_robot_control.messages.parsing import RefusedMessageError, serialised_stamp
from mobile_robot_control.quantities import (
    BodyAcceleration,
    BodyVelocity,
    Pose,
    Reference,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.ros.shared.conversions import bytes_reader
from mobile_robot_control.topics import ALL_LOOP_TOPICS

STAMP = 12_345_678_901
VELOCITY, TORQUE = BodyVelocity(0.1, 0.7), WheelTorque(0.1, -0.2)
TYPES = get_typestore(Stores.ROS2_KILTED)


def _assert_whole(message, kind):
    """Compare a message with what rosbags writes, which refuses what is too long or too short."""
    assert message == bytes(TYPES.serialize_cdr(TYPES.deserialize_cdr(message, kind), kind))


def _reader(topic, read, **options):
    return bytes_reader(ALL_LOOP_TOPICS[topic].kind, partial(read, **options))


@pytest.mark.parametrize('heading', [0.0, 0.5, -3.1, math.pi])
def test_written_odometry_is_read_back_and_exact_unless_it_is_told_otherwise(heading):
    message = deserialize_message(
        writing.odometry_writer('odom', 'base_link')(STAMP, Pose(1.0, -2.0, heading), VELOCITY), Odometry)
    pose, velocity = parsing.read_odometry(message)
    assert pose[:2] == (1.0, -2.0)
    assert pose.heading == pytest.approx(heading, abs=1e-15)
    assert velocity == VELOCITY
    assert not any([*message.pose.covariance, *message.twist.covariance])


def test_a_plain_twist_and_a_clock_have_what_was_written():
    plain = deserialize_message(writing.twist_writer('', stamped=False)(STAMP, VELOCITY), Twist)
    assert (plain.linear.x, plain.angular.z) == VELOCITY
    assert stamp_nanoseconds(deserialize_message(writing.clock_writer()(STAMP), Clock).clock) == STAMP


CART = [Reference(Pose(0.1 * n, -2.0, 0.3 * n), BodyVelocity(0.5, -0.1 * n), BodyAcceleration(n, 0.25))
        for n in range(4)]
PERIOD = 400_000_000
HORIZON = writing.horizon_writer('odom', 'cart', 3, PERIOD)(STAMP, CART)


def _horizon(message=HORIZON, **changes):
    return _reader('reference_horizon', parsing.read_horizon, **{
        'ticks': 3, 'period': PERIOD, 'frame': 'odom', 'child_frame': 'cart', **changes})(message)


def test_a_written_horizon_is_read_back_and_a_longer_one_is_cut():
    _assert_whole(HORIZON, 'trajectory_msgs/msg/MultiDOFJointTrajectory')
    for found, count in ((_horizon(), 4), (_horizon(ticks=1), 2)):
        assert len(found) == count
        for ours, theirs in zip(found, CART, strict=False):
            assert ours[1:] == theirs[1:]
            assert ours.pose == pytest.approx(theirs.pose, abs=1e-15)
    message = deserialize_message(HORIZON, MultiDOFJointTrajectory)
    assert [(point.time_from_start.sec, point.time_from_start.nanosec) for point in message.points] == [
        (0, 0), (0, PERIOD), (0, 2 * PERIOD), (1, 200_000_000)]


def test_a_horizon_that_does_not_fit_is_refused():
    message = deserialize_message(HORIZON, MultiDOFJointTrajectory)
    message.points[2].accelerations = []
    for changes, reason in (
            ({'ticks': 4}, r'too few points \(4; reference_horizon = 4 needs 5'),
            ({'period': PERIOD // 2}, 'a point is not of its time .point 1 is of 0.4 s'),
            ({'frame': 'map'}, 'frame_id is not map'), ({'child_frame': 'base'}, r'joint_names\[0\] is not base'),
            ({'message': bytes(serialize_message(message))}, r'a point is not complete .point 2 lacks')):
        with pytest.raises(RefusedMessageError, match=reason):
            _horizon(**changes)


@pytest.mark.parametrize('frame', ['', 'odom', 'robot1/odom', 'a' * 31])
def test_rclpy_reads_the_message_that_it_would_have_written_itself(frame):
    """Frame names of all lengths shift the fields after them."""
    message = Odometry(child_frame_id=f'{frame}x')
    message.header.frame_id = frame
    message.header.stamp.sec, message.header.stamp.nanosec = 12, 345_678_901
    message.pose.pose.position.x, message.pose.pose.position.y, message.pose.pose.orientation.w = -0.0, 5e-324, 1.0
    message.twist.twist.linear.x, message.twist.twist.angular.z = 1e308, -0.3
    message.pose.covariance[0], message.pose.covariance[35], message.twist.covariance[7] = 0.1, 0.2, 0.3
    write = writing.odometry_writer(frame, f'{frame}x', [0.1, 0, 0, 0, 0, 0.2], [0, 0.3, 0, 0, 0, 0])
    for pose in (Pose(7.0, 8.0, 9.0), Pose(-0.0, 5e-324, 0.0)):
        written = write(STAMP, pose, BodyVelocity(1e308, -0.3))
    assert deserialize_message(written, Odometry) == message
    _assert_whole(written, 'nav_msgs/msg/Odometry')


def test_truncated_messages_are_refused():
    for order in (0, 1):
        written = bytearray(writing.joints_writer()(STAMP, (0, 0), WheelVelocity(0, 0), TORQUE))
        written[1] = order
        for cut in (0, 1, 5, 11, 12, 30, 139):
            with pytest.raises(RefusedMessageError, match='not readable'):
                _reader('wheel_torques', parsing.read_torque)(bytes(written[:cut]))
            if cut < 12:
                with pytest.raises(RefusedMessageError, match=f'{cut} bytes hold no stamp'):
                    serialised_stamp(bytes(written[:cut]))


def test_a_message_does_not_change_when_the_next_is_written():
    write = writing.torque_writer()
    first = write(0, TORQUE)
    write(STAMP, WheelTorque(5.0, 6.0))
    assert parsing.read_torque(deserialize_message(first, JointState)) == TORQUE
    with pytest.raises(struct.error):
        write(STAMP, [1.0])


def test_a_path_has_its_poses():
    message = writing.path_message('odom', [Pose(1.0, 2.0, 0.0), Pose(3.0, 4.0, math.pi)])
    assert [(one.pose.position.x, one.pose.position.y, round(one.pose.orientation.w, 12)) for one in message.poses] == [
        (1.0, 2.0, 1.0), (3.0, 4.0, 0.0)]
    assert {message.header.frame_id, *(one.header.frame_id for one in message.poses)} == {'odom'}
