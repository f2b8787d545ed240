"""What changes a run is published with the first stamp that it affects; curve, placement and pace change live."""

import json
import math
import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from helpers.harness import CONFIG, PERIOD
from helpers.watching import stamp_nanoseconds
from nav_msgs.msg import Path

from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.ros.shared.qos import LATCHED
from mobile_robot_control.ros.shared.run_events import KEPT
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

FILE = CONFIG / 'backstepping.yaml'
QUICK = ['--params-file', str(FILE), '-p', 'real_time_factor:=0.0', '-p', 'paused:=true']
TICK = 5 * PERIOD


class Seen:
    """All events, those from before the subscription too: each message with its stamp and its changes."""

    def __init__(self, robot):
        self.messages = []
        robot.recorder.create_subscription(DiagnosticArray, 'events', self._on_events, KEPT)

    def _on_events(self, message):
        changes = {status.values[0].key: json.loads(status.values[0].value) for status in message.status}
        name, run = {(status.name, status.values[1].value) for status in message.status}.pop()
        self.messages.append((name, int(run), stamp_nanoseconds(message.header.stamp), changes))

    def of(self, node):
        return [rest for name, *rest in self.messages if name == node]


def _set(robot, node, **values):
    for result in robot.set(node, **values):
        assert result.successful, result.reason


def test_a_change_is_published_with_its_first_stamp_and_one_of_the_curve_with_a_new_run(robot):
    robot.start(arguments=[*QUICK, '-p', 'hold_at:=0.1', '-p', 'duration:=0.3'], composed=True)
    robot.spin_until(robot.recorder.has_every_topic)
    # before the first step as well, a pose is that of the next run, and no change of this one
    _set(robot, 'plant', initial_pose=[0.9, 0.0, 1.5])
    _set(robot, 'plant', paused=False)
    robot.wait_at(0.1)
    _set(robot, 'velocity_controller', gains__k1=0.25)
    _set(robot, 'position_controller', controller_type='fuzzy', fuzzy__a=0.5)
    _set(robot, 'reference_cart', period=8.0)
    _set(robot, 'reference_cart', curve='circle', scale=0.5)
    _set(robot, 'plant', initial_pose=[0.5, 0.1, 1.5], hold_at=0.2)
    robot.wait_at(0.2)
    assert robot.trigger('plant/reset')[0]
    robot.spin_until(lambda: robot.log().count('a new run begins') == 4)
    # late subscribers receive all of them
    seen, paths = Seen(robot), []
    robot.recorder.create_subscription(Path, 'reference_path', paths.append, LATCHED)
    robot.spin_until(lambda: len(seen.messages) == 6 and paths)
    first = 100_000_000 + TICK
    assert seen.of('velocity_controller') == [[0, first, {'gains.k1': 0.25}]]
    assert seen.of('position_controller') == [[0, first, {'controller_type': 'fuzzy', 'fuzzy.a': 0.5}]]
    assert seen.of('reference_cart') == [[0, first, {'period': 8.0}], [1, 0, {'curve': 'circle', 'scale': 0.5}]]
    assert seen.of('plant') == [[0, 200_000_000 + PERIOD, {'reset': [0.5, 0.1, 1.5]}],
                                [1, 0, {'initial_pose': [0.5, 0.1, 1.5]}]]
    assert max(pose.pose.position.x for pose in paths[-1].poses) == pytest.approx(0.5)
    robot.release()
    recording = robot.recording()
    chosen = configure(load([FILE], [
        'velocity_controller.gains.k1:=0.25', 'position_controller.controller_type:=fuzzy',
        'position_controller.fuzzy.a:=0.5', 'reference_cart.period:=8.0', 'reference_cart.curve:=circle',
        'reference_cart.scale:=0.5', 'plant.initial_pose:=[0.5, 0.1, 1.5]']))
    simulated = list(rollout(chosen, 0.3))
    assert len(recording.samples) == len(simulated)
    for ours, theirs in zip(recording.samples, simulated, strict=True):
        assert ours.torque == pytest.approx(theirs.torque, rel=1e-9, abs=1e-9)


