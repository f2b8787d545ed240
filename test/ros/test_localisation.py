"""Paths and curves in the frame of a localisation, which corrects itself on /tf: in lockstep and on the wall clock."""

import json
import math
import random
import statistics
from itertools import pairwise

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TransformStamped
from helpers import interfaces, stand_in_base
from helpers.agreeing import assert_agree, configured
from helpers.harness import CONFIG, driven
from helpers.replaying import courses, replay, start
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile

from mobile_robot_control.messages.writing import path_message, planar_quaternion
from mobile_robot_control.quantities import Pose
from mobile_robot_control.reference.localisation import composed, inverse
from mobile_robot_control.ros.shared.run_events import KEPT
from mobile_robot_control.runs.bag import read_bag
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import course_of

LIMITS = ('timing.max_linear_velocity:=0.4', 'timing.max_linear_acceleration:=0.4', 'timing.max_angular_velocity:=1.2',
          'timing.max_angular_acceleration:=2.5')
WAY = [(0.0, 0.0), (1.5, 0.0), (1.5, 1.0), (0.0, 1.0), (0.0, 2.0), (2.0, 2.0)]
SLALOM = [(0.1 * n, 0.5 * math.cos(0.15 * n) - 0.5) for n in range(100)]


def options(*given):
    return [word for one in given for word in ('-p', one)]


