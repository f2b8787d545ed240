"""
What ROS 2 Humble lacks, taken away from the rclpy that is here: the nodes run without it, with the same numbers.

Humble itself is not tested: there are no wheels of it.
"""

import os
import subprocess
import sys

import pytest
from harness import CONFIG

# run by every Python that finds it on its path, before anything else
_TAKE_AWAY = '''
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
ARGUMENTS = ['--params-file', str(CONFIG / 'hybrid_backstepping.yaml'), '-p', 'duration:=2.0', '-p', 'paused:=true',
             '-p', 'plant:initial_pose:=[0.8, 0.1, 0.0]', '-p', 'real_time_factor:=0.0', '-p', 'hold_at:=1.0']


@pytest.fixture
def like_humble(tmp_path, monkeypatch):
    """Take away from every process that is started from now on what Humble does not have."""
    (tmp_path / 'lack').mkdir()
    (tmp_path / 'lack' / 'sitecustomize.py').write_text(_TAKE_AWAY)
    monkeypatch.setenv('PYTHONPATH', f'{tmp_path / "lack"}:{os.environ.get("PYTHONPATH", "")}')


def _run(robot):
    """A run of four processes in which gains change while time stands still."""
    robot.start(arguments=ARGUMENTS)
    robot.resume()
    robot.spin_until(lambda: robot.time() == 1.0)
    # whole numbers are converted, and what is out of bounds is refused by name, by our own service
    result, = robot.set('position_controller', backstepping__f=2)
    assert result.successful, result.reason
    result, = robot.set('position_controller', backstepping__f=-1.0)
    assert 'backstepping.f = -1.0' in result.reason
    result, = robot.set('plant', hold_at=0.0)
    assert result.successful, result.reason
    robot.finish()
    recording = robot.recording()
    assert not recording.problems
    assert recording.samples[-1].time == 2.0
    return recording.samples


def test_without_what_humble_lacks_a_run_and_a_live_change_work(robot, like_humble):
    samples = _run(robot)
    # it started beside the path
    assert max(abs(sample.tick.error.lateral) for sample in samples) > 0.01


def test_what_humble_lacks_is_really_absent(like_humble):
    code = ('from rclpy.node import Node\n'
            'from mobile_robot_control.ros.spin import make_executor\n'
            'import rclpy\n'
            'rclpy.init()\n'
            'print(type(make_executor()).__name__, hasattr(Node, "add_post_set_parameters_callback"))\n')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ['SingleThreadedExecutor', 'False']