def test_with_another_lap_time_the_cart_goes_on_where_it_is_whatever_the_pace_was(robot):
    robot.start(arguments=[*QUICK, '-p', 'hold_at:=0.5', '-p', 'duration:=1.0'], composed=True)
    robot.spin_until(robot.recorder.has_every_topic)
    # as slow as can be, and then as fast as it goes
    _set(robot, 'plant', paused=False, real_time_factor=1e-6)
    _set(robot, 'plant', real_time_factor=0.0)
    robot.wait_at(0.5)
    _set(robot, 'reference_cart', period=4.0)
    robot.release()
    assert 'refused' not in robot.log()
    recording = robot.recording()
    assert not recording.problems
    ticks = {sample.time: sample.tick.reference for sample in recording.samples if sample.tick.time == sample.time}
    before, at, after = ticks[0.49], ticks[0.5], ticks[0.51]
    assert at.velocity.linear == pytest.approx(before.velocity.linear, rel=0.01)
    assert after.velocity.linear == pytest.approx(4.0 * before.velocity.linear, rel=0.05)
    assert math.hypot(after.pose.x - at.pose.x, after.pose.y - at.pose.y) == pytest.approx(
        0.01 * after.velocity.linear, rel=0.05)
    cart = configure(load([FILE])).reference_cart.curve
    # half a second of a lap of 16 s is an eighth of one of 4 s
    assert ticks[1.0].pose == pytest.approx(
        reference_at(CURVES[cart.curve], 0.625, cart.placement._replace(period=4.0)).pose)


def test_on_the_wall_clock_a_cart_that_waits_begins_anew_and_another_does_not_jump(robot):
    robot.start(arguments=['--params-file', str(CONFIG / 'wall_clock.yaml')], composed=True)
    seen = Seen(robot)
    robot.spin_until(robot.recorder.has_every_topic)
    _set(robot, 'reference_cart', curve='circle', center=[3.0, 0.0])
    robot.spin_until(lambda: seen.of('reference_cart'))
    (_, stamp, changes), = seen.of('reference_cart')
    assert changes == {'curve': 'circle', 'center': [3.0, 0.0]}
    assert stamp > 10**18
    robot.spin_until(lambda: 'the cart waits: the robot is not at the start' in robot.log())
    assert robot.trigger('position_controller/stop')[0]
    assert robot.trigger('position_controller/release')[0]
    robot.spin_until(lambda: len(seen.of('position_controller')) == 2)
    assert [list(changes) for *_, changes in seen.of('position_controller')] == [['stop'], ['release']]
    # a push acts in the next step of the plant, if its stamp is 0 or near enough to now
    publisher = robot.recorder.create_publisher(WrenchStamped, 'disturbance', 10)
    push = WrenchStamped()
    push.wrench.force.x = 2.0
    begun = time.time_ns()
    robot.spin_until(lambda: publisher.publish(push) or seen.of('plant'))
    _, stamp, changes = seen.of('plant')[0]
    assert changes['disturbance'][0] % 2.0 == 0.0
    assert begun - 10**9 < stamp < time.time_ns() + 10**9
    push.header.stamp.sec = 1
    robot.spin_until(lambda: publisher.publish(push) or 'on disturbance: stamp too old' in robot.log())


def test_on_the_wall_clock_a_cart_that_does_not_wait_keeps_its_curve(robot):
    robot.start('plant', 'reference_cart', composed=True, arguments=[
        '--params-file', str(CONFIG / 'wall_clock.yaml'), '-p', 'reference_cart:wait:=false'])
    robot.spin_until(lambda: 'reference_cart]: a run begins' in robot.log())
    result, = robot.set('reference_cart', scale=0.25)
    assert not result.successful
    assert 'the cart would jump' in result.reason
    _set(robot, 'reference_cart', period=40.0)
