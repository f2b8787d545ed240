"""The command `experiment`: the files that it writes, and how it ends when a run fails."""

import json
import os
import signal
import time

import pytest
from harness import CONFIG, experiment, run_command, start_experiment
from mcap_ros2.reader import read_ros2_messages
from processes import processes_of

from mobile_robot_control.cli import simulate
from mobile_robot_control.runs import bag


def test_experiment_and_simulate_give_the_same_metrics(domain, tmp_path, capsys):
    run = ['--duration', '2', '--params-file', str(CONFIG / 'fuzzy.yaml')]
    metrics, _ = experiment(tmp_path / 'run', *run, '--composed', report=True)
    assert simulate.main([*run, '--json']) == 0
    simulated = json.loads(capsys.readouterr().out)
    assert set(metrics) == set(simulated)
    assert metrics.pop('outcome') == simulated.pop('outcome') == 'completed'
    assert metrics.pop('error') == simulated.pop('error') == 'true'
    # this law is not within the band yet
    assert metrics.pop('settling_time') is simulated.pop('settling_time') is None
    for name, value in simulated.items():
        assert metrics[name] == pytest.approx(value, rel=1e-9, abs=1e-9)
    assert (tmp_path / 'run' / 'figures' / 'path.png').read_bytes().startswith(b'\x89PNG')
    assert 'data:image/svg+xml' in (tmp_path / 'run' / 'report.html').read_text()


def test_an_experiment_in_a_namespace_is_recorded_and_read_by_the_mcap_library(domain, tmp_path):
    output = tmp_path / 'run'
    done = run_command('experiment', '--duration', 1, '--output', output, '--namespace', '/robot1', '--no-report',
                       '-p', 'plant.real_time_factor:=0.0', '--params-file', CONFIG / 'hybrid_backstepping.yaml',
                       '--robot', 'chapter')
    assert done.returncode == 0, done.stderr
    assert (output / 'parameters.yaml').read_text().startswith('# robot: chapter\n')
    recording = bag.read_bag(output / 'bag', '/robot1')
    assert len(recording.samples) == 501
    assert not recording.problems
    topics = {}
    for message in read_ros2_messages(output / 'bag' / 'bag.mcap'):
        topics.setdefault(message.channel.topic, []).append(message.ros_msg)
    of_the_robot = {'odom', 'joint_states', 'reference', 'cmd_vel', 'wheel_torques', 'tracking_error', 'reference_path'}
    assert {'/clock', '/parameter_events', *(f'/robot1/{name}' for name in of_the_robot)} <= set(topics)
    assert topics['/robot1/joint_states'][-1].header.stamp.sec == 1
    assert list(topics['/robot1/wheel_torques'][0].name) == ['wheel_right_joint', 'wheel_left_joint']
    assert 'storage_identifier: mcap' in (output / 'bag' / 'metadata.yaml').read_text()


def test_a_recorder_that_stalls_misses_no_message(domain, tmp_path):
    """The run waits for the recorder: in the time of the stall, publishers would overrun their queues three times."""
    output = tmp_path / 'run'
    run = start_experiment(output, '--duration', 12, '-p', 'plant.real_time_factor:=0.0', '--composed')
    os.kill(run.pid, signal.SIGSTOP)
    time.sleep(1.5)
    os.kill(run.pid, signal.SIGCONT)
    _, errors = run.communicate(timeout=120)
    assert run.returncode == 0, errors
    recording = bag.read_bag(output / 'bag')
    assert not recording.problems
    assert len(recording.samples) == 6001


@pytest.mark.parametrize('name', [pytest.param('position_controller', marks=pytest.mark.soak), 'plant'])
def test_a_node_that_dies_is_named(domain, tmp_path, name):
    output = tmp_path / 'run'
    run = start_experiment(output, '--duration', 30)
    os.kill(*processes_of(output, name), signal.SIGKILL)
    _, errors = run.communicate(timeout=120)
    assert run.returncode == 1
    assert f'{name} was killed by SIGKILL' in errors
    assert 'Traceback' not in errors
    metrics = json.loads((output / 'metrics.json').read_text())
    assert metrics['outcome'] == 'node_died'
    assert 0.0 < metrics['duration'] < 30.0
    assert bag.read_bag(output / 'bag').samples[-1].time == metrics['duration']
    assert not processes_of(output)


