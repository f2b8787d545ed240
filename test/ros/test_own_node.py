"""The example node: a filter between two nodes, in lockstep and on the wall clock; colcon and pip take it."""

import contextlib
import itertools
import math
import os
import signal
import subprocess
import sys
import types
from pathlib import Path

import pytest
from geometry_msgs.msg import TwistStamped
from helpers.watching import stamp_nanoseconds

from mobile_robot_control.quantities import BodyVelocity
from mobile_robot_control.ros.shared.qos import PUBLISHED
from mobile_robot_control.ros.start import spin

EXAMPLE = Path(__file__).parents[2] / 'examples' / 'command_filter'
TIME_CONSTANT = 0.1


@pytest.fixture
def node(monkeypatch):
    """The OwnNode of the example."""
    monkeypatch.syspath_prepend(EXAMPLE)
    from command_filter import node

    return node


class Filtered:
    """Two of five nodes, started by hand; `heard` is what came on both topics, in its order: stamp and command."""

    def __init__(self, robot, log, *arguments):
        self._log, self.heard = log, {topic: [] for topic in ('cmd_vel_raw', 'cmd_vel')}
        for topic, heard in self.heard.items():
            robot.recorder.create_subscription(TwistStamped, topic, lambda one, heard=heard: heard.append((
                stamp_nanoseconds(one.header.stamp), BodyVelocity(one.twist.linear.x, one.twist.angular.z))), PUBLISHED)
        with log.open('w') as file:
            self.filter = subprocess.Popen(
                [sys.executable, '-m', 'command_filter.node', '--ros-args', '-p', f'time_constant:={TIME_CONSTANT}',
                 *arguments], stderr=file,
                env=os.environ | {'PYTHONPATH': os.pathsep.join([str(EXAMPLE), os.environ.get('PYTHONPATH', '')])})
        robot.start('position_controller', arguments=[*arguments, '-r', 'cmd_vel:=cmd_vel_raw'])

    def printed(self):
        return self._log.read_text()

    def end(self):
        self.filter.send_signal(signal.SIGINT)
        assert self.filter.wait(60.0) == 0, self.printed()
        return self.printed()


@pytest.fixture
def filtered(robot, tmp_path):
    """Starts the filter and the position controller; kills the filter at the end."""
    with contextlib.ExitStack() as ending:
        def start(*arguments):
            started = Filtered(robot, tmp_path / 'filter.txt', *arguments)
            ending.callback(started.filter.wait)
            ending.callback(started.filter.kill)
            return started

        yield start


@pytest.mark.dds
def test_in_lockstep_each_command_is_filtered_with_its_stamp(robot, filtered, node):
    run = filtered()
    robot.start('plant', 'velocity_controller', 'reference_cart', composed=True, arguments=[
        '-p', 'duration:=0.5', '-p', 'real_time_factor:=0.0', '-p', 'paused:=true',
        '-p', 'plant:initial_pose:=[0.9, 0.1, 1.2]'])
    robot.spin_until(lambda: robot.recorder.has_every_topic() and all(run.heard.values()))
    robot.resume()
    robot.finish()
    # the nodes have ended; what they sent last may still be on its way to this process
    stamps = set(range(0, 510_000_000, 10_000_000))
    robot.spin_until(lambda: all({stamp for stamp, _ in heard} >= stamps for heard in run.heard.values()))
    raw, sent = (dict(reversed(heard)) for heard in run.heard.values())
    assert set(raw) == set(sent) == stamps
    state = node.NODE.start
    for stamp in sorted(raw):
        state, outputs = node.step(state, {'cmd_vel_raw': raw[stamp]}, node.Parameters(TIME_CONSTANT), 0.01)
        assert outputs['cmd_vel'] == sent[stamp], stamp
    # what it was asked again it answered without a step
    assert all(sent[stamp] == command for stamp, command in run.heard['cmd_vel'])
    assert 'ended at t = 0.5 s' in run.end()
    # the position controller knows that its commands go elsewhere
    assert 'not as a listener' not in robot.log()


@pytest.mark.dds
def test_on_the_wall_clock_it_filters_at_its_rate_and_falls_silent_with_its_input(robot, filtered):
    run = filtered('-p', 'lockstep:=false', '-p', 'peer_timeout:=0.5')
    robot.start('plant', 'velocity_controller', 'reference_cart', composed=True, arguments=['-p', 'lockstep:=false'])
    robot.spin_until(lambda: min(map(len, run.heard.values())) > 50)
    # each command is the one before and a share of a command that was received
    raw, sent = run.heard['cmd_vel_raw'], [command.linear for _, command in run.heard['cmd_vel']]
    share = 1.0 - math.exp(-0.01 / TIME_CONSTANT)
    asked = [before + (after - before) / share for before, after in itertools.pairwise(sent[-30:-10])]
    # the topics are of two processes: a command may come after what was made of it
    robot.spin_until(lambda: all(min(abs(one - command.linear) for _, command in raw) < 1e-9 for one in asked))
    robot.stop('position_controller')
    robot.spin_until(lambda: robot.recorder.get_clock().now().nanoseconds - run.heard['cmd_vel'][-1][0] > 10**9)
    robot.spin_until(lambda: 'no cmd_vel_raw for' in run.printed())
    run.end()


@pytest.mark.parametrize(('change', 'words'), [
    ({'inputs': {'cmd_vel_raw': 'twist'}}, "'twist' is no topic of the loop; write one of joint_states, wheel_torques"),
    ({}, "unknown parameter 'time_constan'"),
])
def test_what_is_no_good_is_refused_in_words(domain, node, capfd, change, words):
    code = spin.spin(['command_filter'], ['--ros-args', '-p', 'time_constan:=0.1'],
                     types.SimpleNamespace(requested=True), node.NODE._replace(**change))
    assert code == 2
    assert words in capfd.readouterr().err


def test_it_is_a_package_of_ament_python_and_passes_its_own_test():
    colcon = Path(sys.executable).with_name('colcon')
    listed = subprocess.run([colcon, 'list', '--base-paths', EXAMPLE], capture_output=True, text=True, check=True)
    assert listed.stdout.split() == ['command_filter', str(EXAMPLE), '(ros.ament_python)']
    subprocess.run([sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider', EXAMPLE / 'test'], check=True,
                   env=os.environ | {'PYTHONPATH': str(EXAMPLE)}, cwd=EXAMPLE)
