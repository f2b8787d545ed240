"""The cart of the wall clock in drawn sequences of goals, paths and stops: it moves only for what is still asked."""

import contextlib
import math
import random
import types
from collections import Counter
from concurrent.futures import Future

import pytest
import rclpy
from geometry_msgs.msg import TransformStamped
from helpers import interfaces
from helpers.harness import CONFIG
from nav_msgs.msg import Path
from rclpy.serialization import serialize_message
from std_msgs.msg import String

from mobile_robot_control.messages.writing import path_message, planar_quaternion
from mobile_robot_control.quantities import BodyVelocity, Pose
from mobile_robot_control.reference.localisation import composed
from mobile_robot_control.ros.cart import cart_paths, modes
from mobile_robot_control.ros.cart.path_planning import answer, planned
from mobile_robot_control.ros.cart.reference_cart import ReferenceCart
from mobile_robot_control.ros.shared import clock
from mobile_robot_control.ros.shared.stamp_policy import Inputs
from mobile_robot_control.topics import CORRECTION

TICK = 0.02
SPEED, DECELERATION = 0.5, 1.0
REACTION = 0.2
"""[s] that a stop may take in addition to the shortest one that the planner finds."""
PARAMETERS = f"""
/**/reference_cart:
  ros__parameters:
    curve: path
    goal.timeout: 3.0
    path.planning_time: 4.0
    timing: {{max_linear_velocity: {SPEED}, max_linear_acceleration: {DECELERATION}, max_angular_velocity: 2.0,
             max_angular_acceleration: 8.0}}
"""
STOP = serialize_message(Path())


def transform(parent, child, pose, stamp):
    """Return a stamped transform [ns]."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id, message.header.stamp.nanosec = parent, stamp
    message.transform.translation.x, message.transform.translation.y = pose.x, pose.y
    message.transform.rotation.z, message.transform.rotation.w = planar_quaternion(pose.heading)
    return message


class Goal:
    """The server's handle of a goal, as rclpy gives it to the action."""

    def __init__(self, path):
        self.request, self.is_cancel_requested, self.ended = types.SimpleNamespace(path=path), False, ''
        self.publish_feedback = lambda _: None

    def succeed(self):
        self.ended = 'succeeded'

    def abort(self):
        self.ended = 'aborted'

    def canceled(self):
        self.ended = 'canceled'


class Sequence:
    """A cart on a clock of its own, planning that takes drawn times, and a robot that is at the cart or stopped."""

    def __init__(self, monkeypatch, seed, takes=(0.05, 0.05, 0.4, 1.5, 3.0, 10.0)):
        self.now, self._draw, self._takes = 100.0, random.Random(seed), takes  # noqa: S311 (a test)
        fake = types.SimpleNamespace(monotonic=lambda: self.now, monotonic_ns=lambda: round(self.now * 1e9))
        monkeypatch.setattr(clock, 'time', fake)
        monkeypatch.setattr(cart_paths, 'time', fake)
        monkeypatch.setattr(modes, 'time', fake)
        self.node = ReferenceCart()
        self.node.paths._planning._process.close()
        self.node.paths._planning._process = types.SimpleNamespace(
            ask=self._ask, drop=self._drop, kill_suspended=lambda: False, close=lambda: None)
        self._planning, self.pose, self.is_stopped = None, Pose(0.5, -0.3, 0.4), False
        self.goals, self.asked, self.ended_at, self._shortest, self.driven = [], None, 0.0, 0.0, 0.0
        take = self.node.paths._take
        monkeypatch.setattr(self.node.paths, '_take', lambda due: self._note(take, due))
        self.node.begin_run(self._inputs(), False)

    def _note(self, take, due):
        shortest = self._shortest_stop()
        take(due)
        if (due.answer.stops or due.answer.refusal) and not self.node.paths.plans() and self.ended_at is None:
            self.ended_at, self._shortest = self.now, shortest

    def end(self):
        """Note that nothing is asked from now on."""
        self.ended_at, self._shortest = self.now, self._shortest_stop()

    def _shortest_stop(self):
        """Return the duration of the shortest stop from now on, as the planner finds it [s]."""
        now = self.node.now
        stop = answer(self.node.course.question(STOP, now)).planned
        return stop.period if stop else 0.0

    def _ask(self, question):
        assert self._planning is None
        self._planning = Future(), question, self.now + self._draw.choice(self._takes)
        return self._planning[0]

    def _drop(self):
        self._planning = None

    def _inputs(self):
        stamp = round(self.now * 1e9)
        return Inputs(stamp, {'odom': (stamp, (self.pose, BodyVelocity(0.0, 0.0)))}, lambda _: 0.0)

    def tick(self):
        """Go on by a tick, and assert that a cart of which nothing is asked stands in time."""
        self.now += TICK
        if self._planning and self.now >= self._planning[2]:
            future, question, _ = self._planning
            self._planning = None
            future.set_result(planned(question))
        self.node.monitor._taken_at['odom'] = self.now
        self.node.receive('odom', 0, (self.pose, BodyVelocity(0.0, 0.0)))
        cart = self.node.step(self._inputs(), TICK)['reference']
        self.node.note_step(round(self.now * 1e9))
        before = self.pose
        if not self.is_stopped:
            self.pose = cart.pose
            self.driven += math.dist(before[:2], self.pose[:2])
        if self.ended_at is None and self.goals and self.asked is self.goals[-1] and self.asked.ended:
            self.end()
        if self.ended_at is not None and self.now > self.ended_at + self._shortest + REACTION:
            assert not any(cart.velocity), f'{cart.velocity} {self.now - self.ended_at:.2f} s after the end'
            # nor does a release move the robot
            assert self.is_stopped or math.dist(cart.pose[:2], before[:2]) < 0.001

    def drive(self, seconds):
        for _ in range(round(seconds / TICK)):
            self.tick()

    def path(self):
        """Draw a path: from the robot on, or too far away."""
        away = self._draw.choice([0.0, 0.0, 0.0, 9.0])
        points = [Pose(away, 0.0, 0.0), Pose(away + self._draw.uniform(0.5, 1.0), self._draw.uniform(-0.3, 0.3), 0.0),
                  Pose(away + self._draw.uniform(1.5, 4.0), self._draw.uniform(-0.6, 0.6), 0.0)]
        return path_message('odom', [composed(self.node.reference.pose, one) for one in points])

    def act(self):
        """Do something drawn, and go on for a drawn time."""
        getattr(self, self._draw.choice([
            'send_goal', 'send_goal', 'send_path', 'send_path', 'cancel', 'cancel', 'send_stop', 'stop_robot',
            'release', 'release']))()
        self.drive(self._draw.choice([0.02, 0.3, 1.0, 12.0]))

    def send_goal(self):
        goal = Goal(self.path() if self._draw.random() < 0.9 else path_message('odom', []))
        self.goals.append(goal)
        self.asked, self.ended_at = goal, None
        self._running = self.node.goals._execute(goal)
        with contextlib.suppress(StopIteration):  # one that is refused at once
            self._running.send(None)

    def send_path(self):
        self.asked, self.ended_at = 'path', None
        self.node.paths.receive(serialize_message(self.path()))

    def send_stop(self):
        self.asked = None
        self.end()
        self.node.paths.receive(STOP)

    def cancel(self):
        if self.goals and not self.goals[-1].ended:
            self.goals[-1].is_cancel_requested = True
            if self.asked is self.goals[-1]:
                self.end()

    def stop_robot(self):
        self.is_stopped = True
        self.node.robot.note_stop(String(data='by a call of stop'))

    def release(self):
        self.is_stopped = False
        self.node.robot.note_stop(String(data=''))


