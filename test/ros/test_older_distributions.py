"""
The rclpy at hand without what ROS 2 Humble lacks: the nodes run all the same.

Humble itself is not tested: there are no wheels of it.
"""

import os
import subprocess
import sys

import pytest
from harness import CONFIG

from mobile_robot_control.experiment.recorder import NO_LIMIT

# a sitecustomize.py, which every Python with it on its path runs first
_REMOVE = '''
import importlib.abc
import sys


class Absent(importlib.abc.MetaPathFinder):
    """No EventsExecutor, and no callbacks before and after a change of parameters."""

    def find_spec(self, name, path, target=None):
        if name.startswith('rclpy.experimental'):
            raise ModuleNotFoundError(name)
        if name == 'mobile_robot_control.ros.spin':
            from rclpy.node import Node
            for method in ('add_pre_set_parameters_callback', 'add_post_set_parameters_callback'):
                if hasattr(Node, method):
                    delattr(Node, method)
        return None


sys.meta_path.insert(0, Absent())
'''
ARGUMENTS = ['--params-file', str(CONFIG / 'hybrid_backstepping.yaml'), '-p', 'duration:=1.0', '-p', 'paused:=true',
             '-p', 'plant:initial_pose:=[0.8, 0.1, 0.0]', '-p', 'real_time_factor:=0.0']


@pytest.fixture
def like_humble(tmp_path, monkeypatch):
    """Remove what Humble lacks from every process that is started from now on."""
    (tmp_path / 'without').mkdir()
    (tmp_path / 'without' / 'sitecustomize.py').write_text(_REMOVE)
    monkeypatch.setenv('PYTHONPATH', f'{tmp_path / "without"}:{os.environ.get("PYTHONPATH", "")}')


def test_without_what_humble_lacks_a_run_and_a_live_change_work(robot, like_humble):
    code = ('from rclpy.node import Node\n'
            'from mobile_robot_control.ros.spin import make_executor\n'
            'import rclpy\n'
            'rclpy.init()\n'
            'print(type(make_executor()).__name__, hasattr(Node, "add_post_set_parameters_callback"))\n')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ['SingleThreadedExecutor', 'False']
    # the recorder sets hold_at, so that nothing is lost: it holds the run here
    robot.recorder.limit = 5 * 10**8
    robot.start(arguments=ARGUMENTS)
    robot.resume()
    robot.wait_at(0.5)
    # whole numbers are converted, and a value out of bounds is refused by name, by the service of the package
    result, = robot.set('position_controller', backstepping__f=2)
    assert result.successful, result.reason
    result, = robot.set('position_controller', backstepping__f=-1.0)
    assert 'backstepping.f = -1.0' in result.reason
    robot.recorder.limit = NO_LIMIT
    robot.release()
    recording = robot.recording()
    assert not recording.problems
    assert recording.samples[-1].time == 1.0
    # the robot started beside the path
    assert max(abs(sample.tick.error.lateral) for sample in recording.samples) > 0.01
