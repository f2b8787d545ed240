"""A process that hangs in a library, deaf to signals or while it ends, is ended, with its nodes."""

import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
import rclpy
from helpers.processes import wait_until

from mobile_robot_control.experiment import command as experiment

START = """
import ctypes, subprocess, time
from mobile_robot_control.system.supervisor import Supervisor
from mobile_robot_control.ros.shared.process import Stop
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


@pytest.mark.parametrize(('then', 'limits', 'number', 'end'), [
    (HANG, {'seconds': 0.5}, None, signal.SIGKILL), (HANG, {'grace': 0.2}, signal.SIGTERM, signal.SIGKILL),
    (HANG, {'grace': 0.2}, signal.SIGINT, signal.SIGKILL), (HANG, {'grace': 0.2}, signal.SIGHUP, signal.SIGKILL),
    ('import os; os.abort()', {'grace': 0.2}, None, signal.SIGABRT)])
def test_a_process_that_hangs_or_died_is_killed_with_its_nodes(start, then, limits, number, end):
    process, node = start(then, **limits)
    if number:
        process.send_signal(number)
    _, errors = process.communicate(timeout=50)
    assert process.returncode == -end
    assert ('experiment: ROS 2 has not answered for too long' in errors) == (end == signal.SIGKILL)
    wait_until(lambda: state(node) == 'Z')


def test_a_process_that_makes_progress_is_left_alone(start):
    process, node = start(WORK, seconds=1e300, grace=4.0)
    process.send_signal(signal.SIGTERM)
    printed, errors = process.communicate(timeout=50)
    assert (process.returncode, printed, errors) == (0, 'ended by itself\n', '')
    assert state(node) == 'Z'


def test_a_process_that_is_stopped_is_left_alone_until_it_goes_on(start):
    process, node = start(STOPS + HANG, seconds=0.3)
    wait_until(lambda: state(process.pid) == 'T')
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(timeout=1.0)
    process.send_signal(signal.SIGCONT)
    assert process.wait(timeout=50) == -signal.SIGKILL
    wait_until(lambda: state(node) == 'Z')


def test_an_experiment_for_which_nothing_can_start_ends_with_exit_code_1(tmp_path, monkeypatch, capsys):
    def fail(**_):
        raise RuntimeError('pthread_create failed: Resource temporarily unavailable')

    monkeypatch.delenv('ROS_DOMAIN_ID')
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', 'of the user')
    monkeypatch.setattr(experiment, 'Stop', lambda: SimpleNamespace(requested=False))
    monkeypatch.setattr(rclpy, 'init', fail)
    assert experiment.main(['--duration', '1', '--output', str(tmp_path / 'run'), '--no-report']) == 1
    assert ('experiment: ROS 2: pthread_create failed: Resource temporarily unavailable; the machine or its limits '
            '(ulimit) may leave too little room\n') in capsys.readouterr().err


LEAVES = 'import ctypes, time; from mobile_robot_control.system.supervisor import exit_after; '
# holds the interpreter's lock
HANGS = LEAVES + 'print("last line")\nwith exit_after(1, {}): ctypes.PyDLL(None).sleep(60)'
IN_TIME = LEAVES + '\nwith exit_after(1, 7): pass\ntime.sleep(1.5)'
FAILS = LEAVES + '\ntry:\n with exit_after(1, 7): [][0]\nexcept IndexError: time.sleep(1.5)'


def test_a_process_that_hangs_while_it_ends_keeps_its_exit_code_as_one_that_does_not():
    for code, script, printed in (
            (0, HANGS, 'last line\n'), (3, HANGS, 'last line\n'), (0, IN_TIME, ''), (0, FAILS, '')):
        begun = time.monotonic()
        done = subprocess.run([sys.executable, '-c', script.format(code)], capture_output=True, text=True, timeout=50,
                              check=False)
        assert (done.returncode, done.stdout) == (code, printed)
        assert time.monotonic() - begun < 40.0


# the globals of a module are deleted after Python has restored the signals' defaults
LATE = """
import os, signal
from mobile_robot_control.ros.shared.process import Stop
Stop()
class Late:
    def __del__(self, kill=os.kill, process=os.getpid(), number=signal.{}):
        kill(process, number)
late = Late()
"""


def test_nohup_outlasts_a_closed_terminal():
    stays = LATE.replace('late = Late()', 'os.kill(os.getpid(), signal.SIGHUP); print(Stop().requested)')
    done = subprocess.run(['nohup', sys.executable, '-c', stays.format('SIGHUP')], capture_output=True, text=True,
                          check=False)
    assert (done.returncode, done.stdout) == (0, 'False\n')


def test_a_signal_that_comes_while_a_process_ends_leaves_its_exit_code():
    for name in ('SIGINT', 'SIGTERM', 'SIGHUP'):
        assert subprocess.run([sys.executable, '-c', LATE.format(name)], check=False).returncode == 0
