"""`benchmark --node`: a position controller of somebody else in the judged scenarios, over DDS."""

import csv
import json
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from helpers import faulty_node
from helpers.processes import processes_of, wait_until

EXAMPLE = Path(__file__).parents[2] / 'examples' / 'foreign_nodes' / 'position_controller.py'
OURS = ['-m', 'mobile_robot_control.ros.start.executables', 'position_controller']
MAIN = ('import sys; from mobile_robot_control.benchmarking import command; '
        'from mobile_robot_control.loop import batch; batch.COMPILES = False; sys.exit(command.main())')
TRACK = """
track: {ros__parameters: {purpose: Torques and noise., curves: [trifolium], scales: [0.1], turned: 0.3, laps: 0.25,
    within: 0.02, variation: 0.2, delays: [1, 2]}}
/**: {ros__parameters: {reference_horizon: 1, velocity_rate: 200.0, position_rate: 100.0}}
/**/plant: {ros__parameters: {max_wheel_torque: 3.0, noise: {pose: [0.001, 0.001, 0.001], velocity: 0.01}}}
/**/velocity_controller: {ros__parameters: {max_wheel_torque: 3.0}}
/**/reference_cart: {ros__parameters: {curve: trifolium, scale: 0.1, period: 4.0}}
"""


@pytest.fixture
def track(tmp_path):
    (tmp_path / 'small.yaml').write_text(TRACK)
    return tmp_path / 'small.yaml'


def node(*words):
    return f'mine={shlex.join(map(str, [sys.executable, *words]))}'


def arguments(folder, command, *more, tracks):
    return ['--laws', 'backstepping', '--no-tune', '--runs', '3', '--workers', '1', '--node', command, '--output',
            folder / 'out', *more, '--tracks', *tracks]


def benchmark(folder, *words, compiles=False, timeout=120, **options):
    main = ['-m', 'mobile_robot_control.benchmarking.command'] if compiles else ['-c', MAIN]
    command = [sys.executable, *main, *map(str, arguments(folder, *words, **options))]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)


def judged(folder, law):
    with (folder / 'out' / 'benchmark_runs.csv').open() as file:
        return [row for row in csv.DictReader(file) if row['law'] == law]


def values(folder):
    return json.loads((folder / 'out' / 'benchmark.json').read_text())


def assert_runs_of_the_law(folder, tracks, count):
    """The node has the runs of the law in this process, whose scenarios it has driven."""
    law = {(row['track'], row['run']): row for row in judged(folder, 'backstepping')}
    mine = judged(folder, 'mine')
    assert len(mine) == count * len(tracks)
    for row in mine:
        ours = law[row['track'], row['run']]
        assert (row['success'], row['outcome']) == (ours['success'], 'completed')
        for name in ('rms_position_error', 'max_position_error', 'settling_time', 'peak_wheel_torque',
                     'torque_variation', 'command_variation'):
            assert float(row[name] or 'inf') == pytest.approx(float(ours[name] or 'inf'), rel=1e-9, abs=1e-9), name
    for errors in values(folder)['nodes']['mine']['repeated'].values():
        assert errors[0] == errors[1]


def test_a_node_with_the_numbers_of_a_law_has_its_judged_runs_in_the_table(domain, tmp_path, track):
    done = benchmark(tmp_path, node(EXAMPLE), '--node-runs', 1, tracks=[track])
    assert done.returncode == 0, done.stderr
    assert 'mine (node, not tuned): driven over DDS in 1 scenario of each seed; a repeated run' in done.stdout
    assert_runs_of_the_law(tmp_path, [track], 1)
    assert [row['gains'] for row in values(tmp_path)['results']] == ['configured', 'own']
    assert not processes_of(EXAMPLE)
    assert not (tmp_path / 'out' / 'nodes').exists()


@pytest.mark.soak
def test_our_own_node_has_the_judged_runs_of_every_kind_of_track(domain, tmp_path):
    tracks = ['drift', 'pushed', 'rectangle', 'robot_kobuki', 'robot_turtlebot3_burger', 'published']
    done = benchmark(tmp_path, node(*OURS), '--node-runs', 1, tracks=tracks, compiles=True, timeout=360)
    assert done.returncode == 0, done.stderr
    assert_runs_of_the_law(tmp_path, tracks, 1)


@pytest.mark.soak
def test_a_node_that_dies_in_a_run_fails_it_and_the_others_count(domain, tmp_path, track):
    broken = node(faulty_node.__file__, 'position_controller', 'dies', 0.5)
    done = benchmark(tmp_path, broken, '--node-runs', 2, tracks=[track])
    assert done.returncode == 0, done.stderr
    assert 'mine on small, seed 1, run 2: position_controller ended with exit code 3' in done.stderr
    assert [(row['success'], row['outcome'], row['rms_position_error']) for row in judged(tmp_path, 'mine')] == [
        ('0', 'node_died', '')] * 2
    assert 'fails in most runs on small (position_controller ended' in done.stdout
    assert len([*(tmp_path / 'out' / 'nodes').iterdir()]) == 2


@pytest.mark.soak
def test_a_node_that_never_answers_is_told_at_once_with_the_rest_of_the_table(domain, tmp_path, track):
    done = benchmark(tmp_path, node('-c', 'raise SystemExit(7)'), tracks=[track])
    assert done.returncode == 1
    assert 'mine has commanded nothing: position_controller ended with exit code 7' in done.stderr
    assert [one['law'] for one in values(tmp_path)['unfinished']] == ['mine']
    assert values(tmp_path)['ranks'][0]['law'] == 'backstepping'


@pytest.mark.soak
def test_a_node_that_answers_by_chance_shows_the_spread_of_its_errors(domain, tmp_path, track):
    text = EXAMPLE.read_text().replace('v_r * math.cos(e3)', 'v_r * math.cos(e3) * random.uniform(0.9, 1.1)')
    (tmp_path / 'chance.py').write_text(f'import random\n{text}')
    done = benchmark(tmp_path, node(tmp_path / 'chance.py'), '--node-runs', 1, tracks=[track])
    assert done.returncode == 0, done.stderr
    errors = values(tmp_path)['nodes']['mine']['repeated']['small']
    assert len({*errors}) == 5
    assert f'5 runs of one scenario have an RMS error of {min(errors):.4g} to {max(errors):.4g} m' in done.stdout


@pytest.mark.soak
def test_an_interrupted_node_leaves_nothing_running_and_goes_on(domain, tmp_path, track):
    asked = node(EXAMPLE), '--node-runs', 2, '--resume'
    started = subprocess.Popen([sys.executable, '-c', MAIN, *map(str, arguments(tmp_path, *asked, tracks=[track]))],
                               stderr=subprocess.PIPE, text=True)
    cells = tmp_path / 'out' / 'cells'
    wait_until(lambda: [*cells.glob('mine*')], 60.0)
    wait_until(lambda: processes_of(EXAMPLE), 60.0)
    before, = cells.glob('mine*')
    first = json.loads(before.read_text())['cell']['results'][0]['rms_position_error'][0]
    started.send_signal(signal.SIGINT)
    assert 'interrupted, after 1 of 2 cells; --resume goes on' in started.communicate(timeout=60)[1]
    assert started.returncode == 1
    assert not processes_of(EXAMPLE)
    done = benchmark(tmp_path, *asked, tracks=[track])
    assert done.returncode == 0, done.stderr
    assert float(judged(tmp_path, 'mine')[0]['rms_position_error']) == first
    assert_runs_of_the_law(tmp_path, [track], 2)
