"""`experiment --node`: the smallest nodes of docs/lockstep.md, ours as commands, and nodes that go wrong."""

import json
import random
import shlex
import subprocess
import sys
import time
from pathlib import Path

import pytest
from helpers import faulty_node
from helpers.harness import CONFIG, run_command, start_experiment
from helpers.processes import processes_of, wait_until

from mobile_robot_control.experiment.node_processes import PROFILES_VARIABLES
from mobile_robot_control.runs import bag
from mobile_robot_control.runs.rollout import rollout
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load

EXAMPLES = Path(__file__).parents[2] / 'examples' / 'foreign_nodes'
BACKSTEPPING = ('--params-file', CONFIG / 'backstepping.yaml')
FAST = 'plant.real_time_factor:=0.0'
OURS = ('plant', 'velocity_controller', 'position_controller', 'reference_cart')
OF_THE_EXAMPLES = {
    'position_controller': [], 'reference_cart': ['reference_cart.curve:=circle'], 'plant': ['plant.drive:=velocity']}


@pytest.fixture
def busy():
    """Two busy loops beside the run."""
    loops = [subprocess.Popen([sys.executable, '-c', 'while True: pass']) for _ in range(2)]
    yield
    for loop in loops:
        loop.kill()
        loop.wait()


def _command(name, *words):
    return f'{name}={shlex.join(map(str, [sys.executable, *words]))}'


def _run(output, name, words, *options, overrides=(), duration=1):
    return run_command('experiment', '--duration', duration, '--output', output, *BACKSTEPPING,
                       *(word for one in (FAST, *overrides) for word in ('-p', one)), '--node',
                       _command(name, *words), *options)


def _assert_equal(output, overrides, duration=1.0, namespace='/'):
    """The recorded run has the numbers of one in this process."""
    simulated = list(rollout(configure(load([CONFIG / 'backstepping.yaml'], overrides)), duration))
    recording = bag.read_bag(output / 'bag', namespace)
    samples = recording.samples
    # of what nobody waits for
    assert not [problem for problem in recording.problems if not problem.startswith('no messages on ')]
    at = {sample.tick.time: sample for sample in simulated}
    ticks = {sample.tick.time: sample for sample in samples}
    assert len(ticks) == round(duration * 100) + 1
    for when, sample in ticks.items():
        for recorded, ours in ((sample.tick.pose, at[when].tick.pose), (sample.command, at[when].command),
                               (sample.tick.error, at[when].tick.error)):
            assert recorded == pytest.approx(ours, rel=1e-9, abs=1e-9), when


@pytest.mark.parametrize('name', ['plant', *(
    pytest.param(one, marks=pytest.mark.soak) for one in ('reference_cart', 'position_controller'))])
def test_the_smallest_nodes_have_the_numbers_of_ours(domain, tmp_path, name):
    overrides = OF_THE_EXAMPLES[name]
    done = _run(tmp_path / 'run', name, [EXAMPLES / f'{name}.py'], '--namespace', '/robot1', overrides=overrides)
    assert done.returncode == 0, done.stderr
    assert not processes_of(EXAMPLES)
    _assert_equal(tmp_path / 'run', overrides, namespace='/robot1')
    node = json.loads((tmp_path / 'run' / 'metrics.json').read_text())['provenance']['nodes'][name]
    assert node['command'] == f'{sys.executable} {EXAMPLES / f"{name}.py"}'
    assert len(node['sha256']) == 64
    page = (tmp_path / 'run' / 'report.html').read_text()
    assert f'{name} was the command' in page
    # a plant without `paused` and `hold_at` is driven without flow control
    assert (name == 'plant') == ('nothing held it for the recorder' in page) == ('flow_control' in node)


@pytest.mark.soak
@pytest.mark.parametrize('name', OURS)
def test_our_own_nodes_as_commands_have_the_numbers_of_the_rollout_on_a_busy_machine(domain, tmp_path, name, busy):
    for number, options in enumerate(([], ['--composed'])):
        done = _run(tmp_path / str(number), name, ['-m', 'mobile_robot_control.ros.start.executables', name],
                    '--no-report', *options)
        assert done.returncode == 0, done.stderr
        _assert_equal(tmp_path / str(number), [])
        assert 'flow_control' not in json.loads(
            (tmp_path / str(number) / 'metrics.json').read_text())['provenance']['nodes'][name]


@pytest.mark.soak
@pytest.mark.parametrize('options', [(), ('--composed',)])
def test_a_plant_that_asks_already_is_recorded_from_its_first_question(domain, tmp_path, options):
    plant = subprocess.Popen([sys.executable, EXAMPLES / 'plant.py'])
    try:
        done = run_command('experiment', '--duration', 1, '--output', tmp_path / 'run', *BACKSTEPPING, '--no-report',
                           '-p', 'plant.drive:=velocity', '--attach', 'plant', '--yes', *options)
        assert done.returncode == 0, done.stderr
        assert plant.poll() is None
        _assert_equal(tmp_path / 'run', OF_THE_EXAMPLES['plant'])
    finally:
        plant.kill()
        plant.wait()


