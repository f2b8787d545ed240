"""Quantities written into messages are read back."""

import math
import struct
from functools import partial

import pytest
from each import each_row
from geometry_msgs.msg import Twist, TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import MultiDOFJointTrajectory

from mobile_robot_control.messages import writing
from mobile_robot_control.messages.parsing import (
    RefusedMessageError,
    read_acceleration,
    read_error,
    read_horizon,
    read_odometry,
    read_time,
    read_torque,
    read_twist,
    read_wheel_angles,
    read_wheel_velocity,
    serialised_stamp,
    stamp_nanoseconds,
)
from mobile_robot_control.quantities import (
    BodyAcceleration,
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.ros.inputs.conversions import bytes_reader
from mobile_robot_control.topics import ALL_LOOP_TOPICS

STAMP = 12_345_678_901
TORQUE = WheelTorque(0.1, -0.2)
TYPES = get_typestore(Stores.ROS2_KILTED)


def _as_rosbags_writes(message, kind):
    """Return a message serialised again by rosbags, which refuses what is too long or too short."""
    return bytes(TYPES.serialize_cdr(TYPES.deserialize_cdr(message, kind), kind))


def _odometry(pose, velocity):
    return deserialize_message(
        writing.odometry_writer('odom', 'base_link')(STAMP, pose, velocity), Odometry)


@each_row('heading', [0.0, 0.5, -3.1, math.pi])
def test_written_odometry_is_read_back(heading):
    pose, velocity = read_odometry(_odometry(Pose(1.0, -2.0, heading), BodyVelocity(0.3, -0.4)))
    assert pose[:2] == (1.0, -2.0)
    assert pose.heading == pytest.approx(heading, abs=1e-15)
    assert velocity == BodyVelocity(0.3, -0.4)


def test_other_written_messages_are_read_back_to_the_last_bit():
    velocity = BodyVelocity(0.1, 0.7)
    command = writing.twist_writer('base_link')(STAMP, velocity)
    assert read_twist(deserialize_message(command, TwistStamped)) == velocity
    plain = deserialize_message(writing.twist_writer('', stamped=False)(STAMP, velocity), Twist)
    assert (plain.linear.x, plain.angular.z) == velocity
    error = writing.error_writer('base_link')(STAMP, TrackingError(0.1, 0.2, 0.3))
    assert read_error(deserialize_message(error, Vector3Stamped)) == (0.1, 0.2, 0.3)
    torque = writing.torque_writer()(STAMP, TORQUE)
    assert read_torque(deserialize_message(torque, JointState)) == TORQUE
    joints = writing.joints_writer()(STAMP, (1.1, 2.2), WheelVelocity(3.3, 4.4), TORQUE)
    wheels = deserialize_message(joints, JointState)
    assert read_wheel_angles(wheels) == (1.1, 2.2)
    assert read_wheel_velocity(wheels) == (3.3, 4.4)
    assert read_torque(wheels) == TORQUE
    assert stamp_nanoseconds(wheels.header.stamp) == serialised_stamp(joints) == STAMP
    for written, kind in ((command, 'geometry_msgs/msg/TwistStamped'), (error, 'geometry_msgs/msg/Vector3Stamped'),
                          (torque, 'sensor_msgs/msg/JointState'), (joints, 'sensor_msgs/msg/JointState')):
        assert written == _as_rosbags_writes(written, kind)
    assert stamp_nanoseconds(deserialize_message(writing.clock_writer()(STAMP), Clock).clock) == STAMP


CART = [Reference(Pose(0.1 * n, -2.0, 0.3 * n), BodyVelocity(0.5, -0.1 * n), BodyAcceleration(n, 0.25))
        for n in range(4)]
PERIOD = 400_000_000
HORIZON = writing.horizon_writer('odom', 'cart', 3, PERIOD)(STAMP, CART)


def _horizon(**changes):
    kind = 'trajectory_msgs/msg/MultiDOFJointTrajectory'
    assert _as_rosbags_writes(HORIZON, kind) == HORIZON
    return bytes_reader(ALL_LOOP_TOPICS['reference_horizon'].kind, partial(
        read_horizon, **{'ticks': 3, 'period': PERIOD, 'frame': 'odom', 'child_frame': 'cart', **changes}))(HORIZON)


def test_a_written_horizon_is_read_back_and_a_longer_one_is_cut():
    for found in (_horizon(), _horizon(ticks=1)):
        for ours, theirs in zip(found, CART, strict=False):
            assert ours[1:] == theirs[1:]
            assert ours.pose == pytest.approx(theirs.pose, abs=1e-15)
    assert len(found) == 2
    message = deserialize_message(HORIZON, MultiDOFJointTrajectory)
    assert [(point.time_from_start.sec, point.time_from_start.nanosec) for point in message.points] == [
        (0, 0), (0, PERIOD), (0, 2 * PERIOD), (1, 200_000_000)]
    accelerated = writing.acceleration_writer('base_link')(STAMP, CART[1].acceleration)
    read = bytes_reader(ALL_LOOP_TOPICS['cmd_accel'].kind, partial(read_acceleration, frame='base_link'))
    assert read(accelerated) == CART[1].acceleration


def test_a_written_time_is_read_back():
    written = writing.time_writer()(STAMP, 3_000_000_007)
    assert written == _as_rosbags_writes(written, 'sensor_msgs/msg/TimeReference')
    assert serialised_stamp(written) == STAMP
    assert bytes_reader(ALL_LOOP_TOPICS['odom_time'].kind, read_time)(written) == 3_000_000_007


@each_row(('changes', 'reason'), [
    ({'ticks': 4}, r'too few points \(4; reference_horizon = 4 needs 5'),
    ({'period': PERIOD // 2}, 'a point is not of its time .point 1 is of 0.4 s'),
    ({'frame': 'map'}, 'frame_id is not map'), ({'child_frame': 'base'}, r'joint_names\[0\] is not base'),
])
def test_a_horizon_that_does_not_fit_is_refused(changes, reason):
    with pytest.raises(RefusedMessageError, match=reason):
        _horizon(**changes)


def test_a_point_without_an_acceleration_is_refused():
    message = deserialize_message(HORIZON, MultiDOFJointTrajectory)
    message.points[2].accelerations = []
    with pytest.raises(RefusedMessageError, match=r'a point is not complete .point 2 lacks'):
        bytes_reader(ALL_LOOP_TOPICS['reference_horizon'].kind, partial(read_horizon, ticks=3, period=PERIOD))(
            bytes(serialize_message(message)))


@each_row('frame', ['', 'odom', 'robot1/odom', 'a' * 31])
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
    assert written == _as_rosbags_writes(written, 'nav_msgs/msg/Odometry')


@each_row('cut', [0, 1, 5, 11, 12, 30, 139])
@each_row('order', [0, 1])
def test_truncated_messages_are_refused(cut, order):
    written = bytearray(writing.joints_writer()(STAMP, (0, 0), WheelVelocity(0, 0), TORQUE))
    written[1] = order
    with pytest.raises(RefusedMessageError, match='not readable'):
        bytes_reader(ALL_LOOP_TOPICS['wheel_torques'].kind, read_torque)(bytes(written[:cut]))
    if cut < 12:
        with pytest.raises(RefusedMessageError, match=f'{cut} bytes hold no stamp'):
            serialised_stamp(bytes(written[:cut]))


def test_a_message_does_not_change_when_the_next_is_written():
    write = writing.torque_writer()
    first = write(0, TORQUE)
    write(STAMP, WheelTorque(5.0, 6.0))
    assert read_torque(deserialize_message(first, JointState)) == TORQUE
    with pytest.raises(struct.error):
        write(STAMP, [1.0])


def test_a_path_has_its_poses():
    message = writing.path_message('odom', [Pose(1.0, 2.0, 0.0), Pose(3.0, 4.0, math.pi)])
    assert [(one.pose.position.x, one.pose.position.y, round(one.pose.orientation.w, 12)) for one in message.poses] == [
        (1.0, 2.0, 1.0), (3.0, 4.0, 0.0)]
    assert {message.header.frame_id, *(one.header.frame_id for one in message.poses)} == {'odom'}


def test_odometry_is_exact_unless_it_is_told_otherwise():
    write = writing.odometry_writer('odom', 'base')
    message = deserialize_message(write(0, Pose(1.0, 2.0, 3.0), BodyVelocity(0.1, 0.2)), Odometry)
    assert not any(message.pose.covariance)
    assert not any(message.twist.covariance)
