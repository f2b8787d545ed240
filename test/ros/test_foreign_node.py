"""A node written from docs/lockstep.md alone takes part in a run; the page agrees with the code."""

import ast
import itertools
import math
import re
import subprocess
import sys
import time
from collections import defaultdict
from pathlib import Path
from types import SimpleNamespace

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistStamped
from helpers import foreign_position_controller
from helpers.harness import CONFIG
from helpers.watching import stamp_nanoseconds
from nav_msgs.msg import Odometry

from mobile_robot_control.messages import parsing
from mobile_robot_control.quantities import LARGEST
from mobile_robot_control.ros.plant import questions
from mobile_robot_control.ros.shared import inputs as input_validation
from mobile_robot_control.ros.shared.qos import PUBLISHED, SUBSCRIBED
from mobile_robot_control.ros.shared.stamp_policy import (
    AnswerStampPolicy,
    LockstepStampPolicy,
    StampDecision,
    WallClockStampPolicy,
)
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.topics import WHEEL_JOINTS

FILE = Path(foreign_position_controller.__file__)
PAGE = (Path(__file__).parents[2] / 'docs' / 'lockstep.md').read_text(encoding='utf-8')
OTHERS = ('plant', 'velocity_controller', 'reference_cart')
STEP = foreign_position_controller.LINEAR_ACCELERATION * foreign_position_controller.PERIOD / 1e9
"""[m/s]: what the rate limiter lets the command grow by in one step."""


@pytest.fixture
def start_foreign(robot):
    """Start the foreign node; every one that was started is killed at the end."""
    started = []

    def start():
        started.append(subprocess.Popen([sys.executable, str(FILE)]))
        return started[-1]

    yield start
    for process in started:
        process.kill()
        process.wait()


@pytest.fixture
def commands(robot):
    """Every command that was received, by stamp [ns]: (v [m/s], omega [rad/s]) in the order of arrival."""
    received = defaultdict(list)

    def take(message):
        twist = message.twist
        received[stamp_nanoseconds(message.header.stamp)].append((twist.linear.x, twist.angular.z))

    robot.recorder.create_subscription(TwistStamped, 'cmd_vel', take, PUBLISHED.depth)
    return received


def _close(a, b):
    return all(abs(x - y) <= 1e-9 * max(1.0, abs(y)) for x, y in zip(a, b, strict=True))


def test_it_imports_nothing_of_the_package():
    allowed = {'rclpy', 'builtin_interfaces', 'geometry_msgs', 'nav_msgs'} | sys.stdlib_module_names
    tree = ast.parse(FILE.read_text(encoding='utf-8'))
    imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    imported |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert imported
    assert {name.partition('.')[0] for name in imported} <= allowed
    assert 'importlib' not in imported


def test_a_run_with_it_agrees_with_the_rollout(robot, start_foreign, commands):
    file, pose = CONFIG / 'backstepping.yaml', 'initial_pose:=[0.9, 0.1, 1.2]'
    start_foreign()
    robot.start(*OTHERS, arguments=[
        '--params-file', str(file), '-p', f'plant:{pose}', '-p', 'duration:=1.0', '-p', 'real_time_factor:=0.0',
        '-p', 'paused:=true',
    ])
    robot.spin_until(robot.recorder.has_every_topic)
    # a paused plant repeats its question
    robot.spin_until(lambda: len(commands[0]) >= 3)
    robot.resume()
    robot.finish()
    recording = robot.recording()
    limit = f'position_controller.limits.linear_acceleration:={foreign_position_controller.LINEAR_ACCELERATION}'
    simulated = list(rollout(configure(load([file], [f'plant.{pose}', limit])), 1.0))
    assert not recording.problems
    assert len(recording.samples) == len(simulated) == 501
    for recorded, sample in zip(recording.samples, simulated, strict=True):
        assert recorded.time == sample.time
        assert recorded.tick.time == sample.tick.time
        for ours, theirs in ((recorded.command, sample.command), (recorded.tick.error, sample.tick.error),
                             (recorded.torque, sample.torque), (recorded.wheels, sample.wheels),
                             (recorded.tick.pose, sample.tick.pose)):
            assert _close(ours, theirs), recorded.time
    # however often it was asked for, an answer is the same, and the limiter has stepped once a tick
    assert all(len(set(answers)) == 1 for answers in commands.values())
    assert recording.samples[0].command.linear == pytest.approx(STEP, rel=1e-12)


def test_killed_in_mid_run_it_joins_and_the_run_goes_on(robot, start_foreign):
    first = start_foreign()
    robot.start(*OTHERS, arguments=['-p', 'duration:=0.4', '-p', 'real_time_factor:=0.0', '-p', 'hold_at:=0.2'])
    robot.spin_until(robot.recorder.has_every_topic)
    # the command of this tick has arrived where it is used
    robot.spin_until(lambda: robot.recorder.newest['wheel_torques'] == 200_000_000)
    first.kill()
    first.wait()
    robot.resume()
    # up to the next position tick the velocity controller has its command
    robot.spin_until(lambda: robot.time() == 0.21)
    start_foreign()
    robot.spin_until(lambda: robot.recorder.newest['wheel_torques'] == 400_000_000)
    robot.finish()


