"""The promise of a plant like a stand-in base, on the base as a node: on the wall clock and in simulated time."""

import contextlib
import itertools
import math
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import TwistStamped
from helpers import late_base
from helpers.harness import CONFIG
from helpers.promising import TUNED, fed, plant_like, promised
from helpers.stand_in_model import Base
from nav_msgs.msg import Odometry

from mobile_robot_control.settings.nodes import course_of

LAG, LAP = 0.15, 16.0


def _seconds(message):
    return message.header.stamp.sec + message.header.stamp.nanosec / 1e9


def by_time(messages):
    """Return stamps [s], x and y of odometry messages since time began anew, each as an array."""
    falls = [n for n, (one, next_one) in enumerate(itertools.pairwise(messages), start=1)
             if _seconds(next_one) < _seconds(one)]
    messages = messages[falls[-1]:] if falls else messages
    return np.array([[_seconds(message), message.pose.pose.position.x,
                      message.pose.pose.position.y] for message in messages]).T


class Driven:
    """A base that the nodes drive along a curve or a path; its messages are kept."""

    def __init__(self, robot, given, factor, curve):
        self.robot, self.parameters = robot, plant_like(Base(lag=LAG), curve, given)
        self.truth, self.cart, self.commands = [], [], []
        for topic, kind, found in (('ground_truth', Odometry, self.truth), ('reference', Odometry, self.cart),
                                   ('cmd_vel', TwistStamped, self.commands)):
            robot.recorder.create_subscription(kind, topic, found.append, 100)
        self.start = course_of(self.parameters.reference_cart).reference(0.0).pose
        options = ['--lag', str(LAG), '--factor', str(factor), '--pose', *map(str, self.start)]
        self.base = subprocess.Popen([sys.executable, '-m', late_base.__name__, *options],
                                     cwd=Path(__file__).parents[1])
        robot.start('position_controller', 'reference_cart', arguments=[
            '--params-file', CONFIG / 'wall_clock.yaml', '-p', 'odometry_stamped:=sampled', '-p',
            'feedforward.enabled:=false', '-p', f'use_sim_time:={str(factor > 0.0).lower()}',
            '-p', f'reference_cart:curve:={curve}',
            *(word for one in given for word in ('-p', re.sub(r'^(/\*\*\.|(\w+)\.)', lambda found: (
                f'{found[2]}:' if found[2] else ''), one, count=1)))])

    def rms(self, since=None, last=0.0):
        """Return the RMS of the true error from a time after the first reference on, or of the last seconds."""
        stamps, x, y = by_time(self.cart)
        then, true_x, true_y = by_time(self.truth)
        late = stamps >= (stamps[-1] - last if since is None else stamps[0] + since)
        apart = np.hypot(np.interp(stamps[late], then, true_x) - x[late],
                         np.interp(stamps[late], then, true_y) - y[late])
        return math.sqrt(float((apart**2).mean()))

    def follows(self):
        """Spin until the base follows the cart: within 3 cm over 2 s of its time."""
        self.robot.spin_until(lambda: len(self.cart) > 120 and len(self.truth) > 1 and self.rms(last=2.0) < 0.03)

    def forget(self):
        """Forget all messages."""
        for kept in (self.truth, self.cart, self.commands):
            kept.clear()


@pytest.fixture
def drive(robot):
    """Drive a base with some parameters, at a factor of simulated time."""
    with contextlib.ExitStack() as stack:
        def made(given, factor=0.0, curve='trifolium'):
            driven = Driven(robot, given, factor, curve)
            stack.callback(driven.base.wait)
            stack.callback(driven.base.kill)
            return driven

        yield made


@pytest.mark.soak
@pytest.mark.parametrize('factor', [0.0, 0.2, 0.5, 1.0, 2.0])
@pytest.mark.parametrize(('given', 'bound'), [(TUNED, 0.015), ([*TUNED, *fed(LAG)], 0.005)], ids=['', 'feedforward'])
def test_tuned_gains_keep_their_promise_on_a_base_of_its_own(drive, given, bound, factor):
    driven = drive(given, factor)
    driven.robot.spin_until(lambda: len(driven.cart) > 50 * 2.5 * LAP, 60.0 / (factor or 1.0))
    rms, foreseen = driven.rms(10.0), promised(driven.parameters)
    print(f'RMS error {100.0 * rms:.2f} cm, promised {100.0 * foreseen:.2f} cm')
    assert rms < bound
    assert rms == pytest.approx(foreseen, rel=0.3, abs=0.0015)


