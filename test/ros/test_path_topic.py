"""Paths on the topic `path`: taken over in mid-run without a jump, at their stamp in lockstep, and done again."""

import math
from itertools import pairwise

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry, Path
from rclpy.event_handler import PublisherEventCallbacks

from mobile_robot_control.ros.shared.qos import LATCHED

TIMING = ['-p', 'curve:=path', '-p', 'timing.max_linear_velocity:=0.5', '-p', 'timing.max_linear_acceleration:=1.0',
          '-p', 'timing.max_lateral_acceleration:=0.5', '-p', 'timing.max_angular_acceleration:=10.0', '-p',
          'path.join_distance:=0.4', '-p',
          'initial_pose:=[0.0, 0.0, 0.0]']


def path(*points, stamp=0, frame='odom'):
    message = Path(poses=[PoseStamped() for _ in points])
    message.header.frame_id, message.header.stamp = frame, Time(sec=stamp // 10**9, nanosec=stamp % 10**9)
    for pose, (x, y) in zip(message.poses, points, strict=True):
        pose.header.frame_id = frame
        pose.pose.position.x, pose.pose.position.y = float(x), float(y)
    return message


@pytest.fixture
def cart(robot):
    """The states of the cart on /diagnostics, the newest one last."""
    states = ['']
    robot.recorder.create_subscription(DiagnosticArray, '/diagnostics', lambda message: states.extend(
        status.message for status in message.status if status.name.endswith('reference_cart')), 10)
    return states


def _wait_for_the_cart(robot, subscriptions=1):
    """Wait until the subscriptions of the cart are discovered, one more for kept paths: none is lost any more."""
    robot.spin_until(lambda: [end.node_name for end in robot.recorder.get_subscriptions_info_by_topic('/path')].count(
        'reference_cart') == subscriptions)


def assert_no_jump(recording):
    """The reference moves as its velocity says, at every tick, and its velocity within the limits of TIMING."""
    ticks = {sample.tick.time: sample.tick.reference for sample in recording.samples}
    for (begin, before), (end, after) in pairwise(ticks.items()):
        dt = end - begin
        assert 0.0 <= after.velocity.linear <= 0.5 * 1.001
        assert abs(after.velocity.linear - before.velocity.linear) <= 1.01 * dt + 1e-9
        assert abs(after.velocity.angular - before.velocity.angular) <= 10.5 * dt
        moved = math.dist(after.pose[:2], before.pose[:2])
        mean = 0.5 * (before.velocity.linear + after.velocity.linear)
        # within a tick it may speed up and brake by 1 m/s²
        assert moved == pytest.approx(mean * dt, abs=1e-3 * dt + 0.26 * dt * dt)
        turned = math.remainder(after.pose.heading - before.pose.heading, 2.0 * math.pi)
        assert abs(turned) <= 1.01 * max(abs(before.velocity.angular), abs(after.velocity.angular)) * dt + 1e-4


def _go_to(robot, seconds):
    """Let a run go on to a time, at which it is held."""
    robot.set('plant', hold_at=seconds, real_time_factor=0.0)
    robot.wait_at(seconds)


def test_paths_act_at_their_stamps_and_the_cart_tells_when_it_has_arrived(robot, cart):
    publisher = robot.recorder.create_publisher(Path, 'path', LATCHED)

    def publish(*args, **options):
        publisher.publish(path(*args, **options))
        publisher.wait_for_all_acked()

    robot.start(arguments=[*TIMING, '-p', 'hold_at:=5.0'], composed=True)
    robot.spin_until(lambda: cart[-1] == 'standing')
    # of several paths it takes the last one only, when it discovers the publisher
    _wait_for_the_cart(robot, 2)
    _go_to(robot, 5.0)
    # stamp 0 and one of another clock act at the next tick, the later one wins; a later stamp acts at its tick
    publish((0, 0), (0, 5))
    publish((0, 0), (1.5, 0), stamp=1_790_000_000_000_000_000)
    publish((0.2, 0.1), (0.6, 0.1), (1.0, 0.6), stamp=6_000_000_001)
    _go_to(robot, 6.5)
    publish((0.4, 0.1), (math.nan, 0))
    _go_to(robot, 6.6)
    robot.spin_until(lambda: 'path not finite' in robot.log('reference_cart'))
    # a plan that ends at once stops the cart, which stands for others that are refused
    for n, (wrong, reason) in enumerate((
            ([(0.5, 0.06), (0.62, 0.06)], 'cannot be driven (the cart stops: '),
            ([(4, 4), (5, 5)], 'path: cannot be driven (the path begins'), ([(0.4, 0.1)], 'a path needs two'),
            ([(0.6, 0.1), (3, 0.1), (1, 0.1)], 'the path turns back at (3, 0.1)'))):
        publish(*wrong)
        _go_to(robot, 8.0 + 0.1 * n)
        robot.spin_until(lambda reason=reason: reason in robot.log('reference_cart'))
    publish((0.2, 0.1), (0.6, 0.1), (1.0, 0.6))
    _go_to(robot, 9.3)
    # the route that is driven, from the robot on: nothing changes
    publish((0.75, 0.3), (1.0, 0.6))
    _go_to(robot, 9.4)
    publisher.publish(b'\0\1\0\0')
    publisher.wait_for_all_acked()
    publish((0, 0), (1, 0), frame='map')
    robot.set('plant', hold_at=0.0, real_time_factor=1.0)
    robot.spin_until(lambda: all(words in robot.log('reference_cart') for words in (
        'frame_id is not odom', 'path: not readable')))
    robot.spin_until(lambda: cart[-1] == 'arrived')
    assert robot.log('reference_cart').count('takes over a path') == 3
    robot.stop()
    recording = robot.recording()
    assert_no_jump(recording)
    by_time = {round(sample.tick.time, 6): sample.tick.reference for sample in recording.samples}
    assert by_time[5.01].velocity.linear == 0.0 < by_time[5.02].velocity.linear
    assert by_time[6.01].pose.y == 0.0 < by_time[6.02].pose.y
    assert by_time[6.7].velocity.linear > by_time[8.0].velocity.linear == by_time[8.3].velocity.linear == 0.0
    assert recording.samples[-1].tick.reference.pose[:2] == pytest.approx((1.0, 0.6))


def test_on_the_wall_clock_a_path_is_planned_beside_the_cart_and_an_empty_one_stops_it(robot, cart):
    unfit = []
    publisher = robot.recorder.create_publisher(Path, 'path', 10, event_callbacks=PublisherEventCallbacks(
        incompatible_qos=unfit.append, use_default_callbacks=False))
    numbers = {}
    robot.recorder.create_subscription(DiagnosticArray, '/diagnostics', lambda message: numbers.update(
        (one.key, one.value) for one in message.status[0].values if 'pla' in one.key or 'path' in one.key), 10)
    # at the rates of config/wall_clock.yaml, which leave half of the machine to other tests
    robot.start(arguments=['-p', 'lockstep:=false', '-p', 'velocity_rate:=200.0', '-p', 'position_rate:=50.0',
                           '-p', 'path.timeout:=2.0', *TIMING], composed=True)
    robot.spin_until(lambda: cart[-1] == 'standing')
    references = []
    robot.recorder.create_subscription(Odometry, 'reference', lambda message: references.append(
        (message.pose.pose.position, message.twist.twist.linear.x)), 100)
    _wait_for_the_cart(robot)
    waves = path(*((0.02 * n, 0.2 * math.sin(0.1 * n)) for n in range(300)))
    publisher.publish(waves)
    robot.spin_until(lambda: max((speed for _, speed in references), default=0.0) > 0.3)
    publisher.publish(path((9, 9), (10, 10)))
    robot.spin_until(lambda: 'the cart stops: the path begins' in robot.log('reference_cart'))
    robot.spin_until(lambda: references[-1][1] == 0.0)
    # it also waits for a robot that was late; without another plan it stops, whatever else comes
    publisher.publish(waves)
    robot.spin_until(lambda: references[-1][1] > 0.1)
    publisher.publish(b'\0\1\0\0')
    robot.spin_until(lambda: 'no path for path.timeout = 2 s: the cart stops' in robot.log('reference_cart'))
    robot.spin_until(lambda: references[-1][1] == 0.0)
    robot.spin_until(lambda: float(numbers['plans taken']) >= 3 and numbers['refused path: cannot be driven'] == '1')
    assert 0.0 < float(numbers['planning time [s]']) < 5.0
    publisher.publish(waves)
    robot.spin_until(lambda: references[-1][1] > 0.1)
    publisher.publish(path())
    robot.spin_until(lambda: references[-1][1] == 0.0)
    robot.spin_until(lambda: cart[-1] == 'standing')
    # DDS finds nothing to warn of
    assert not unfit
    robot.stop()
    for (start, before), (end, after) in pairwise(references):
        # whenever the node had its turns: the speed changes over the way as an acceleration of 1 m/s² changes it
        way = math.hypot(end.x - start.x, end.y - start.y)
        assert abs(after * after - before * before) <= 2.0 * 1.02 * way + 1e-6, (start, end, before, after)