def transform(parent, child, pose, stamp=0):
    """Return a stamped transform [ns]."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
    message.transform.translation.x, message.transform.translation.y = float(pose.x), float(pose.y)
    message.transform.rotation.z, message.transform.rotation.w = planar_quaternion(pose.heading)
    return message


@pytest.fixture
def tf(robot):
    """Functions that publish transforms on /tf and on /tf_static, as real messages."""
    kind = interfaces.need('tf2_msgs').TFMessage
    moving, static = (robot.recorder.create_publisher(kind, topic, QoSProfile(depth=100, durability=durability))
                      for topic, durability in (('/tf', DurabilityPolicy.VOLATILE),
                                                ('/tf_static', DurabilityPolicy.TRANSIENT_LOCAL)))

    def publish(*transforms, is_static=False):
        publisher = static if is_static else moving
        publisher.publish(kind(transforms=list(transforms)))

    publish.subscribers = moving.get_subscription_count
    return publish


@pytest.mark.parametrize('given', [
    ['reference_cart.curve:=path', *(f'reference_cart.{one}' for one in LIMITS),
     'reference_cart.localisation.drift:=0.02', 'reference_cart.localisation.rate:=10.0',
     '/**.reference_horizon:=1', '/**.feedforward.enabled:=true'],
    ['reference_cart.localisation.rate:=0.5', 'reference_cart.localisation.jump:=0.1',
     'reference_cart.localisation.turn:=0.05'],
], ids=['path', 'curve'])
def test_nodes_and_simulate_follow_drawn_corrections_alike(domain, tmp_path, given):
    (tmp_path / 'way.csv').write_text('x,y\n' + '\n'.join(f'{x},{y}' for x, y in WAY))
    file = [f'reference_cart.path.file:={tmp_path}/way.csv'] if 'path' in given[0] else []
    configuration, arguments = configured(tmp_path, 5, [], ['/**.path_frame:=map', *given, *file])
    with driven(tmp_path / 'run', arguments) as robot:
        recording = robot.recording()
    assert_agree(recording, configuration, 5)
    ticks = {sample.tick.time: sample.tick.reference for sample in recording.samples}.values()
    assert max(math.dist(one.pose[:2], other.pose[:2]) for one, other in pairwise(ticks)) < 0.01


@pytest.mark.parametrize('seconds', [5.0, pytest.param(13.0, marks=pytest.mark.soak)])
def test_corrections_of_a_lockstep_run_are_replayed_to_the_last_bit(robot, tf, tmp_path, seconds):
    recorded, replayed = tmp_path / 'recorded', tmp_path / 'replayed'
    (tmp_path / 'way.csv').write_text('x,y\n' + '\n'.join(f'{x},{y}' for x, y in WAY))
    run = start(recorded, '--duration', seconds, *options(
        '/**.path_frame:=map', 'plant.drive:=velocity', '/**.velocity_rate:=100.0', '/**.position_rate:=50.0',
        'reference_cart.curve:=path', f'reference_cart.path.file:={tmp_path}/way.csv',
        *(f'reference_cart.{one}' for one in LIMITS)))
    corrections = []
    robot.recorder.create_subscription(DiagnosticArray, 'events', lambda message: corrections.extend(
        status.values[0].value for status in message.status if status.values[0].key == 'correction'), KEPT)
    # the run, which stands nearly still, has begun
    robot.spin_until(lambda: 'cmd_vel' in robot.recorder.newest and tf.subscribers())
    # through a frame between; noise of 2 mm, a step, and a transform of other frames
    tf(transform('mid', 'odom', Pose(0.5, 0.0, 0.3)), is_static=True)
    draw = random.Random(1)  # noqa: S311 (noise)
    for n in range(1, 101):
        jump = Pose(0.1, -0.05, 0.02) if n > 30 else Pose(0.0, 0.0, 0.0)
        moved = Pose(jump.x + draw.gauss(0.0, 0.002), jump.y + draw.gauss(0.0, 0.002), jump.heading)
        tf(transform('map', 'mid', moved, n * 50_000_000), transform('odom', 'base_link', moved, n * 50_000_000))
    # a goal in the map, behind the cart
    goals = robot.recorder.create_publisher(PoseStamped, 'goal_pose', 10)
    robot.spin_until(goals.get_subscription_count)
    goal = path_message('map', [Pose(0.5, 0.8, 1.5)]).poses[0]
    goal.header.frame_id, goal.header.stamp.sec = 'map', 3
    goals.publish(goal)
    goals.wait_for_all_acked()
    robot.listen(0.5)
    robot.set('plant', real_time_factor=0.0)
    _, error = run.communicate(timeout=120)
    assert run.returncode == 0, error
    robot.spin_until(lambda: len(corrections) >= 2)
    assert len(corrections) <= 3
    assert courses(recorded)[1] == len(corrections) + 1
    last = read_bag(recorded / 'bag').samples[-1].tick.reference
    end = composed(Pose(*json.loads(corrections[-1])), last.pose)
    assert seconds < 10.0 or end == pytest.approx((0.5, 0.8, 1.5), abs=0.03)
    replay(recorded, replayed, '--composed')
    assert courses(replayed) == courses(recorded)


class Localised:
    """A stand-in base, its localisation, and what is told of it: errors to the way in map, and references."""

    def __init__(self, robot, tf, every, jump=0.0, turn=0.0, noise=0.0):
        self.base, self._tf, self._every, self._by, self._noise = stand_in_base.Base(plain=False), tf, every, (
            jump, turn), noise
        self.correction, self._draw = Pose(0.3, -0.2, 0.5), random.Random(2)  # noqa: S311 (a test)
        self.silent, self.begun, self._due = False, None, 0.0
        self.base.frame = 'odom'
        self.base.x, self.base.y, self.base.heading = inverse(self.correction)
        robot.add(self.base)
        self.errors, self.references, self.jumps, self.states, self.plan = [], [], [], {}, []
        robot.recorder.create_subscription(Odometry, 'reference', self._note, 10)
        robot.recorder.create_subscription(DiagnosticArray, '/diagnostics', lambda message: self.states.update(
            {status.name.rpartition('/')[2]: status for status in message.status}), 10)
        self.base.create_timer(0.02, self._localise)

    @property
    def pose(self):
        """Of the robot in odometry."""
        return Pose(self.base.x, self.base.y, self.base.heading)

    def now(self):
        return self.base.get_clock().now().nanoseconds

    def move(self, jump, turn, way=None):
        """Correct the localisation about the robot, in a direction in the map, or in a drawn one."""
        here, drawn = composed(self.correction, self.pose), self._draw.uniform(-math.pi, math.pi)
        way = drawn if way is None else way
        there = Pose(here.x + jump * math.cos(way), here.y + jump * math.sin(way),
                     here.heading + self._draw.choice((-1.0, 1.0)) * turn)
        self.correction = composed(there, inverse(self.pose))

    def _localise(self):
        if self.begun is not None and self._every and (self.now() - self.begun) / 1e9 > self._due + self._every:
            self._due += self._every
            self.move(*self._by)
            self.jumps.append(self.now())
        if not self.silent:
            noisy = self.correction._replace(x=self.correction.x + self._draw.gauss(0.0, self._noise),
                                             y=self.correction.y + self._draw.gauss(0.0, self._noise))
            # AMCL dates its transforms ahead
            self.last = self.now() + 10**9
            self._tf(transform('map', 'odom', noisy, self.last))

    def _note(self, message):
        velocity = message.twist.twist
        if velocity.linear.x and self.begun is None:
            self.begun = self.now()
        self.references.append((velocity.linear.x, velocity.angular.z))
        here = composed(self.correction, self.pose)
        if not self.plan:
            return
        self.errors.append((self.now(), min(math.dist(here[:2], one.pose[:2]) for one in self.plan)))


PARAMETERS = """
/**: {{ros__parameters: {{path_frame: map, base_frame_id: base_footprint, odom_frame_id: odom}}}}
/**/reference_cart:
  ros__parameters:
    wait: true
    curve: path
    path.file: {folder}/way.csv
    localisation.timeout: {timeout}
    timing: {{max_linear_velocity: 0.4, max_linear_acceleration: 0.4, max_angular_velocity: 1.2,
              max_angular_acceleration: 2.5}}