@pytest.mark.soak
def test_a_replay_needs_the_same_command_and_equals_the_run(domain, tmp_path):
    first, again = tmp_path / 'first', tmp_path / 'again'
    node = ('--node', _command('position_controller', EXAMPLES / 'position_controller.py'))
    assert run_command('experiment', '--duration', 1, '--output', first, *BACKSTEPPING, '-p', FAST, '--no-report',
                       *node).returncode == 0
    replay = ('experiment', '--replay', first, '--output', again, '--no-report', '-p', FAST)
    refused = run_command(*replay)
    assert refused.returncode == 2
    assert 'position_controller was the command' in refused.stderr
    done = run_command(*replay, *node)
    assert done.returncode == 0, done.stderr
    assert 'the replay equals the recorded run to the last bit' in done.stderr


@pytest.mark.soak
@pytest.mark.parametrize('name', ['plant', 'position_controller'])
def test_a_recorder_that_is_killed_leaves_no_node_of_somebody_else(domain, tmp_path, name):
    run = start_experiment(tmp_path / 'run', '--duration', 600, *BACKSTEPPING, *(
        word for one in OF_THE_EXAMPLES[name] for word in ('-p', one)), '--node',
        _command(name, EXAMPLES / f'{name}.py'))
    run.kill()
    run.communicate(timeout=120)
    wait_until(lambda: not processes_of(tmp_path / 'run'), 15.0)
    assert name in json.loads((tmp_path / 'run' / 'metrics.json').read_text())['provenance']['nodes']


@pytest.mark.soak
@pytest.mark.parametrize('name', ['position_controller', 'plant'])
def test_a_node_with_other_settings_of_dds_takes_part(domain, tmp_path, name):
    without = [word for variable in PROFILES_VARIABLES for word in ('-u', variable)]
    done = run_command('experiment', '--duration', 1, '--output', tmp_path / 'run', '--no-report', *BACKSTEPPING, *(
        word for one in (FAST, *OF_THE_EXAMPLES[name]) for word in ('-p', one)), '--node',
        f'{name}={shlex.join(map(str, ["env", *without, sys.executable, EXAMPLES / f"{name}.py"]))}')
    assert done.returncode == 0, done.stderr
    _assert_equal(tmp_path / 'run', OF_THE_EXAMPLES[name])


@pytest.mark.soak
@pytest.mark.parametrize('name', OURS)
def test_on_the_wall_clock_the_page_says_what_cannot_be_repeated(domain, tmp_path, name):
    done = run_command('experiment', '--duration', 2, '--output', tmp_path / 'run', '--params-file',
                       CONFIG / 'wall_clock.yaml', '--no-report', '--node',
                       _command(name, '-m', 'mobile_robot_control.ros.start.executables', name))
    assert done.returncode == 0, done.stderr
    assert f'{name} was the command' in done.stderr
    assert 'neither its times nor its numbers can be repeated' in done.stderr
    assert 1.5 < json.loads((tmp_path / 'run' / 'metrics.json').read_text())['duration'] < 4.0


def _fails(output, name, fault, at):
    begun = time.monotonic()
    done = _run(output, name, [Path(faulty_node.__file__), name, fault, at], '--no-report', '--patience', '3',
                overrides=OF_THE_EXAMPLES[name])
    told = done.stderr.rpartition(f'experiment: {name}')[2]
    assert done.returncode == 1, done.stderr
    assert any(word in told for word in faulty_node.FAULTS[fault]), done.stderr
    assert not processes_of(faulty_node.__file__)
    assert time.monotonic() - begun < 60.0
    measured = json.loads((output / 'metrics.json').read_text())
    assert measured['outcome'] == 'node_died'
    assert name in measured['provenance']['nodes']
    if fault not in ('wrong_type', 'best_effort'):
        assert max(sample.time for sample in bag.read_bag(output / 'bag').samples) > at - 0.03


@pytest.mark.parametrize(('name', 'fault'), [
    ('position_controller', 'past'), pytest.param('plant', 'dies', marks=pytest.mark.soak)])
def test_a_node_that_goes_wrong_ends_the_run_with_its_name_and_reason(domain, tmp_path, name, fault):
    _fails(tmp_path / 'run', name, fault, 0.3)


@pytest.mark.soak
@pytest.mark.parametrize('seed', range(40))
def test_drawn_faults_end_as_said(domain, tmp_path, seed):
    draw = random.Random(seed)  # noqa: S311 (no secret)
    names, faults = sorted(OF_THE_EXAMPLES), sorted(faulty_node.FAULTS)
    # every fault three times
    _fails(tmp_path / 'run', draw.choice(names), faults[seed % len(faults)], round(draw.uniform(0.05, 0.95), 2))
