"""Paths on the wall clock: each planned one is followed, whatever the planner's pace, and the newest one comes next."""

import math
import os
import signal
import time
import types
from collections import Counter
from concurrent.futures import Future
from itertools import pairwise

import pytest
from nav_msgs.msg import Path
from rclpy.serialization import serialize_message

from mobile_robot_control.messages.parsing import has_no_poses
from mobile_robot_control.messages.writing import path_message
from mobile_robot_control.quantities import Pose
from mobile_robot_control.ros.cart import cart_paths, planning_process
from mobile_robot_control.ros.cart.cart_course import CartCourse
from mobile_robot_control.ros.cart.cart_paths import WallClockPaths
from mobile_robot_control.ros.cart.path_planning import answer
from mobile_robot_control.ros.cart.planning_process import PlanningProcess
from mobile_robot_control.settings.nodes import ReferenceCartParameters

TICK = 0.01
STOP = serialize_message(Path())


def straight_on(course, time, length=3.0):
    """Return a message with a path from the cart's place at a time [s] along its heading."""
    x, y, heading = course.reference(time).pose
    return serialize_message(path_message('odom', [
        Pose(x + way * math.cos(heading), y + way * math.sin(heading), 0.0) for way in (0.0, 0.5 * length, length)]))


def standing():
    """Return the course of a cart that stands at the origin until its first path."""
    cart = ReferenceCartParameters()
    return CartCourse(cart._replace(
        curve=cart.curve._replace(curve='path'), path=cart.path._replace(join_distance=0.4),
        timing=cart.timing._replace(max_linear_velocity=0.5, max_linear_acceleration=1.0)), 10_000_000)


class Cart:
    """A cart and its planning process, whose answers take a time [s]; `now` is their clock, also the course's."""

    def __init__(self, monkeypatch, takes):
        self.now, self.waits, self.counted, self.taken, self._takes = 0.0, False, Counter(), [], takes
        self.course, self._asked, self.limit, self.refused = standing(), None, 10.0, []
        monkeypatch.setattr(cart_paths, 'time', types.SimpleNamespace(monotonic=lambda: self._steady))
        self._steady = 0.0
        clock = types.SimpleNamespace(now=lambda: self.now, condition=lambda: self.waits or None)
        validator = types.SimpleNamespace(
            note_refusal=lambda topic, refusal, every: self.counted.update([refusal.reason]))
        self.paths = WallClockPaths(self.course, clock, None, validator, lambda: self.limit)
        self.paths._process = types.SimpleNamespace(ask=self._ask, drop=self._drop, kill_suspended=lambda: False)

    def _ask(self, question):
        assert self._asked is None
        self._asked = Future(), answer(question), self._steady + self._takes
        return self._asked[0]

    def _drop(self):
        self._asked = None

    def tick(self):
        """Go on by a tick; a path begins on the way, without a jump."""
        self._steady = round(self._steady + TICK, 6)
        self.now = self.now if self.waits else round(self.now + TICK, 6)
        if self._asked and self._steady >= self._asked[2]:
            future, found, _ = self._asked
            self._asked = None
            future.set_result(found)
        due = self.paths.due(0)
        if due is not None:
            before = self.course.reference(self.now)
            if due.answer.stops:
                self.refused.extend(due.answer.refusal)
                self.course.slow_down(due.begins, 1.0)
            else:
                assert not due.answer.refusal
                self.course.take(due.answer, due.begins)
            after = self.course.reference(self.now)
            assert math.dist(before.pose[:2], after.pose[:2]) < 0.01
            assert after.velocity.linear == pytest.approx(before.velocity.linear, abs=0.02)
            self.taken.append(self._steady)

    def drive(self, seconds):
        """Tick for a time [s]."""
        for _ in range(round(seconds / TICK)):
            self.tick()


@pytest.mark.parametrize(('takes', 'period'), [
    (takes, period) for takes in (0.03, 0.15, 0.9) for period in (0.05, 0.5, 1.0, 3.0)
])
def test_a_cart_follows_a_planner_at_any_pace_and_counts_the_paths_that_were_overtaken(takes, period):
    with pytest.MonkeyPatch.context() as monkeypatch:
        cart, sent = Cart(monkeypatch, takes), 0
        for tick in range(1200):
            if tick % round(period / TICK) == 0:
                cart.paths.receive(straight_on(cart.course, cart.now))
                sent += 1
            cart.tick()
    # one path at least in the time from a question to the start, and until the next message
    longest = 2.0 * max(0.5, 2.0 * takes) + period
    times = [0.0, *cart.taken, 12.0]
    assert max(later - earlier for earlier, later in pairwise(times)) < longest + 0.1
    # the last ones wait, are planned or begin soon
    assert 0 <= sent - len(cart.taken) - cart.counted['overtaken'] <= 2
    assert (cart.counted['overtaken'] > 3) == (period < max(0.2, 2.0 * takes))


@pytest.mark.parametrize('takes', [0.1, 60.0])
def test_a_stop_acts_at_the_next_tick_whatever_is_planned(takes):
    with pytest.MonkeyPatch.context() as monkeypatch:
        cart = Cart(monkeypatch, 0.1)
        cart.paths.receive(straight_on(cart.course, 0.0, 6.0))
        cart.drive(2.0)
        cart._takes = takes
        cart.paths.receive(straight_on(cart.course, cart.now))
        cart.drive(0.14)
        at = cart.course.reference(cart.now)
        assert at.velocity.linear == pytest.approx(0.5)
        cart.paths.receive(STOP)
        # 0.5 m/s at 1 m/s²
        cart.drive(0.5 + 2.0 * TICK)
        stands = cart.course.reference(cart.now)
        assert stands.velocity == (0.0, 0.0)
        assert math.dist(at.pose[:2], stands.pose[:2]) == pytest.approx(0.125, abs=2.0 * 0.5 * TICK)
        cart.drive(2.0 * takes if takes < 1.0 else 12.0)
    assert len(cart.taken) == 2
    assert cart.course.reference(cart.now).pose == stands.pose
    assert cart.course.state(round(cart.now * 1e9), Pose(0.0, 0.0, 0.0)) == 'standing'


