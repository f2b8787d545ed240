"""The command `experiment` when its recorder is killed or its disk is full, and on the wall clock."""

import json
import os
import random
import re
import signal
import subprocess
import sys
import time

import pytest
from harness import CONFIG, run_command, start_experiment
from processes import processes_of, wait_until

from mobile_robot_control.runs import bag

WALL_CLOCK = ['--params-file', CONFIG / 'wall_clock.yaml']


@pytest.mark.parametrize('moment', [0.0, pytest.param(1.0, marks=pytest.mark.soak),
                                    pytest.param(4.0, marks=pytest.mark.soak)])
def test_a_recorder_that_is_killed_leaves_a_bag_and_no_process(domain, tmp_path, moment):
    output = tmp_path / 'run'
    run = start_experiment(output, '--duration', 60)
    time.sleep(moment + random.Random(moment).random())  # noqa: S311 (no secret)
    run.kill()
    _, errors = run.communicate(timeout=120)
    wait_until(lambda: not processes_of(output))
    recording = bag.read_bag(output / 'bag')
    assert any('the recording was cut off' in problem for problem in recording.problems)
    assert recording.samples[-1].time > 0.0
    # half a second may not have been written, and the plant is at most a second ahead of the recorder
    shown = [float(found) for found in re.findall(r'\| (\d+\.\d)/', errors)] or [1.0]
    assert recording.samples[-1].time > shown[-1] - 1.5
    assert (output / 'bag' / 'metadata.yaml').is_file()


@pytest.mark.skipif(os.geteuid() != 0, reason='a disk of its own needs the right to mount')
def test_a_full_disk_ends_the_run_with_a_message(domain, tmp_path):
    disk = tmp_path / 'disk'
    disk.mkdir()
    if subprocess.run(['mount', '-t', 'tmpfs', '-o', 'size=512k', 'tmpfs', disk], capture_output=True,
                      check=False).returncode:
        pytest.skip('may not mount')
    try:
        done = run_command('experiment', '--duration', 60, '--output', disk / 'run',
                           '-p', 'plant.real_time_factor:=0.0')
        assert done.returncode == 1
        assert f'{disk}/run/bag/bag.mcap: No space left on device; make room there' in done.stderr
        assert 'Traceback' not in done.stderr
        assert not processes_of(disk / 'run')
        assert 'was interrupted after' in done.stdout
        # a file that could not be written either is named, and does not exist in part
        for name in ('metrics.json', 'report.html'):
            assert (disk / 'run' / name).exists() != (f'{name}: No space left on device' in done.stderr)
        assert bag.read_bag(disk / 'run' / 'bag').samples[-1].time > 0.1
    finally:
        subprocess.run(['umount', disk], check=True)


@pytest.mark.soak
def test_a_folder_that_is_removed_ends_the_run_with_a_message(domain, tmp_path):
    output = tmp_path / 'run'
    run = start_experiment(output, '--duration', 60)
    (output / 'bag' / 'bag.mcap').unlink()
    _, errors = run.communicate(timeout=120)
    assert run.returncode == 1
    assert 'bag.mcap: was removed while it was written' in errors
    assert 'Traceback' not in errors
    assert not processes_of(output)


def test_on_the_wall_clock_a_run_is_recorded_from_its_start(domain, tmp_path):
    output = tmp_path / 'run'
    done = run_command('experiment', '--duration', 2, '--output', output, '--no-report', *WALL_CLOCK)
    assert done.returncode == 0, done.stderr
    metrics = json.loads((output / 'metrics.json').read_text())
    assert metrics['outcome'] == 'completed'
    # how long 400 steps take, and how well the robot tracks, depends on the load of the machine
    assert metrics['duration'] > 1.7
    assert metrics['rms_position_error'] > 0.0
    samples = bag.read_bag(output / 'bag').samples
    # at rest at the start of the curve, and then the steps of the plant
    assert samples[0].tick.pose == pytest.approx((1.0, 0.0, 1.5707963), abs=0.05)
    assert samples[0].time < 0.3
    assert 340 < len(samples) <= 401


