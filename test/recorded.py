"""Runs in one process as the messages that the nodes would publish, for tests of bags."""

from rclpy.serialization import serialize_message

from mobile_robot_control.recording.bag_writer import BagWriter
from mobile_robot_control.ros import messages
from mobile_robot_control.ros.recorder import LOOP_TOPICS

WALL = 1_790_000_000_000_000_000
"""Wall time of the first message [ns]."""


def _odometry(stamp, frame, pose, velocity):
    return messages.fill_odometry(messages.odometry_message('odom', frame), stamp, pose, velocity)


def said(sample):
    """The messages of a sample: relative topic, stamp [ns] and CDR."""
    stamp, tick = round(sample.time * 1e9), sample.tick
    if tick.time == sample.time:
        yield 'odom', stamp, serialize_message(_odometry(stamp, 'base_link', tick.pose, tick.velocity))
        yield 'reference', stamp, serialize_message(_odometry(stamp, 'reference_cart', *tick.reference))
        yield 'cmd_vel', stamp, serialize_message(messages.twist_message(stamp, 'base_link', sample.command))
        yield 'tracking_error', stamp, serialize_message(messages.error_message(stamp, 'base_link', tick.error))
    yield 'joint_states', stamp, serialize_message(messages.joint_message(
        stamp, (sample.right_angle, sample.left_angle), sample.wheels, sample.applied))
    yield 'wheel_torques', stamp, serialize_message(messages.torque_message(stamp, sample.torque))


def write(writer, samples, prefix='/'):
    """Write samples as an experiment records them."""
    for sample in samples:
        for topic, stamp, message in said(sample):
            writer.write(prefix + topic, LOOP_TOPICS[topic], WALL + stamp, message)


def record(path, samples, prefix='/'):
    """Make a bag of samples."""
    with BagWriter(path) as writer:
        write(writer, samples, prefix)
    assert not writer.failure
    return path
