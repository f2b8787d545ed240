"""The command `experiment`: the files that it writes, and how it ends when a run fails."""

import json
import os
import re
import signal
import time

import pytest
from helpers.harness import CONFIG, numbers_in, run_command, start_experiment
from helpers.processes import processes_of, threads_of
from mcap_ros2.reader import read_ros2_messages

from mobile_robot_control.runs import bag
from mobile_robot_control.runs import command as simulate

FAST = ('-p', 'plant.real_time_factor:=0.0')
WALL_CLOCK = ('--params-file', CONFIG / 'wall_clock.yaml')


def metrics_of(output):
    return json.loads((output / 'metrics.json').read_text())


def test_a_run_in_a_namespace_has_the_metrics_of_simulate_and_a_diverging_one_replaces_it(
        domain, tmp_path, capsys, monkeypatch):
    run = ['--duration', '1', '--params-file', str(CONFIG / 'fuzzy.yaml'), '--robot', 'chapter']
    done = run_command('experiment', *run, *FAST, '--output', tmp_path, '--namespace', '/robot1', '--composed')
    assert done.returncode == 0, done.stderr
    assert simulate.main([*run, '--json']) == 0
    metrics, simulated = numbers_in(tmp_path / 'metrics.json'), json.loads(capsys.readouterr().out)
    assert set(metrics) == set(simulated)
    assert metrics.pop('outcome') == simulated.pop('outcome') == 'completed'
    assert metrics.pop('error') == simulated.pop('error') == 'true'
    # this law is not within the band yet
    assert metrics.pop('settling_time') is simulated.pop('settling_time') is None
    for name, value in simulated.items():
        assert metrics[name] == pytest.approx(value, rel=1e-9, abs=1e-9)
    assert (tmp_path / 'figures' / 'path.png').read_bytes().startswith(b'\x89PNG')
    assert 'data:image/svg+xml' in (tmp_path / 'report.html').read_text()
    assert (tmp_path / 'parameters.yaml').read_text().startswith('# robot: chapter\n')
    recording = bag.read_bag(tmp_path / 'bag', '/robot1')
    assert len(recording.samples) == 501
    assert not recording.problems
    # others read it, too
    topics = {}
    for message in read_ros2_messages(tmp_path / 'bag' / 'bag.mcap'):
        topics.setdefault(message.channel.topic, []).append(message.ros_msg)
    of_the_robot = {'odom', 'joint_states', 'reference', 'cmd_vel', 'wheel_torques', 'tracking_error', 'reference_path'}
    assert {'/clock', '/parameter_events', *(f'/robot1/{name}' for name in of_the_robot)} <= set(topics)
    assert topics['/robot1/joint_states'][-1].header.stamp.sec == 1
    assert list(topics['/robot1/wheel_torques'][0].name) == ['wheel_right_joint', 'wheel_left_joint']
    assert 'storage_identifier: mcap' in (tmp_path / 'bag' / 'metadata.yaml').read_text()

    (tmp_path / 'notes.txt').write_text('mine')
    # nothing is written there, so it runs without
    monkeypatch.setenv('HOME', '/dev/null')
    done = run_command('experiment', '--duration', 60, *FAST, '--output', tmp_path, '--overwrite', '--no-report',
                       '--composed', *(word for override in (
                           'plant.initial_pose:=[1.0, 0.5, 1.0]', 'position_controller.controller_type:=backstepping',
                           'position_controller.backstepping.q:=1e12') for word in ('-p', override)))
    assert done.returncode == 1
    assert 'the motion diverged' in done.stderr
    assert metrics_of(tmp_path)['outcome'] == 'diverged'
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        'bag', 'log', 'metrics.json', 'notes.txt', 'parameters.yaml']