def test_a_plan_at_its_limit_stops_the_cart_by_name_and_the_next_path_is_driven():
    with pytest.MonkeyPatch.context() as monkeypatch:
        cart = Cart(monkeypatch, 0.1)
        cart.paths.receive(straight_on(cart.course, 0.0, 12.0))
        cart.drive(2.0)
        cart._takes, cart.limit = 60.0, 3.0
        cart.paths.receive(straight_on(cart.course, cart.now))
        cart.drive(4.0)
        assert cart.course.reference(cart.now).velocity == (0.0, 0.0)
        assert cart.refused[0] == 'not planned'
        assert 'path.planning_time = 3 s' in cart.refused[1]
        cart._takes = 0.1
        cart.paths.receive(straight_on(cart.course, cart.now))
        cart.drive(2.0)
    assert cart.course.reference(cart.now).velocity.linear > 0.3


def test_a_path_may_begin_while_the_cart_slows_down():
    with pytest.MonkeyPatch.context() as monkeypatch:
        cart = Cart(monkeypatch, 0.1)
        cart.paths.receive(straight_on(cart.course, 0.0, 6.0))
        cart.drive(2.0)
        cart.paths._lead = 0.2
        cart.paths.receive(STOP)
        cart.drive(0.02)
        cart.paths.receive(straight_on(cart.course, cart.now))
        # the ticks assert that nothing jumps
        cart.drive(0.3)
        assert 0.1 < cart.course.reference(cart.now).velocity.linear < 0.45
        cart.drive(1.0)
    assert cart.course.reference(cart.now).velocity.linear > 0.4


@pytest.mark.parametrize('in_planning', [True, False])
def test_a_stop_overtakes_a_path_that_is_planned_or_begins_soon(in_planning):
    with pytest.MonkeyPatch.context() as monkeypatch:
        cart = Cart(monkeypatch, 0.1)
        cart.paths.receive(straight_on(cart.course, 0.0, 6.0))
        for _ in range(200):
            cart.tick()
        cart.paths.receive(straight_on(cart.course, cart.now))
        for _ in range(3 if in_planning else 14):
            cart.tick()
        cart.paths.receive(STOP)
        for _ in range(45):
            cart.tick()
    assert len(cart.taken) == 2
    assert not cart.counted
    assert cart.course.state(round((cart.now + 1.0) * 1e9), Pose(0.0, 0.0, 0.0)) == 'standing'


def test_a_cart_that_waits_for_its_robot_takes_a_newer_path():
    with pytest.MonkeyPatch.context() as monkeypatch:
        cart = Cart(monkeypatch, 0.1)
        cart.paths.receive(straight_on(cart.course, 0.0, 6.0))
        for _ in range(200):
            cart.tick()
        cart.paths.receive(straight_on(cart.course, cart.now))
        for _ in range(14):
            cart.tick()
        cart.waits = True
        cart.paths.receive(straight_on(cart.course, cart.now))
        for _ in range(14):
            cart.tick()
    assert len(cart.taken) == 2


def test_a_path_after_a_change_of_the_limits_is_planned_anew():
    course = standing()
    message = straight_on(course, 0.0, 6.0)
    course.take(answer(course.question(message, 0)), 0)
    assert not course.question(message, 10_000_000).anew
    cart = course._cart
    course.change(cart._replace(timing=cart.timing._replace(max_linear_velocity=0.3)), 1.0)
    changed = course.question(message, 10**9)
    assert changed.anew
    assert not answer(changed).goes_on


def test_an_empty_path_is_told_from_others_without_reading_it():
    full = straight_on(standing(), 0.0)
    assert has_no_poses(STOP)
    for frame in ('', 'a', 'odom', 'robot/odom'):
        message = path_message(frame, [])
        assert has_no_poses(serialize_message(message))
    for message in (full, full[:40], STOP[:8], b'', b'\0'):
        assert not has_no_poses(message)


def test_a_suspended_planning_process_is_replaced_with_a_word(monkeypatch):
    monkeypatch.setattr(planning_process, '_PATIENCE', 0.2)
    logged, course = [], standing()
    log = types.SimpleNamespace(warning=logged.append)
    paths = WallClockPaths(course, types.SimpleNamespace(now=lambda: 0.0, condition=lambda: None),
                           types.SimpleNamespace(get_logger=lambda: log), None, lambda: 60.0)
    process = paths._process = PlanningProcess()
    try:
        os.kill(process._process.pid, signal.SIGSTOP)
        # more than a pipe holds
        x = [Pose(0.001 * n, 0.0, 0.0) for n in range(3000)]
        paths.receive(serialize_message(path_message('odom', x)))
        due, until = None, time.monotonic() + 60.0
        while due is None and time.monotonic() < until:
            due = paths.due(0)
    finally:
        paths.close()
    assert due is not None
    assert not due.answer.refusal
    assert logged == ['the process that plans paths was suspended: another one takes its place']