"""


def launch(robot, folder, timeout=2.0):
    """Start controller and cart, whose path begins below the robot; return its plan."""
    (folder / 'way.csv').write_text('x,y\n' + '\n'.join(f'{x},{y}' for x, y in SLALOM))
    (folder / 'mine.yaml').write_text(PARAMETERS.format(folder=folder, timeout=timeout))
    robot.start('position_controller', 'reference_cart', composed=True, arguments=[
        '--params-file', str(CONFIG / 'wall_clock.yaml'), '--params-file', str(folder / 'mine.yaml')])
    plan = course_of(configure(load([CONFIG / 'wall_clock.yaml', folder / 'mine.yaml'])).reference_cart)
    return [plan.reference(n * 0.02) for n in range(round(plan.period / 0.02))]


def assert_within_limits(base):
    assert min(v for v, _ in base.references) >= 0.0
    # a joint may exceed a limit by 1 %
    assert max(v for v, _ in base.references) < 0.4 * 1.02
    assert max(abs(omega) for _, omega in base.references) < 1.2 * 1.02


def test_a_correction_about_the_robot_leads_the_cart_over_within_its_limits(robot, tf, tmp_path):
    base = Localised(robot, tf, 0.0)
    base.plan = launch(robot, tmp_path)
    for _ in range(2):
        robot.spin_until(lambda: base.references and base.references[-1][0] > 0.3)
        # across the path
        base.move(0.1, math.radians(3.0), 0.5 * math.pi)
        robot.spin_until(lambda: base.errors[-1][1] > 0.05)
        robot.spin_until(lambda: base.errors[-1][1] < 0.01)
    assert_within_limits(base)


@pytest.mark.soak
def test_from_two_seconds_after_each_correction_the_robot_is_on_its_path_in_the_map(robot, tf, tmp_path):
    base = Localised(robot, tf, 4.0, 0.1, math.radians(3.0))
    base.plan = launch(robot, tmp_path)
    robot.spin_until(lambda: base.begun and base.now() - base.begun > 14.5e9, 120.0)
    late = [error for at, error in base.errors if at > base.begun + 1e9 and all(
        not 0 <= at - jump < 2_000_000_000 for jump in base.jumps)]
    assert len(base.jumps) == 3
    assert math.sqrt(statistics.fmean(error**2 for error in late)) < 0.01
    assert max(late) < 0.03
    assert max(error for _, error in base.errors) < 0.1 + 0.02
    assert_within_limits(base)


@pytest.mark.soak
def test_noise_of_a_localisation_at_50_hz_does_not_swing_the_robot(robot, tf, tmp_path):
    base = Localised(robot, tf, 0.0, noise=0.005)
    base.plan = launch(robot, tmp_path)
    robot.spin_until(lambda: base.begun and base.now() - base.begun > 8e9, 60.0)
    swings = sum(abs(after - before) for (_, before), (_, after) in pairwise(base.references))
    assert swings < 1.2 * sum(abs(after.velocity.angular - before.velocity.angular) for before, after in pairwise(
        base.plan[:round((base.now() - base.begun) / 2e7)]))


def test_localisation_is_smoothed_its_loss_holds_the_cart_and_its_jump_stops_the_robot(robot, tf, tmp_path):
    base = Localised(robot, tf, 0.0, noise=0.005)
    base.plan = launch(robot, tmp_path, timeout=2.0)
    events = []
    robot.recorder.create_subscription(DiagnosticArray, 'events', lambda message: events.extend(
        status.values[0].key for status in message.status), KEPT)

    def drives():
        return base.references[-1][0] == pytest.approx(0.4, abs=0.01)

    robot.spin_until(lambda: base.begun and base.now() - base.begun > 6e9 and drives(), 60.0)
    # at most one a second; the first one places the path
    assert events.count('correction') <= 1 + 6
    base.silent = True
    robot.spin_until(lambda: base.references[-1][0] == 0.0)
    # within a second, not at once
    slowing = [v for v, _ in base.references[-100:] if 0.0 < v < 0.38]
    assert len(slowing) > 20
    robot.spin_until(lambda: 's old, and localisation.timeout is 2 s' in str(base.states['reference_cart']))
    base.silent = False
    robot.spin_until(drives)
    # another node has another opinion
    tf(transform('map', 'odom', base.correction, base.last), transform('map', 'odom', Pose(9.0, 9.0, 0.0), base.last))
    robot.spin_until(lambda: 'two values for one stamp' in str(base.states['reference_cart']))
    base.move(0.8, 0.0)
    robot.spin_until(lambda: 'the localisation has moved the robot by 0.' in str(base.states['position_controller']))
    robot.spin_until(lambda: abs(base.base.v) < 1e-3)
    assert robot.trigger('position_controller/release')[0]
    robot.spin_until(lambda: base.base.v > 0.1)
