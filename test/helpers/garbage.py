"""
A publisher of garbage on every loop topic at 1 kHz: messages that every node must refuse, with stamps of the run.

A process of its own: ``python test/garbage.py``. At the end it prints how many messages it has sent.
"""

import copy
import functools
import itertools
import math
import signal
import time

import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from helpers.watching import stamp_nanoseconds
from mobile_robot_control.ros.shared.qos import SUBSCRIBED
from mobile_robot_control.ros.start.spin import make_executor

RATE = 1000.0
WRONG_FRAME = 'elsewhere'
NUMBERS = (math.nan, math.inf, -math.inf, 1e308, -1e308)
MARK = 7.25
# the field that marks a message as garbage: one that the loop does not use
MARKS = {'odom': 'pose.pose.position.z', 'reference': 'pose.pose.position.z', 'cmd_vel': 'twist.linear.y',
         'tracking_error': 'vector.y', 'joint_states': 'header.frame_id', 'wheel_torques': 'header.frame_id'}
_VELOCITY_PERIOD, _POSITION_PERIOD = 2_000_000, 10_000_000
KINDS = {'odom': Odometry, 'reference': Odometry, 'cmd_vel': TwistStamped, 'tracking_error': Vector3Stamped,
         'joint_states': JointState, 'wheel_torques': JointState}


def _changed(message, path, value):
    """Copy a message with one field changed, named by its path."""
    made, (*folders, leaf) = copy.deepcopy(message), path.split('.')
    setattr(functools.reduce(getattr, folders, made), leaf, value)
    return made


_FIELDS = {
    'odom': ('pose.pose.position.x', 'twist.twist.linear.x', 'twist.twist.angular.z', 'pose.pose.orientation.w'),
    'cmd_vel': ('twist.linear.x', 'twist.angular.z'), 'tracking_error': ('vector.x',), 'joint_states': ('velocity',),
    'wheel_torques': ('effort',)}
_FIELDS['reference'] = _FIELDS['odom']


def _spoil(topic, sound):
    """Yield a valid message with a field that is wrong."""
    joints = isinstance(sound, JointState)
    for path, value in itertools.product(_FIELDS[topic], NUMBERS):
        yield _changed(sound, path, [value, 0.0] if joints else value)
    if joints:
        for path, value in ((_FIELDS[topic][0], []), (_FIELDS[topic][0], [0.0, 0.0, 0.0]), ('name', []),
                            ('name', ['left', 'right'])):
            yield _changed(sound, path, value)
    else:
        yield _changed(sound, 'header.frame_id', WRONG_FRAME)
    if isinstance(sound, Odometry):
        yield _changed(sound, 'child_frame_id', WRONG_FRAME)
        yield _changed(_changed(sound, 'pose.pose.orientation.z', 0.0), 'pose.pose.orientation.w', 0.0)


def spoilt(topic, sound):
    """
    Yield every kind of garbage made of a valid message, each with the shift of its stamp from the present one [ns].

    A valid message with the stamp 0 or the next one is not garbage: so a new run begins and goes on.
    """
    period = _VELOCITY_PERIOD if topic in ('joint_states', 'wheel_torques') else _POSITION_PERIOD
    sound = _changed(sound, MARKS[topic], WRONG_FRAME if MARKS[topic].endswith('frame_id') else MARK)
    yield from itertools.product(_spoil(topic, sound), (0, _VELOCITY_PERIOD, _POSITION_PERIOD))
    # invalid stamps, so far away that the run does not reach them
    for shift in (-3 * period, 1, period // 2 + 1, 1_000_000_000, 3_600_000_000_000, -3_600_000_000_000):
        yield sound, shift


def is_garbage(topic, serialised):
    """Return whether a recorded message is garbage, by its mark."""
    found = functools.reduce(getattr, MARKS[topic].split('.'), deserialize_message(serialised, KINDS[topic]))
    return found in (WRONG_FRAME, MARK)


def _stamp(now, shift):
    # before the first position ticks have passed, a stamp in the past must not be 0
    sec, nanosec = divmod(now + shift if now + shift > 0 or shift >= 0 else -1_000_000_000, 1_000_000_000)
    return Time(sec=sec, nanosec=nanosec)


def main():
    """Publish garbage until SIGINT or SIGTERM."""
    stopped = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.append(True))
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node, executor = rclpy.create_node('garbage_publisher'), make_executor()
    executor.add_node(node)
    sound, clock = {}, [0]
    subscriptions = [node.create_subscription(kind, topic, functools.partial(sound.setdefault, topic), SUBSCRIBED)
                     for topic, kind in KINDS.items()]
    node.create_subscription(
        Clock, '/clock', lambda message: clock.append(stamp_nanoseconds(message.clock)), SUBSCRIBED)
    while len(sound) < len(KINDS) and not stopped:
        executor.spin_once(timeout_sec=0.1)
    for subscription in subscriptions:
        node.destroy_subscription(subscription)
    publishers = {topic: node.create_publisher(kind, topic, 10) for topic, kind in KINDS.items()}
    streams = {topic: itertools.cycle(list(spoilt(topic, message))) for topic, message in sound.items()}
    topics, sent, started = itertools.cycle(KINDS), 0, time.monotonic()
    while not stopped:
        executor.spin_once(timeout_sec=0.0005)
        due = int((time.monotonic() - started) * RATE)
        while sent < due and not stopped:
            topic = next(topics)
            message, shift = next(streams[topic])
            message.header.stamp = _stamp(clock[-1], shift)
            publishers[topic].publish(message)
            sent += 1
        del clock[:-1]
    print(sent, flush=True)
    executor.shutdown()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
