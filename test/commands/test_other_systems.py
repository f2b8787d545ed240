"""The core on systems without the names of POSIX, as on Windows: they are taken away from this one."""

import json
import os
import subprocess
import sys

import pytest

WITHOUT = """
import os, signal, sys
for name in ('SIGHUP', 'SIGQUIT', 'SIGUSR1', 'SIGKILL'):
    delattr(signal, name)
for name in ('fork', 'geteuid', 'getuid', 'sched_getaffinity', 'setsid', 'killpg', 'mkfifo'):
    delattr(os, name)
sys.modules.update(dict.fromkeys(('fcntl', 'resource', 'termios', 'pwd')))
"""


@pytest.fixture
def run(tmp_path):
    """Run a command, and all processes that it starts, without these names."""
    (tmp_path / 'sitecustomize.py').write_text(WITHOUT)

    def done(command, *words):
        found = subprocess.run(
            [sys.executable, '-m', 'mobile_robot_control', command, *words], cwd=tmp_path, text=True, timeout=300,
            capture_output=True, check=False, env=os.environ | {'PYTHONPATH': str(tmp_path), 'ROS_DOMAIN_ID': '1'})
        assert found.returncode == 0, found.stderr
        return tmp_path

    return done


def test_a_simulation_is_run_and_reported_without_posix(run):
    folder = run('simulate', '--duration', '0.2', '--output', 'run.csv')
    run('report', 'run.csv', '--output', 'report')
    assert json.loads((folder / 'report' / 'report.json').read_text())


@pytest.mark.soak
def test_a_benchmark_spawns_its_workers_without_posix(run):
    folder = run('benchmark', '--laws', 'kanayama', 'ramsete', '--tracks', 'on_curve', '--workers', '2', '--budgets',
                 '25', '--scenarios', '1', '--runs', '2', '--restarts', '0', '--output', 'out')
    rows = [row.split(',') for row in (folder / 'out' / 'benchmark.csv').read_text().splitlines()]
    assert [law for _, law, kind, *_ in rows if kind == 'searched'] == ['kanayama', 'ramsete']


@pytest.mark.parametrize('command', [
    ['experiment', '--duration', '0.1', '--output', 'out'], ['dashboard', '--port', '0', '--output', 'out']])
def test_commands_of_nodes_say_that_ros_is_missing(tmp_path, command):
    (tmp_path / 'rclpy.py').write_text("raise ModuleNotFoundError(\"No module named 'rclpy'\")")
    module = {'experiment': 'experiment.command', 'dashboard': 'dashboard.command'}[command[0]]
    # no node starts, in whatever domain
    done = subprocess.run([sys.executable, '-m', f'mobile_robot_control.{module}', *command[1:]], cwd=tmp_path,
                          capture_output=True, text=True, check=False,
                          env=os.environ | {'PYTHONPATH': str(tmp_path), 'ROS_DOMAIN_ID': '1'})
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith(f'{command[0]}: ROS 2 cannot be loaded: ModuleNotFoundError')
    assert 'Traceback' not in done.stderr
