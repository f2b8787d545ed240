"""Rollouts as the messages that the nodes would publish, and bags of them."""

import json

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from mcap.writer import Writer
from rclpy.serialization import serialize_message

from mobile_robot_control.messages import writing
from mobile_robot_control.messages.topic_forms import Conventions, writer
from mobile_robot_control.runs.bag_writer import BagWriter
from mobile_robot_control.topics import LOOP_TOPICS, RUN_TOPICS

WALL = 1_790_000_000_000_000_000
"""Wall time of the first message [ns]."""


ODOM, REFERENCE = (writing.odometry_writer('odom', frame) for frame in ('base_link', 'reference_cart'))
GROUND_TRUTH = writing.odometry_writer('odom', 'base_link')
CMD_VEL, TRACKING_ERROR = (writer(topic, Conventions(base='base_link')) for topic in ('cmd_vel', 'tracking_error'))
JOINT_STATES, WHEEL_TORQUES = writing.joints_writer(), writing.torque_writer()
KINDS = {name: topic.kind for name, topic in RUN_TOPICS.items()}


def messages_of(sample):
    """Yield the messages of a sample: relative topic, stamp [ns] and CDR."""
    stamp, tick = round(sample.time * 1e9), sample.tick
    if tick.time == sample.time:
        yield 'odom', stamp, ODOM(stamp, tick.pose, tick.velocity)
        yield 'reference', stamp, REFERENCE(stamp, *tick.reference[:2])
        yield 'cmd_vel', stamp, CMD_VEL(stamp, sample.command)
        yield 'tracking_error', stamp, TRACKING_ERROR(stamp, tick.error)
        if sample.truth is not None and sample.truth.pose != tick.pose:
            yield 'ground_truth', stamp, GROUND_TRUTH(stamp, sample.truth.pose, sample.truth.velocity)
    yield 'joint_states', stamp, JOINT_STATES(
        stamp, (sample.right_angle, sample.left_angle), sample.wheels, sample.applied)
    yield 'wheel_torques', stamp, WHEEL_TORQUES(stamp, sample.torque)


def write(writer, samples, prefix='/'):
    """Write samples as an experiment records them."""
    for sample in samples:
        for topic, stamp, message in messages_of(sample):
            writer.write(prefix + topic, KINDS[topic], WALL + stamp, message)


def record(path, samples, prefix='/'):
    """Write a bag of samples; returns its path."""
    with BagWriter(path) as writer:
        write(writer, samples, prefix)
    assert not writer.failure
    return path


def write_mcap(file, samples, compression, chunk_size):
    """Write a plain mcap file of samples, whose chunks are compressed."""
    with file.open('wb') as stream:
        writer = Writer(stream, compression=compression, chunk_size=chunk_size)
        writer.start('ros2')
        channels = {topic: writer.register_channel(f'/{topic}', 'cdr', writer.register_schema(row.kind, 'ros2msg', b''))
                    for topic, row in LOOP_TOPICS.items()}
        for sample in samples:
            for topic, stamp, message in messages_of(sample):
                writer.add_message(channels[topic], WALL + stamp, message, WALL + stamp)
        writer.finish()


def event(stamp, node, run=0, **values):
    """Return an event as a node publishes it; two underscores stand for the dot in a key."""
    array = DiagnosticArray(status=[DiagnosticStatus(name=node, values=[
        KeyValue(key=key.replace('__', '.'), value=json.dumps(value)), KeyValue(key='run', value=str(run))])
        for key, value in values.items()])
    array.header.stamp = Time(sec=stamp // 10**9, nanosec=stamp % 10**9)
    return bytes(serialize_message(array))