@pytest.mark.soak
def test_on_the_wall_clock_an_interrupted_run_has_a_complete_bag(domain, tmp_path):
    output = tmp_path / 'run'
    run = start_experiment(output, '--duration', 60, *WALL_CLOCK, '--composed')
    run.send_signal(signal.SIGINT)
    _, errors = run.communicate(timeout=120)
    assert run.returncode == 1, errors
    assert 'Traceback' not in errors
    assert json.loads((output / 'metrics.json').read_text())['outcome'] == 'interrupted'
    recording = bag.read_bag(output / 'bag')
    assert not [problem for problem in recording.problems if 'cut off' in problem]
    assert recording.samples[-1].time > 0.8
    assert not processes_of(output)


@pytest.mark.soak
def test_on_the_wall_clock_a_node_that_hangs_is_named(domain, tmp_path):
    output = tmp_path / 'run'
    run = start_experiment(output, '--duration', 60, '--patience', 2, *WALL_CLOCK)
    os.kill(*processes_of(output, 'reference_cart'), signal.SIGSTOP)
    _, errors = run.communicate(timeout=40)
    assert run.returncode == 1
    assert 'reference_cart gave no answer for 2.0 s' in errors
    assert json.loads((output / 'metrics.json').read_text())['outcome'] == 'node_died'


# as OpenBLAS does under NumPy where it finds no memory; signals find no Python code that runs
HANGS = """
import ctypes
lock, mutex = ctypes.PyDLL(None).pthread_mutex_lock, ctypes.create_string_buffer(64)
lock(mutex)
lock(mutex)
"""


@pytest.mark.soak
@pytest.mark.parametrize('stop', [False, True])
def test_an_experiment_that_hangs_while_it_starts_is_ended(domain, tmp_path, monkeypatch, stop):
    (tmp_path / 'numpy').mkdir()
    (tmp_path / 'numpy' / '__init__.py').write_text(HANGS)
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get('PYTHONPATH')])]))
    command = [sys.executable, '-m', 'mobile_robot_control.cli.experiment', '--duration', '1', '--patience', '3']
    run = subprocess.Popen([*command, '--output', str(tmp_path / 'run')], stdout=subprocess.PIPE,
                           stderr=subprocess.PIPE)
    wait_until((tmp_path / 'run' / 'log').exists, 30.0)
    if stop:
        run.terminate()
    _, errors = run.communicate(timeout=120)
    assert run.returncode == -signal.SIGKILL
    assert b'ROS 2 has not answered for too long' in errors
    assert not processes_of(tmp_path)


@pytest.mark.soak
def test_nodes_that_hang_while_they_start_are_ended(domain, tmp_path, monkeypatch):
    (tmp_path / 'sitecustomize.py').write_text(
        "import sys\nif 'mobile_robot_control.ros.executables' in sys.orig_argv:\n"
        + ''.join(f'    {line}\n' for line in HANGS.splitlines()))
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get('PYTHONPATH')])]))
    done = run_command('experiment', '--duration', 1, '--patience', 3, '--output', tmp_path / 'run')
    assert done.returncode == 1
    assert 'plant gave no answer' in done.stderr
    assert not processes_of(tmp_path)


LEAVING = '''
import sys, time
import rclpy
from mobile_robot_control.cli.experiment import main
rclpy.try_shutdown = lambda: time.sleep(600.0) if rclpy.ok() else None
sys.exit(main(sys.argv[1:]))
'''


def test_a_run_is_evaluated_although_dds_cannot_be_left(domain, tmp_path):
    done = subprocess.run(
        [sys.executable, '-c', LEAVING, '--duration', '0.2', '--output', str(tmp_path / 'run'), '--composed',
         '--no-report', '-p', 'plant.real_time_factor:=0.0'],
        capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / 'run' / 'metrics.json').read_text())['outcome'] == 'completed'
    assert 'bag and metrics: ' in done.stdout