@pytest.mark.parametrize(('number', 'report', 'options'), [
    (signal.SIGINT, False, FAST),
    pytest.param(signal.SIGTERM, True, FAST, marks=pytest.mark.soak),
    pytest.param(signal.SIGINT, False, WALL_CLOCK, marks=pytest.mark.soak),
])
def test_an_interrupted_run_has_a_complete_bag_and_metrics_though_its_recorder_stalls(
        domain, tmp_path, number, report, options):
    """In lockstep it waits for the recorder: in the time of the stall, publishers would overrun their queues."""
    output = tmp_path / 'run'
    run = start_experiment(output, '--duration', 600, '--composed', *options, report=report)
    shown = ''
    if options is FAST:
        os.kill(run.pid, signal.SIGSTOP)
        time.sleep(1.5)
        os.kill(run.pid, signal.SIGCONT)
        # 10.0 may be 9.95, rounded
        while not re.search(r'\| (?!10\.0)\d\d+\.\d/', shown):
            read = run.stderr.read(1)
            assert read, shown
            shown += read
    run.send_signal(number)
    _, errors = run.communicate(timeout=120)
    assert run.returncode == 1, errors
    assert 'Traceback' not in shown + errors
    metrics, recording = metrics_of(output), bag.read_bag(output / 'bag')
    assert metrics['outcome'] == 'interrupted'
    assert recording.samples[-1].time == metrics['duration'] > 0.8
    if options is FAST:
        assert not recording.problems
        assert len(recording.samples) == round(500 * metrics['duration']) + 1 > 5000
    assert not [problem for problem in recording.problems if 'cut off' in problem]
    assert not processes_of(output)
    assert (output / 'report.html').exists() == report


@pytest.mark.parametrize(('names', 'number', 'told', 'options'), [
    (['plant'], signal.SIGKILL, 'was killed by SIGKILL', ()),
    pytest.param(['position_controller'], signal.SIGKILL, 'was killed by SIGKILL', (), marks=pytest.mark.soak),
    # another node may be without a turn for a second or two
    (['velocity_controller', 'reference_cart'], signal.SIGSTOP, 'gave no answer for 5.0 s', ('--patience', 5)),
    pytest.param(['reference_cart'], signal.SIGSTOP, 'gave no answer for 5.0 s', ('--patience', 5, *WALL_CLOCK),
                 marks=pytest.mark.soak),
])
def test_nodes_that_die_or_hang_are_named(bare_domain, tmp_path, names, number, told, options):
    output = tmp_path / 'run'
    run = start_experiment(output, '--duration', 30, *options)
    threads = [name for process in processes_of(output) for name in threads_of(process)]
    assert [name for name in threads if name.startswith('dds.udp')]
    # a process that is suspended may hold a lock of the shared memory, and others wait for it
    assert not [name for name in threads if name.startswith('dds.shm')]
    for name in names:
        os.kill(*processes_of(output, name), number)
    _, errors = run.communicate(timeout=120)
    assert run.returncode == 1
    assert f'{", ".join(names)} {told}' in errors
    assert 'Traceback' not in errors
    metrics = metrics_of(output)
    assert metrics['outcome'] == 'node_died'
    assert bag.read_bag(output / 'bag').samples[-1].time == metrics['duration']
    assert 0.0 < metrics['duration'] < 30.0
    assert not processes_of(output)


def test_another_robot_on_the_same_topics_is_refused(robot, tmp_path):
    robot.start('plant')
    robot.spin_until(lambda: 'odom' in robot.recorder.newest)
    done = run_command('experiment', '--duration', 1, '--output', tmp_path / 'run')
    assert done.returncode == 2
    assert 'another node publishes on' in done.stderr
    assert not (tmp_path / 'run').exists()


@pytest.mark.parametrize(('name', 'value', 'refusal'), [
    ('ROS_DOMAIN_ID', 'abc', "ROS_DOMAIN_ID = 'abc' is no ROS domain"),
    ('ROS_STATIC_PEERS', 'nonsense', 'Unable to resolve peer nonsense'),
])
def test_an_environment_that_ros_refuses_leaves_nothing_behind(
        bare_domain, tmp_path, monkeypatch, name, value, refusal):
    with monkeypatch.context() as changed:
        changed.setenv(name, value)
        done = run_command('experiment', '--duration', 1, '--output', tmp_path / 'new' / 'run')
    assert done.returncode == 2, done.stderr
    assert refusal in done.stderr
    assert 'Traceback' not in done.stderr
    assert not list(tmp_path.iterdir())
