"""SIGINT and SIGTERM end every node with exit 0 and without a traceback."""

import signal
import subprocess
import sys
import time

import pytest

from mobile_robot_control.parameters.nodes import NODES


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_running_nodes_end_clean(robot, number):
    robot.start(arguments=['-p', 'peer_timeout:=60.0'])
    robot.spin_until(lambda: robot.time() > 0.5)
    for process in robot.processes.values():
        process.signal(number)
    robot.spin_until(lambda: all(process.exit_code() is not None for process in robot.processes.values()), 10.0)
    assert [process.exit_code() for process in robot.processes.values()] == [0, 0, 0, 0]
    for name in NODES:
        lines = robot.log(name).splitlines()
        assert [word for line, word in zip(lines, ('waiting for', 'a run begins', 'ended at t ='), strict=True)
                if word not in line] == []


@pytest.mark.parametrize('delay', [0.15, 0.25, 0.35, 0.5, 0.8])
def test_a_signal_during_the_start_is_heard(domain, delay):
    node = subprocess.Popen(
        [sys.executable, '-m', 'mobile_robot_control.ros.executables', 'plant'],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )
    time.sleep(delay)  # the moment is what is tested
    node.send_signal(signal.SIGTERM)
    output, _ = node.communicate(timeout=10.0)
    assert node.returncode == 0
    assert [line for line in output.splitlines() if b'waiting for' not in line and b'ended' not in line] == []


def test_nodes_end_with_whoever_started_them(robot):
    robot.start('plant')
    robot.listen(0.7)
    robot.processes['plant']._process.stdin.close()
    robot.spin_until(lambda: robot.processes['plant'].exit_code() == 0, 5.0)