@pytest.mark.soak
def test_a_path_of_waypoints_is_driven_with_the_error_that_simulate_promises(drive, tmp_path):
    (tmp_path / 'path.csv').write_text('0,0\n1.5,0\n1.5,1\n0,1\n')
    driven = drive([*TUNED, f'reference_cart.path.file:={tmp_path}/path.csv', *(
        f'reference_cart.timing.{name}:={value}' for name, value in (
            ('max_linear_velocity', 0.4), ('max_linear_acceleration', 0.3), ('max_angular_velocity', 0.8),
            ('max_angular_acceleration', 2.0)))], curve='path')
    seconds = course_of(driven.parameters.reference_cart).period
    # a cart that waits stands at first, and speeds up within a second
    driven.robot.spin_until(lambda: driven.cart and driven.cart[-1].twist.twist.linear.x > 0.35)
    driven.forget()
    driven.robot.spin_until(lambda: len(driven.cart) > 100 and driven.cart[-1].twist.twist.linear.x == 0.0)
    rms, foreseen = driven.rms(0.0), promised(driven.parameters, 2.0, seconds)
    assert rms == pytest.approx(foreseen, rel=0.3)


def test_a_clock_from_outside_goes_stands_or_begins_anew_and_a_stop_stays(drive):
    driven = drive(TUNED, 2.0)
    robot = driven.robot
    driven.follows()

    def at_full_speed():
        """Return what the cart told after each second in which it speeds up: at first, and after a wait."""
        told, slow, before = [], -math.inf, -math.inf
        for message in driven.cart:
            now = _seconds(message)
            # on a busy machine a node that was delayed lets its cart stand meanwhile
            if message.twist.twist.linear.x == 0.0 or now - before > 0.4:
                slow = now
            before = now
            if now > slow + 1.0:
                told.append(message)
        return told

    def near():
        """Return which are near the next one: over one that this listener missed, the way is no straight line."""
        told = at_full_speed()
        return np.diff(by_time(told)[0]) < 0.1 if len(told) > 60 else np.array([False])

    robot.spin_until(lambda: near().sum() > 40)
    # the cart's own time is that of its stamps: it drives as far as it says
    told, close = at_full_speed(), near()
    stamps, x, y = by_time(told)
    speeds = np.array([message.twist.twist.linear.x for message in told])
    ways, said = np.hypot(np.diff(x), np.diff(y)), 0.5 * (speeds[:-1] + speeds[1:]) * np.diff(stamps)
    # a tick reads the clock for its stamp before it moves the cart: on a busy machine up to a period before, at the
    # ends of each piece
    pieces = 1 + np.count_nonzero(~close)
    assert ways[close].sum() == pytest.approx(said[close].sum(), abs=0.02 * pieces * speeds.max())

    driven.base.send_signal(signal.SIGUSR1)

    def is_still():
        driven.forget()
        robot.listen(0.5)
        return (driven.cart, driven.commands) == ([], [])

    robot.spin_until(is_still)
    robot.spin_until(lambda: all('/clock stands still' in robot.log(name)
                                 for name in ('position_controller', 'reference_cart')))
    driven.base.send_signal(signal.SIGUSR1)
    driven.follows()

    before, reached = len(driven.cart), _seconds(driven.cart[-1])
    driven.base.send_signal(signal.SIGUSR2)
    robot.spin_until(lambda: all('/clock has jumped back' in robot.log(name)
                                 for name in ('position_controller', 'reference_cart')))
    robot.spin_until(lambda: any(_seconds(message) < reached for message in driven.cart[before:]))
    driven.forget()
    driven.follows()
    assert all(robot.log(name).count('a new run begins\n') == 1 for name in ('position_controller', 'reference_cart'))

    assert robot.trigger('position_controller/stop')[0]
    driven.base.send_signal(signal.SIGUSR2)
    robot.spin_until(lambda: robot.log('position_controller').count('/clock has jumped back') == 2)
    robot.listen(0.2)
    driven.forget()
    robot.spin_until(lambda: len(driven.commands) > 50)
    assert not any(message.twist.linear.x or message.twist.angular.z for message in driven.commands)
    robot.stop()
