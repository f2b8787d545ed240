"""A planner that sends a plan on a grid once a second: each is taken or changes nothing, and the robot stays near."""

import math

import numpy as np
import pytest
from helpers.harness import CONFIG
from helpers.planner import ALPHA, OMEGA, ROUTE, STARTS, A, V, across, plan_from
from helpers.stand_in_model import Base, drive
from rclpy.serialization import serialize_message

from mobile_robot_control.control import bumpless_transfer
from mobile_robot_control.control.compensation import carried_forward
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.messages.writing import path_message
from mobile_robot_control.quantities import BodyVelocity, Observation, Pose
from mobile_robot_control.ros.cart.cart_course import CartCourse
from mobile_robot_control.ros.cart.path_planning import answer
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

PARAMETERS = configure(load([CONFIG / 'wall_clock.yaml'], [
    'reference_cart.curve:=path', f'reference_cart.timing.max_linear_velocity:={V}',
    f'reference_cart.timing.max_linear_acceleration:={A}', f'reference_cart.timing.max_angular_velocity:={OMEGA}',
    f'reference_cart.timing.max_angular_acceleration:={ALPHA}']))
BASE = Base(dead_zone=0.0)
RATE = 50.0
SECONDS = 26.0


class Cart:
    """Cart and position law on the plans of a planner; `plans` between two new ones, or a single one."""

    def __init__(self, start, every=1.0, plan=plan_from):
        self._every, self._plan, self._next = every, plan, 0.0
        self.course = CartCourse(PARAMETERS.reference_cart, round(1e9 / RATE))
        self.course.begin_course(PARAMETERS.reference_cart, Pose(*start))
        self._law = bumpless_transfer.begin_law(PARAMETERS.position_controller.control, 1.0 / RATE, under_way=False)
        self.commands, self.answers, self.references = [], [], []

    def __call__(self, time, stamp, pose, velocity):
        seen, velocity = Pose(*pose), BodyVelocity(*velocity)
        if time >= self._next:
            self._next = self._next + self._every
            points = self._plan(seen.x, seen.y)
            message = serialize_message(path_message('odom', [Pose(*point, 0.0) for point in points.tolist()]))
            at = round(time * 1e9)
            found = answer(self.course.question(message, at))
            self.course.take_answer(found, at)
            self.answers.append(found)
        reference = self.course.reference(time)
        error = tracking_error(reference.pose, carried_forward(seen, velocity, time - stamp))
        seen = Observation(error, reference, velocity)
        self._law, command = bumpless_transfer.step(self._law, seen, 1.0 / RATE, None)
        self.commands.append(command)
        self.references.append(reference)
        return command


class Pursuit:
    """A regulated pure pursuit with the same limits; see Macenski et al., 2023."""

    def __init__(self, every=1.0):
        self._every, self._next, self._points = every, 0.0, None
        self._v = self._omega = 0.0
        self.commands = []

    def __call__(self, time, _stamp, pose, _velocity):
        x, y, heading = pose
        if time >= self._next:
            self._next, self._points = self._next + self._every, plan_from(x, y)
        ranges = np.hypot(self._points[:, 0] - x, self._points[:, 1] - y)
        ahead = min(max(1.5 * self._v, 0.3), 0.9)
        first = int(np.argmin(ranges))
        farther = [n for n in range(first, len(ranges)) if ranges[n] >= ahead]
        tx, ty = self._points[farther[0] if farther else -1]
        along = math.cos(heading) * (tx - x) + math.sin(heading) * (ty - y)
        aside = math.cos(heading) * (ty - y) - math.sin(heading) * (tx - x)
        bend = 2.0 * aside / max(along * along + aside * aside, 1e-6)
        left = math.dist((x, y), self._points[-1])
        v = V * min(1.0, 1.0 / max(1e-9, abs(bend) * 0.9)) * min(1.0, max(left / 0.6, 0.1))
        v = 0.0 if left < 0.02 else v
        omega = max(-OMEGA, min(OMEGA, v * bend))
        self._v += max(-A / RATE, min(A / RATE, v - self._v))
        self._omega += max(-ALPHA / RATE, min(ALPHA / RATE, omega - self._omega))
        self.commands.append((self._v, self._omega))
        return self._v, self._omega


def driven(control, start):
    """Return the time of arrival, the RMS distance from the route, Σ|Δω| a second, and the distance of the end."""
    truth = drive(BASE, control, start, SECONDS)
    places = np.array([pose[:2] for _, pose in truth])
    left = np.hypot(*(places - ROUTE[-1]).T)
    arrived = next((n for n in range(len(left)) if (left[n:] < 0.05).all()), len(left) - 1)
    omega = np.array([command[1] for command in control.commands[:arrived + 1]])
    rough = np.abs(np.diff(omega)).sum() / truth[arrived][0]
    return truth[arrived][0], math.sqrt((across(places[:arrived + 1])**2).mean()), rough, left[-1]


def test_plans_once_a_second_are_followed_closer_than_a_pursuit_does():
    shares = []
    for start in STARTS:
        cart = Cart(start)
        time, error, rough, end = driven(cart, start)
        latest, pursuits, *_ = driven(Pursuit(), start)
        assert time <= latest
        assert end < 0.02
        shares.append(error / pursuits)
        # the first plan is taken, and none changes the motion without need: it is as smooth as on that one alone
        first, *others = cart.answers
        assert not first.refusal
        assert not first.goes_on
        assert all(one.goes_on and not one.refusal for one in others)
        moving = next(n for n, command in enumerate(cart.commands) if abs(command.linear) > 0.02)
        assert moving / RATE < 1.0
        assert rough <= 1.3 * driven(Cart(start, every=math.inf), start)[2]
    assert max(shares) < 0.7
    assert sum(shares) / len(shares) < 0.6


@pytest.mark.parametrize('change', ['end', 'detour'])
def test_the_next_plan_acts_where_it_differs(change):
    def plan(x, y):
        points = plan_from(x, y)
        if x > 1.5 and change == 'end':
            points = np.concatenate([points[:1], points[1:][points[1:, 0] < 3.9], ROUTE[395:396]])
        elif x > 1.5:
            points = points + np.exp(-8.0 * (points[:, :1] - 3.0)**2) * [[0.0, 0.15]]
        return points

    cart = Cart(STARTS[0], plan=plan)
    truth = drive(BASE, cart, STARTS[0], SECONDS)
    places = np.array([pose[:2] for _, pose in truth])
    assert [one.refusal for one in cart.answers if one.refusal] == []
    assert sum(not one.goes_on for one in cart.answers) == 2
    if change == 'end':
        assert places[-1, 0] == pytest.approx(3.95, abs=0.02)
    else:
        assert across(places).max() == pytest.approx(0.14, abs=0.03)
        assert places[-1] == pytest.approx(ROUTE[-1], abs=0.02)
