"""`experiment --attach plant`: a robot that runs already is driven and recorded, and stands in the end."""

import json
import signal
import subprocess
import sys

import pytest
from geometry_msgs.msg import TwistStamped
from helpers.harness import CONFIG
from helpers.processes import processes_of
from nav_msgs.msg import Odometry

from mobile_robot_control.runs import bag

WALL_CLOCK = ('--params-file', CONFIG / 'wall_clock.yaml')
DRIVEN = ('--attach', 'plant', *WALL_CLOCK, '-p', 'plant.drive:=velocity')


@pytest.fixture
def base(robot):
    """A base on the wall clock that never stops by itself, its odometry, and what it is told."""
    odometry, commands = [], []
    robot.recorder.create_subscription(Odometry, 'odom', odometry.append, 100)
    robot.recorder.create_subscription(TwistStamped, 'cmd_vel', commands.append, 100)
    robot.start('plant', arguments=[*WALL_CLOCK, '-p', 'drive:=velocity', '-p', 'base.command_timeout:=0.0'])
    robot.spin_until(lambda: odometry)
    return odometry, commands


def _start(output, *options):
    return subprocess.Popen([sys.executable, '-m', 'mobile_robot_control.experiment.command', '--output', str(output),
                             *map(str, DRIVEN), '--yes', *options], stderr=subprocess.PIPE, text=True)


def _stands(odometry):
    return all(abs(one.twist.twist.linear.x) < 0.005 and abs(one.twist.twist.angular.z) < 0.02
               for one in odometry[-20:])


@pytest.mark.parametrize('number', [signal.SIGKILL, *(
    pytest.param(one, marks=pytest.mark.soak) for one in (None, signal.SIGINT))])
def test_it_stands_after_the_run_after_ctrl_c_and_when_its_recorder_is_killed(robot, base, tmp_path, number):
    odometry, commands = base
    output = tmp_path / 'run'
    run = _start(output, '--no-report', '--duration', '2' if number is None else '60')
    robot.spin_until(lambda: odometry[-1].twist.twist.linear.x > 0.1)
    if number == signal.SIGKILL:
        # a recorder that is killed has written what is a second old
        begun = odometry[-1].header.stamp.sec
        robot.spin_until(lambda: odometry[-1].header.stamp.sec > begun + 2)
    if number is not None:
        run.send_signal(number)
    robot.spin_until(lambda: run.poll() is not None)
    robot.spin_until(lambda: not processes_of(output))
    robot.spin_until(lambda: _stands(odometry))
    assert (commands[-1].twist.linear.x, commands[-1].twist.angular.z) == (0.0, 0.0)
    errors = run.stderr.read()
    measured = json.loads((output / 'metrics.json').read_text())
    assert measured['provenance']['nodes'] == {'plant': {'attached': True}}
    if number is None:
        assert (run.returncode, measured['outcome']) == (0, 'completed'), errors
        # from the first reference on
        assert 1.9 < measured['duration'] < 3.0
        assert 'neither its times nor its numbers can be repeated' in errors
    else:
        assert measured['outcome'] == 'interrupted'
    assert bag.read_bag(output / 'bag').samples