def _odometry(stamp, child_frame, x=0.0):
    message = Odometry(child_frame_id=child_frame)
    message.header.stamp, message.header.frame_id = Time(nanosec=stamp), 'odom'
    message.pose.pose.position.x, message.pose.pose.orientation.w = x, 1.0
    return message


def test_its_decisions(robot, start_foreign, commands):
    start_foreign()
    publishers = [robot.recorder.create_publisher(Odometry, topic, PUBLISHED) for topic in ('odom', 'reference')]
    # the recorder subscribes too
    robot.spin_until(lambda: all(publisher.get_subscription_count() > 1 for publisher in publishers))
    period = foreign_position_controller.PERIOD

    def publish(stamp, x=0.0):
        for publisher, child, at in zip(publishers, ('base_link', 'reference_cart'), (x, 1.0), strict=True):
            publisher.publish(_odometry(stamp, child, at))

    def ask(stamp, x=0.0, again=math.inf):
        before, due = len(commands[stamp]), time.monotonic()

        def answered():
            nonlocal due
            if time.monotonic() >= due:
                due += again
                publish(stamp, x)
            return len(commands[stamp]) > before

        robot.spin_until(answered)
        return commands[stamp][-1][0]

    # the first stamp may be any: it joins a run under way, and then takes the next one only
    # repeated, as by the plant: publishers and subscriptions may not be matched yet
    assert ask(7 * period, again=0.5) == pytest.approx(STEP)
    publish(9 * period)
    assert ask(8 * period) == pytest.approx(2.0 * STEP)
    # asked again it answers again without a step
    assert ask(8 * period) == ask(8 * period) == pytest.approx(2.0 * STEP)
    assert set(commands) == {7 * period, 8 * period}
    # a new run
    commands.clear()
    assert ask(0) == ask(0) == pytest.approx(STEP)
    # a plant that was killed at 0 and started again elsewhere begins one, too
    assert ask(0, x=1.5) == ask(0, x=1.5) == pytest.approx(-STEP)
    assert ask(0) == pytest.approx(STEP)
    assert ask(period) == pytest.approx(2.0 * STEP)
    # neither a stamp that is off the grid nor a number that is not finite takes a step or gets an answer
    publish(period + 1)
    publish(2 * period, x=math.nan)
    assert ask(2 * period) == pytest.approx(3.0 * STEP)
    # the first question may have been asked, and answered, once more
    assert set(commands) - {7 * period} == {0, period, 2 * period}


def test_the_decisions_of_the_node_and_of_the_page_are_those_of_the_nodes():
    code, = re.findall(r'```python\n(.*?)```', PAGE, re.DOTALL)
    of_the_page, found = {}, set()
    exec(code, of_the_page)  # noqa: S102 (our own page)
    for accepted, stamp in itertools.product((None, *range(0, 100, 10)), range(-20, 130)):
        policy = LockstepStampPolicy(10)
        policy.accepted = accepted
        found.add(policy.decide(stamp))
        for decide in (of_the_page['decide'], foreign_position_controller.decide):
            assert decide(stamp, accepted, 10) == policy.decide(stamp).name
    assert found == set(StampDecision) - {StampDecision.HOLD}


def _reasons():
    """The reasons for which messages are refused: those written in the code, and those of the stamp policies."""
    for module in (parsing, input_validation):
        for node in ast.walk(ast.parse(Path(module.__file__).read_text(encoding='utf-8'))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == 'RefusedMessageError':
                parts = node.args[0].values if isinstance(node.args[0], ast.JoinedStr) else [node.args[0]]
                yield from (part.value.strip() for part in parts if isinstance(part, ast.Constant))
    clock = SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=10**12))
    for policy, stamps in ((LockstepStampPolicy(10), (5, 20)), (AnswerStampPolicy(10), (20,)),
                           (WallClockStampPolicy(clock, 0.5), (0, 2 * 10**12))):
        yield from (policy.refusal(stamp).reason for stamp in stamps)


def test_the_page_has_the_decisions_the_constants_and_every_reason_of_the_code():
    rows = re.findall(r'^\| `([A-Z]+)` \|', PAGE, re.MULTILINE)
    assert sorted(rows[:len(StampDecision)]) == sorted(StampDecision.__members__)
    assert sorted(rows[len(StampDecision):]) == ['AGAIN', 'REFUSED', 'STEP']
    shared, words = Shared(), ' '.join(PAGE.split())
    assert not [sentence for sentence in (
        f'Every {questions.REPEAT_AFTER} s of wall time the plant checks its question',
        f'Publishers have a depth of {PUBLISHED.depth}', f'Subscriptions have a depth of {SUBSCRIBED.depth}',
        f'`peer_timeout` ({shared.peer_timeout} s of wall time)', f'`stamp_tolerance` ({shared.stamp_tolerance} s)',
        *(f'| {round(1e9 / rate):_} ns ({rate:g} Hz) |'.replace('_', ' ')
          for rate in (shared.velocity_rate, shared.position_rate)),
        f'`{"` and `".join(WHEEL_JOINTS)}`', f'beyond {LARGEST:g} in SI units'.replace('e+', 'e'),
    ) if sentence not in words]
    reasons, refused = set(_reasons()), PAGE.partition('## What is refused')[2].partition('\n## ')[0]
    assert len(reasons) > 10
    assert not [reason for reason in reasons if reason not in refused]