def test_a_node_that_hangs_is_named(domain, tmp_path):
    output = tmp_path / 'run'
    # another node may be without a turn for a second or two
    run = start_experiment(output, '--duration', 30, '--patience', 5)
    os.kill(*processes_of(output, 'reference_cart'), signal.SIGSTOP)
    _, errors = run.communicate(timeout=120)
    assert run.returncode == 1
    assert 'reference_cart gave no answer for 5.0 s' in errors
    assert json.loads((output / 'metrics.json').read_text())['outcome'] == 'node_died'
    assert bag.read_bag(output / 'bag').samples


def test_divergence_ends_with_exit_code_1(domain, tmp_path):
    output = tmp_path / 'run'
    done = run_command('experiment', '--duration', 60, '--output', output, '--no-report', '--composed', '-p',
                       'plant.real_time_factor:=0.0', '-p', 'plant.initial_pose:=[1.0, 0.5, 1.0]', '-p',
                       'position_controller.controller_type:=backstepping', '-p',
                       'position_controller.backstepping.q:=1e12')
    assert done.returncode == 1
    assert 'the motion diverged' in done.stderr
    assert json.loads((output / 'metrics.json').read_text())['outcome'] == 'diverged'


@pytest.mark.parametrize(('number', 'report'), [
    (signal.SIGINT, False), pytest.param(signal.SIGTERM, True, marks=pytest.mark.soak)])
def test_an_interrupted_run_has_a_complete_bag_and_metrics(domain, tmp_path, number, report):
    output = tmp_path / 'run'
    run = start_experiment(output, '--duration', 60, report=report)
    run.send_signal(number)
    _, errors = run.communicate(timeout=120)
    assert run.returncode == 1, errors
    assert 'Traceback' not in errors
    metrics = json.loads((output / 'metrics.json').read_text())
    assert metrics['outcome'] == 'interrupted'
    assert bag.read_bag(output / 'bag').samples[-1].time == metrics['duration'] > 0.0
    assert not processes_of(output)
    assert (output / 'report.html').exists() == report


def test_another_robot_on_the_same_topics_is_refused(robot, tmp_path):
    robot.start('plant')
    robot.spin_until(lambda: 'odom' in robot.recorder.newest)
    done = run_command('experiment', '--duration', 1, '--output', tmp_path / 'run')
    assert done.returncode == 2
    assert 'another node publishes on' in done.stderr
    assert not (tmp_path / 'run').exists()


def test_overwrite_replaces_what_an_experiment_wrote_and_nothing_else(domain, tmp_path, monkeypatch):
    # nothing is written there, so it runs without
    monkeypatch.setenv('HOME', '/dev/null')
    (tmp_path / 'notes.txt').write_text('mine')
    experiment(tmp_path, '--duration', 0.2, '--composed')
    # as if that experiment had drawn them
    (tmp_path / 'figures').mkdir()
    for name in ('report.html', 'figures/path.png'):
        (tmp_path / name).write_text('old')
    experiment(tmp_path, '--duration', 0.4, '--composed', '--overwrite')
    assert json.loads((tmp_path / 'metrics.json').read_text())['duration'] == 0.4
    assert not [name for name in ('report.html', 'figures') if (tmp_path / name).exists()]
    assert (tmp_path / 'notes.txt').read_text() == 'mine'


@pytest.mark.parametrize(('name', 'value', 'refusal'), [
    ('ROS_DOMAIN_ID', 'abc', "ROS_DOMAIN_ID = 'abc' is no ROS domain"),
    ('RMW_IMPLEMENTATION', 'nonsense', "RMW_IMPLEMENTATION = 'nonsense' is not installed"),
    ('ROS_STATIC_PEERS', 'nonsense', 'Unable to resolve peer nonsense'),
])
def test_an_environment_that_ros_refuses_leaves_nothing_behind(domain, tmp_path, monkeypatch, name, value, refusal):
    monkeypatch.setenv(name, value)
    done = run_command('experiment', '--duration', 1, '--output', tmp_path / 'new' / 'run')
    assert done.returncode == 2, done.stderr
    assert refusal in done.stderr
    assert 'Traceback' not in done.stderr
    assert not list(tmp_path.iterdir())
