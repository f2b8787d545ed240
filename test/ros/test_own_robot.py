"""Position controller and reference cart drive a base that is not of this package; the last command is zero."""

import itertools
import math
import subprocess
import sys
from pathlib import Path

import pytest
import stand_in_base
from geometry_msgs.msg import Twist, TwistStamped, Vector3Stamped
from harness import CONFIG
from sensor_msgs.msg import JointState

from mobile_robot_control.ros.services.qos import PUBLISHED

OURS = ['--params-file', str(CONFIG / 'wall_clock.yaml'), '-p', 'odom_frame_id:=map', '-p',
        'base_frame_id:=base_footprint']


@pytest.fixture
def base(robot):
    """Start the stand-in base."""
    started = []

    def start(*options):
        started.append(subprocess.Popen([sys.executable, Path(stand_in_base.__file__), *options]))

    yield start
    for process in started:
        process.kill()
        process.wait()


@pytest.mark.parametrize(('kind', 'topic', 'options', 'ours'), [
    pytest.param(TwistStamped, 'cmd_vel', [], [], marks=pytest.mark.soak),
    (Twist, 'plain_cmd_vel', ['--plain'], ['-p', 'stamped_cmd_vel:=false', '-r', 'cmd_vel:=plain_cmd_vel']),
], ids=['stamped', 'plain'])
def test_another_base_follows_the_cart_and_is_stopped_at_the_end(robot, base, kind, topic, options, ours):
    errors, commands = [], []
    robot.recorder.create_subscription(Vector3Stamped, 'tracking_error', errors.append, PUBLISHED)
    robot.recorder.create_subscription(kind, topic, lambda message: commands.append(
        message if kind is Twist else message.twist), 100)
    base(*options)
    robot.start('position_controller', 'reference_cart', arguments=[*OURS, *ours])
    def follows():
        late = [math.hypot(error.vector.x, error.vector.y) for error in errors[-100:]]
        return 0.0 < math.sqrt(sum(error**2 for error in late) / len(late)) < 0.1 and commands[-1].linear.x != 0.0

    # a node without a turn for some time makes the error larger for a while
    robot.spin_until(lambda: len(errors) > 250 and follows())
    robot.stop('position_controller')
    robot.spin_until(lambda: commands[-1] == Twist())


@pytest.mark.soak
def test_command_limits_hold_on_another_base(robot, base):
    commands = []
    robot.recorder.create_subscription(TwistStamped, 'cmd_vel', commands.append, 100)
    base()
    robot.start('position_controller', 'reference_cart', arguments=[
        *OURS, '-p', 'limits.linear_velocity:=0.3', '-p', 'limits.angular_acceleration:=2.0'
    ])
    robot.spin_until(lambda: len(commands) > 150)
    assert max(abs(message.twist.linear.x) for message in commands) == 0.3
    turns = [message.twist.angular.z for message in commands[:150]]
    steps = [abs(after - before) for before, after in itertools.pairwise(turns)]
    assert 0.01 < max(steps) <= 2.0 * 0.02 + 1e-9


def test_the_velocity_controller_ends_with_zero_torques(robot):
    torques = []
    robot.recorder.create_subscription(JointState, 'wheel_torques', torques.append, 100)
    robot.start(arguments=['--params-file', str(CONFIG / 'wall_clock.yaml')])
    robot.spin_until(lambda: torques and any(torques[-1].effort))
    robot.stop('velocity_controller')
    robot.spin_until(lambda: list(torques[-1].effort) == [0.0, 0.0])
