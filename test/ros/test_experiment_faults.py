"""The command `experiment` when its recorder is killed, its disk is full or a library hangs, and on the wall clock."""

import json
import os
import random
import re
import signal
import subprocess
import sys
import time

import pytest
from helpers.harness import CONFIG, run_command, start_experiment
from helpers.processes import processes_of, wait_until

from mobile_robot_control.runs import bag


@pytest.mark.parametrize('moment', [0.0, *(pytest.param(at, marks=pytest.mark.soak) for at in (1.0, 4.0))])
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
        done = run_command('experiment', '--duration', 60, '--output', disk / 'run', '--composed',
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


# as OpenBLAS does under NumPy where it finds no memory; signals find no Python code that runs
HANGS = """
import ctypes, sys
if {where}:
    lock, mutex = ctypes.PyDLL(None).pthread_mutex_lock, ctypes.create_string_buffer(64)
    lock(mutex)
    lock(mutex)
"""


@pytest.mark.soak
@pytest.mark.parametrize(('module', 'where', 'stop', 'code', 'told'), [
    ('numpy', 'True', False, -signal.SIGKILL, 'ROS 2 has not answered for too long'),
    ('numpy', 'True', True, -signal.SIGKILL, 'ROS 2 has not answered for too long'),
    ('sitecustomize', "'ros.start.executables' in ' '.join(sys.orig_argv)", False, 1, 'plant gave no answer')])
def test_what_hangs_while_an_experiment_starts_is_ended(domain, tmp_path, monkeypatch, module, where, stop, code, told):
    (tmp_path / f'{module}.py').write_text(HANGS.format(where=where))
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get('PYTHONPATH')])]))
    run = subprocess.Popen([sys.executable, '-m', 'mobile_robot_control.experiment.command', '--duration', '1',
                            '--patience', '3', '--output', str(tmp_path / 'run')], stdout=subprocess.PIPE,
                           stderr=subprocess.PIPE, text=True)
    wait_until((tmp_path / 'run' / 'log').exists, 30.0)
    if stop:
        run.terminate()
    _, errors = run.communicate(timeout=120)
    assert run.returncode == code
    assert told in errors
    assert not processes_of(tmp_path)


# whether by the command or by garbage collection
LEAVING = '''
import gc, sys, time
import rclpy
from mobile_robot_control.experiment.command import main
from mobile_robot_control.experiment import evaluation
from mobile_robot_control.experiment.recorder import Recorder
evaluate = evaluation.evaluate
evaluation.evaluate = lambda *given, **named: (gc.collect(), evaluate(*given, **named))[1]
Recorder.__del__ = lambda _: time.sleep(600.0)
rclpy.try_shutdown = lambda: time.sleep(600.0) if rclpy.ok() else None
sys.exit(main(sys.argv[1:]))
'''


def test_a_run_on_the_wall_clock_is_evaluated_from_its_start_though_dds_cannot_be_left(domain, tmp_path):
    output = tmp_path / 'run'
    done = subprocess.run([sys.executable, '-c', LEAVING, '--duration', '2', '--output', output, '--no-report',
                           '--composed', '--params-file', CONFIG / 'wall_clock.yaml'],
                          capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert 'bag and metrics: ' in done.stdout
    metrics, samples = json.loads((output / 'metrics.json').read_text()), bag.read_bag(output / 'bag').samples
    assert metrics['outcome'] == 'completed'
    # how long 400 steps take, and how well the robot tracks, depends on the load of the machine
    assert metrics['duration'] > 1.7
    assert metrics['rms_position_error'] > 0.0
    # at rest at the start of the curve, and then the steps of the plant
    assert samples[0].tick.pose == pytest.approx((1.0, 0.0, 1.5707963), abs=0.05)
    assert samples[0].time < 0.3
    assert 340 < len(samples) <= 401
