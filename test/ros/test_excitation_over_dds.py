"""The command `excite` on a base that is not of this package."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
import stand_in_base
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from mobile_robot_control.cli import identify

PLAIN = ('--topic', 'cmd_vel:=plain_cmd_vel')
BOX = ('--box', '3', '3', '--max-velocity', '0.5', '--yes')


@pytest.fixture
def base(robot):
    """A base that takes a plain Twist, and what it is told."""
    commands, process = [], subprocess.Popen([sys.executable, Path(stand_in_base.__file__), '--plain'])
    robot.recorder.create_subscription(Twist, 'plain_cmd_vel', commands.append, 100)
    yield commands
    process.kill()
    process.wait()


def start(*arguments):
    return subprocess.Popen([sys.executable, '-m', 'mobile_robot_control.cli.excite', *arguments],
                            stderr=subprocess.PIPE, text=True)


def test_ctrl_c_ends_it_in_a_stop_and_the_bag_can_be_read(robot, base, tmp_path, capsys):
    odometry = []
    robot.recorder.create_subscription(Odometry, 'odom', odometry.append, 100)
    bag = tmp_path / 'excited'
    command = start(*BOX, *PLAIN, '--bag', str(bag))
    robot.spin_until(lambda: any(one.linear.x < 0.0 for one in base))
    command.send_signal(signal.SIGINT)
    robot.spin_until(lambda: command.poll() is not None)
    # on a busy machine it may have told before that it waits for odometry
    assert (command.returncode, command.stderr.read().splitlines()[-1]) == (
        1, 'excite: interrupted; the robot got zero commands')
    robot.spin_until(lambda: (base[-1].linear.x, base[-1].angular.z) == (0.0, 0.0))
    robot.spin_until(lambda: abs(odometry[-1].twist.twist.linear.x) < 0.005)
    assert identify.main([str(bag), '--check', *PLAIN]) == 1
    assert 'commands and odometry lie beside each other for' in capsys.readouterr().out
    # another node takes over: the robot is stopped
    second = start(*BOX, *PLAIN)
    robot.spin_until(lambda: base[-1].linear.x)
    robot.recorder.create_publisher(Twist, 'plain_cmd_vel', 1)
    robot.spin_until(lambda: second.poll() is not None)
    assert second.returncode == 1
    assert 'others command the robot: /recorder; stop them' in second.stderr.read()
    # from the beginning, as soon as it is discovered
    third = start(*BOX, *PLAIN)
    robot.spin_until(lambda: third.poll() is not None)
    assert third.returncode in (1, 2)
    assert '/recorder' in third.stderr.read()
