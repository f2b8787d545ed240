"""SIGINT and SIGTERM end every node with exit 0 and without a traceback."""

import signal
import subprocess
import sys
import time

import pytest
from processes import catches_sigterm, wait_until

from mobile_robot_control.configuration.nodes import NODES


@pytest.mark.parametrize('number', [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.soak)])
def test_running_nodes_end_with_exit_code_0_and_print_nothing(robot, number):
    robot.start(arguments=['-p', 'peer_timeout:=60.0'])
    robot.spin_until(lambda: robot.time() > 0.5)
    robot.stop(number=number)
    for name in NODES:
        lines = robot.log(name).splitlines()
        assert [word for line, word in zip(lines, ('waiting for', 'a run begins', 'ended at t ='), strict=True)
                if word not in line] == []


@pytest.mark.parametrize('delay', [0.0, 0.1, 0.2, 0.35, 0.65])
def test_a_signal_during_the_start_ends_the_node(domain, delay):
    node = subprocess.Popen(
        [sys.executable, '-m', 'mobile_robot_control.ros.executables', 'plant'],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )
    wait_until(lambda: catches_sigterm(node.pid))
    time.sleep(delay)  # the moment is what is tested
    node.send_signal(signal.SIGTERM)
    output, _ = node.communicate(timeout=60)
    assert node.returncode == 0
    assert [line for line in output.splitlines() if b'waiting for' not in line and b'ended' not in line] == []


def test_a_node_ends_when_its_standard_input_closes(robot):
    robot.start('plant')
    robot.listen(0.7)
    robot.processes['plant'].close_input()
    robot.finish()
