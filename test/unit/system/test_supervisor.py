"""A process that hangs in a library, deaf to signals, is ended with its nodes."""

import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import rclpy
from processes import wait_until

from mobile_robot_control.cli import experiment
from mobile_robot_control.experiment.fastdds_profiles import PROFILES_VARIABLE

START = """
import ctypes, subprocess, time
from mobile_robot_control.system.supervisor import Supervisor
from mobile_robot_control.ros.services.stop import Stop
stop = Stop()
node = subprocess.Popen(['sleep', '100'], stdin=subprocess.PIPE, stderr=-3)
with Supervisor({seconds}, {grace}) as supervisor:
    supervisor.note_node(node.pid)
    supervisor.note_progress()
    print(node.pid, flush=True)
    {then}
node.kill()
node.wait()
print('ended by itself')
"""
HANG = """
    # locking a mutex twice waits for ever, with the lock of the interpreter: no handler gets its turn
    lock, mutex = ctypes.PyDLL(None).pthread_mutex_lock, ctypes.create_string_buffer(64)
    lock(mutex)
    lock(mutex)
"""
STOPS = 'import os, signal; os.kill(os.getpid(), signal.SIGSTOP)'
WORK = """
    for _ in range(100):
        time.sleep(0.05)
        supervisor.note_progress()
"""


@pytest.fixture
def start():
    started = []

    def make(then, seconds=60.0, grace=60.0):
        process = subprocess.Popen([sys.executable, '-c', START.format(then=then, seconds=seconds, grace=grace)],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        started.append(process)
        return process, int(process.stdout.readline())

    yield make
    for process in started:
        process.kill()
        process.communicate()


def state(pid):
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0]
    except OSError:
        return 'Z'


def runs(pid):
    return state(pid) != 'Z'


def test_a_process_that_hangs_is_killed_with_its_nodes(start):
    process, node = start(HANG, seconds=0.5)
    _, errors = process.communicate(timeout=50)
    assert process.returncode == -signal.SIGKILL
    assert 'experiment: ROS 2 has not answered for too long' in errors
    wait_until(lambda: not runs(node))


@pytest.mark.parametrize('number', [signal.SIGTERM, signal.SIGINT])
def test_a_process_that_hangs_is_killed_after_a_signal(start, number):
    process, node = start(HANG, grace=0.2)
    process.send_signal(number)
    process.communicate(timeout=50)
    assert process.returncode == -signal.SIGKILL
    wait_until(lambda: not runs(node))


def test_a_process_that_makes_progress_is_left_alone(start):
    process, node = start(WORK, seconds=1e300, grace=4.0)
    process.send_signal(signal.SIGTERM)
    printed, errors = process.communicate(timeout=50)
    assert (process.returncode, printed, errors) == (0, 'ended by itself\n', '')
    assert not runs(node)


def test_a_process_that_is_stopped_is_left_alone_until_it_goes_on(start):
    process, node = start(STOPS + HANG, seconds=0.3)
    wait_until(lambda: state(process.pid) == 'T')
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(timeout=1.0)
    process.send_signal(signal.SIGCONT)
    assert process.wait(timeout=50) == -signal.SIGKILL
    wait_until(lambda: not runs(node))


def test_nodes_of_a_process_that_died_are_killed(start):
    process, node = start('import os; os.abort()', grace=0.2)
    process.communicate(timeout=50)
    assert process.returncode == -signal.SIGABRT
    wait_until(lambda: not runs(node))


def test_an_experiment_for_which_nothing_can_start_ends_with_exit_code_1(tmp_path, monkeypatch, capsys):
    def fail(**_):
        raise RuntimeError('pthread_create failed: Resource temporarily unavailable')

    monkeypatch.delenv('ROS_DOMAIN_ID')
    monkeypatch.setenv(PROFILES_VARIABLE, 'of the user')
    monkeypatch.setattr(experiment, 'Stop', lambda: SimpleNamespace(requested=False))
    monkeypatch.setattr(rclpy, 'init', fail)
    assert experiment.main(['--duration', '1', '--output', str(tmp_path / 'run'), '--no-report']) == 1
    assert ('experiment: ROS 2: pthread_create failed: Resource temporarily unavailable; the machine or its limits '
            '(ulimit) may leave too little room\n') in capsys.readouterr().err
