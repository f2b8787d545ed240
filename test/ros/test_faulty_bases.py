"""Bases that start again elsewhere by their odometry, or turn the other way: the robot does not set out by itself."""

import math
import subprocess
import sys

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from helpers import stand_in_base
from helpers.harness import CONFIG
from nav_msgs.msg import Odometry

from mobile_robot_control.messages.parsing import read_odometry

PARAMETERS = """
/**: {ros__parameters: {base_frame_id: base_footprint, odom_frame_id: map}}
"""
ZERO = (1.0, 0.0, 0.5 * math.pi)
"""Where the base starts, and its odometry begins."""


class Base:
    """A base in a process of its own, its poses, and what the nodes tell."""

    def __init__(self, robot, folder, *options, arguments=()):
        (folder / 'mine.yaml').write_text(PARAMETERS)
        self._robot, self.odom, self.told, self.process = robot, [], {}, None
        self._files = ['--params-file', str(CONFIG / 'wall_clock.yaml'), '--params-file', str(folder / 'mine.yaml')]
        robot.recorder.create_subscription(Odometry, 'odom', lambda one: self.odom.append(read_odometry(one)), 10)
        robot.recorder.create_subscription(DiagnosticArray, '/diagnostics', lambda message: self.told.update(
            {status.name.rpartition('/')[2]: status.message for status in message.status}), 100)
        self.start(*options)
        self.start_nodes('position_controller', 'reference_cart', arguments=arguments)

    def start_nodes(self, *names, arguments=()):
        for name in names:
            self._robot.start(name, arguments=[*self._files, *arguments])

    def command(self, name):
        """Return the words that start a node."""
        return [sys.executable, '-m', 'mobile_robot_control', name, '--ros-args', *self._files]

    def start(self, *options):
        self.process = subprocess.Popen([sys.executable, stand_in_base.__file__, *map(str, options)])

    def kill(self):
        self.process.kill()
        self.process.wait()

    @property
    def pose(self):
        return self.odom[-1][0]

    def drives(self):
        return len(self.odom) > 50 and self.odom[-1][1].linear > 0.2

    def come_back(self, seconds, pose):
        """Die for a time [s], and start at a pose; return when its odometry is there."""
        self.kill()
        self._robot.listen(seconds)
        count = len(self.odom)
        self.start('--at', *pose)
        self._robot.spin_until(lambda: len(self.odom) > count)


@pytest.fixture
def started(robot, tmp_path):
    """A function that starts a base with options; at the end it is killed."""
    made = []

    def start(*options, arguments=()):
        made.append(Base(robot, tmp_path, *options, arguments=arguments))
        return made[0]

    yield start
    made[0].kill()


@pytest.mark.parametrize('seconds', [1.0, *(pytest.param(one, marks=pytest.mark.soak) for one in (0.2, 2.0, 20.0))])
def test_a_base_that_starts_again_at_zero_stands_and_one_five_centimetres_away_drives_on(robot, started, seconds):
    base = started()
    robot.spin_until(base.drives)
    # as it may after a push
    x, y, heading = base.pose
    base.come_back(seconds, (x - 0.05 * math.sin(heading), y + 0.05 * math.cos(heading), heading))
    robot.spin_until(base.drives)
    robot.spin_until(lambda: base.drives() and math.dist(base.pose[:2], ZERO[:2]) > 1.1)
    base.come_back(seconds, ZERO)
    robot.spin_until(lambda: 'the pose of odom has jumped by' in base.told['position_controller'])
    # the cart may discover the base seconds later, and would stand after a release before
    robot.spin_until(lambda: 'odom is silent' not in base.told.get('reference_cart', ''))
    robot.listen(1.5)
    assert math.dist(base.pose[:2], ZERO[:2]) < 0.02
    assert base.told['position_controller'].startswith('stopped')
    # one release suffices
    assert robot.trigger('position_controller/release')[0]
    robot.spin_until(lambda: base.odom[-1][1].linear > 0.05)


def test_a_robot_whose_base_and_controller_start_again_stands_until_it_is_released(robot, started):
    base = started()
    robot.spin_until(lambda: base.drives() and math.dist(base.pose[:2], ZERO[:2]) > 1.1)
    base.kill()
    robot.processes['position_controller'].kill()
    # a controller that is not forked takes as long to start
    robot.listen(1.0)
    # the cart hears the new base later than the controller does
    heard, to_cart = [], robot.recorder.create_publisher(Odometry, 'odom', 10)
    robot.recorder.create_subscription(Odometry, 'early', heard.append, 10)
    base.start('--at', *ZERO, '--ros-args', '-r', 'odom:=early')
    base.told.clear()
    base.start_nodes('position_controller', arguments=['-r', 'odom:=early'])
    # the controller may discover the base seconds before this process does
    robot.spin_until(lambda: heard and 'waits for reference_cart' in base.told.get('position_controller', ''))
    robot.listen(1.5)
    assert read_odometry(heard[-1])[0] == pytest.approx(ZERO)
    robot.recorder.create_subscription(Odometry, 'early', to_cart.publish, 10)
    robot.spin_until(lambda: 'across a silence of' in base.told.get('reference_cart', ''))
    robot.spin_until(lambda: base.told['position_controller'].startswith('running'))
    robot.listen(1.5)
    assert math.dist(base.pose[:2], ZERO[:2]) < 0.02
    assert robot.trigger('position_controller/stop')[0]
    assert robot.trigger('position_controller/release')[0]
    robot.spin_until(lambda: base.odom[-1][1].linear > 0.05)


def test_a_robot_that_turns_the_other_way_is_stopped_with_the_reason(robot, started):
    # it turns away from a cart that waits, and stays there: a busy machine may miss that one turn
    base = started('--turned', arguments=['-p', 'reference_cart:wait:=false'])
    robot.spin_until(lambda: 'odometry moves against the command' in base.told.get('position_controller', ''))
    robot.spin_until(lambda: base.odom and max(map(abs, base.odom[-1][1])) < 1e-3)


def test_a_second_controller_of_one_name_does_not_drive_and_a_stop_holds_for_both(robot, started, tmp_path):
    base = started()
    robot.spin_until(base.drives)
    with (tmp_path / 'second.log').open('w') as log:
        second = subprocess.Popen(base.command('position_controller'), stderr=log)
    try:
        robot.spin_until(lambda: 'is not driven: 2 nodes named /position_controller send cmd_vel' in (
            tmp_path / 'second.log').read_text())
        # the first one goes on, and no release acts while two send; either of both answers
        robot.listen(1.0)
        # on a busy machine silent inputs may stop it for a moment
        robot.spin_until(lambda: min(twist.linear for _, twist in base.odom[-40:]) > 0.1)
        for _ in range(2):
            assert robot.trigger('position_controller/stop')[0]
        robot.spin_until(lambda: max(map(abs, base.odom[-1][1])) < 1e-3)
        released, told = robot.trigger('position_controller/release')
        assert not released
        assert '2 nodes named /position_controller' in told
    finally:
        second.kill()
        second.wait()
    robot.listen(1.5)
    assert max(map(abs, base.odom[-1][1])) < 1e-3
    # the other one counts for some seconds
    robot.spin_until(lambda: robot.trigger('position_controller/release')[0])
    robot.spin_until(lambda: base.odom[-1][1].linear > 0.05)