@contextlib.contextmanager
def started(folder, parameters):
    """Start rclpy with parameters of the wall clock."""
    (folder / 'mine.yaml').write_text(parameters)
    rclpy.init(args=['--ros-args', '--params-file', str(CONFIG / 'wall_clock.yaml'),
                     '--params-file', str(folder / 'mine.yaml')])
    try:
        yield
    finally:
        rclpy.shutdown()


def test_a_standing_cart_takes_the_newest_correction_for_its_next_path(domain, tmp_path, monkeypatch):
    with started(tmp_path, PARAMETERS + '/**: {ros__parameters: {path_frame: map}}'):
        cart = Sequence(monkeypatch, 1, takes=[0.05])
        node = cart.node
        # the second one as by "2D Pose Estimate", beside a cart at the end of its path
        for stamp, correction in enumerate([Pose(0.2, 0.1, 0.0), Pose(1.7, -0.4, 0.5)]):
            node.corrections._input._receive(CORRECTION, serialize_message(transform('map', 'odom', correction, stamp)))
            cart.drive(1.5)
            before = cart.pose
            ahead = [composed(correction, composed(before, Pose(x, 0.0, 0.0))) for x in (0.0, 0.5, 1.0)]
            cart.asked, cart.ended_at = 'path', None
            node.paths.receive(serialize_message(path_message('map', ahead)))
            cart.drive(13.0)
            assert composed(correction, cart.pose)[:2] == pytest.approx(ahead[-1][:2], abs=0.01)
        node.destroy_node()


@pytest.mark.parametrize('count', [8, pytest.param(500, marks=[pytest.mark.soak, pytest.mark.timeout(1800)])])
def test_a_cart_moves_only_for_a_goal_or_a_path_that_is_still_asked(domain, tmp_path, monkeypatch, count):
    interfaces.need('nav2_msgs', 'action')
    ended, driven = Counter(), 0
    with started(tmp_path, PARAMETERS):
        for seed in range(count):
            with monkeypatch.context() as patch:
                sequence = Sequence(patch, seed)
                for _ in range(12):
                    sequence.act()
                sequence.drive(14.0)
                ended.update(goal.ended for goal in sequence.goals)
                driven += sequence.driven
                sequence.node.destroy_node()
    # the sequences try what they are about
    assert min(ended[how] for how in ('succeeded', 'aborted', 'canceled')) >= count / 20
    assert driven > count
