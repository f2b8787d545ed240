"""The command `excite` on a base that is not of this package."""

import fcntl
import math
import os
import pty
import re
import resource
import signal
import subprocess
import sys
import termios
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
from geometry_msgs.msg import Twist
from helpers import stand_in_base
from nav_msgs.msg import Odometry

from mobile_robot_control.identification import command as identify

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


def start(*arguments, **options):
    return subprocess.Popen([sys.executable, '-m', 'mobile_robot_control.excitation.command', *arguments],
                            **{'stderr': subprocess.PIPE, 'text': True, **options})


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


class Driven(stand_in_base.Base):
    """A base whose odometry shows a fault once it has driven a little, or from the beginning."""

    def __init__(self, name, at_once=False):
        super().__init__(plain=False, namespace=name)
        self.at_once, self.kept = at_once, None
        publish = self.odom.publish
        self.odom = SimpleNamespace(publish=lambda message: publish(self.distort(message)))

    def set_down(self):
        self.x, self.y, self.v, self.omega, self.command = 1.0, 0.0, 0.0, 0.0, Twist()

    def has_driven(self):
        return self.at_once or math.dist((self.x, self.y), (1.0, 0.0)) > 0.05

    def distort(self, message):
        if not self.has_driven():
            self.kept = message
        elif self.fault == 'stamp':
            return self.kept
        elif self.fault == 'numbers':
            message.pose, message.twist = self.kept.pose, self.kept.twist
        elif self.fault == 'old':
            message.header.stamp.sec -= 3
        return message

    @property
    def fault(self):
        return self.get_namespace().strip('/').partition('_')[0]


def _small_disk():
    resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))


def _terminal(slave):
    os.setsid()
    fcntl.ioctl(slave, termios.TIOCSCTTY, 0)


@pytest.mark.parametrize('faults', [
    {'stamp': r'has been silent for 0\.\d s, since it is refused: stamp does not advance',
     'numbers': 'odometry does not change, though'},
    {'old_later': r'it is refused: stamp too old \(by 3\.0',
     # the name of a node is discovered after its publishers
     'second': '/second/odom has several publishers: (/recorder and /second/base|/second/base and a node )'},
    {'disk': r'\.mcap: File too large', 'terminal': ''},
], ids=' and '.join)
def test_odometry_that_cannot_be_right_a_closed_terminal_and_a_full_disk_stop_the_robot(robot, tmp_path, faults):
    bases = {name: Driven(name) for name in faults}
    for base in bases.values():
        robot.add(base)
    master, slave = pty.openpty()
    options = {'terminal': {'stderr': slave, 'preexec_fn': partial(_terminal, slave)},
               'disk': {'preexec_fn': _small_disk}}
    commands = {}

    def run(name):
        bases[name].set_down()
        # the fault must end it, on a busy machine too
        commands[name] = start(*BOX, '--namespace', f'/{name}', '--duration', '300', *(
            ['--bag', str(tmp_path / f'bag{len(os.listdir(tmp_path))}')] * (name == 'disk')), **options.get(name, {}))

    def all_have_driven():
        for name, base in bases.items():
            # on a busy machine a base may be silent for 0.5 s, which ends it before any fault
            if name not in commands or (commands[name].poll() is not None and not base.has_driven()):
                run(name)
        return all(base.has_driven() for base in bases.values())

    try:
        robot.spin_until(all_have_driven)
        os.close(slave)
        if 'second' in faults:
            robot.recorder.create_publisher(Odometry, '/second/odom', 1)
        # the kernel sends SIGHUP, and what is printed there from now on raises
        os.close(master)
        robot.spin_until(lambda: all(command.poll() is not None for command in commands.values()))
    finally:
        for command in commands.values():
            command.kill()
    told = {name: command.stderr.read() for name, command in commands.items() if name != 'terminal'}
    assert {name: command.returncode for name, command in commands.items()} == dict.fromkeys(faults, 1), told
    for name, words in faults.items():
        assert re.search(words, told.get(name, '')), told[name]
    robot.spin_until(lambda: all(abs(base.v) + abs(base.omega) < 1e-3 for base in bases.values()))
    for name, base in bases.items():
        assert (base.command.linear.x, base.command.angular.z) == (0.0, 0.0), name


def test_odometry_that_is_old_from_the_beginning_is_named_and_the_robot_is_not_moved(robot, tmp_path):
    base, told = Driven('old', at_once=True), tmp_path / 'told'
    robot.add(base)
    with told.open('w') as file:
        command = start(*BOX, '--namespace', '/old', stderr=file)
        robot.spin_until(lambda: 'stamp too old (by 3.0' in told.read_text())
        command.send_signal(signal.SIGINT)
        robot.spin_until(lambda: command.poll() is not None)
    assert (command.returncode, (base.x, base.y)) == (2, (1.0, 0.0))
