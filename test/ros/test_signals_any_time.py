"""SIGINT, SIGTERM and SIGHUP at any moment of nodes and experiments: exit code 0, complete bags, no traceback."""

import json
import random
import signal
import subprocess
import sys
import time
from typing import NamedTuple

import pytest
from helpers.harness import CONFIG
from helpers.processes import catches_sigterm, processes_of, threads_of, wait_until

from mobile_robot_control.runs import bag
from mobile_robot_control.settings.nodes import NODES

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Moment(NamedTuple):
    """Which process gets which signal, and how long after its handlers are installed [s]."""

    target: str
    delay: float
    number: signal.Signals


def _moments(targets, longest, count, seed):
    draw = random.Random(seed)  # noqa: S311 (moments, no secrets)
    return [Moment(targets[k % len(targets)], draw.uniform(0.0, longest), SIGNALS[k % 3]) for k in range(count)]


def _signal_a_node(folder, moment):
    """Start the four nodes, or one for an early moment; signal the target, and the others when it has ended."""
    folder.mkdir()
    parameters = folder / 'parameters.yaml'
    parameters.write_text((CONFIG / 'fuzzy.yaml').read_text())
    run = ['--params-file', parameters, '-p', 'duration:=0.5', '-p', 'peer_timeout:=60.0', '-p',
           f'paused:={str(moment.delay > 1.0).lower()}']
    processes = {}
    try:
        for name in NODES if moment.delay > 0.5 else [moment.target]:
            processes[name] = subprocess.Popen(
                [sys.executable, '-m', 'mobile_robot_control.ros.start.executables', name, '--ros-args',
                 *map(str, run)],
                stdin=subprocess.PIPE, stdout=(folder / f'{name}.log').open('wb'), stderr=subprocess.STDOUT)
        wait_until(lambda: all(catches_sigterm(process.pid) for process in processes.values()))
        time.sleep(moment.delay)
        processes[moment.target].send_signal(moment.number)
        assert processes[moment.target].wait(60.0) == 0, (moment, (folder / f'{moment.target}.log').read_text())
        for process in processes.values():
            process.send_signal(moment.number)
        assert [process.wait(60.0) for process in processes.values()] == [0] * len(processes), moment
    finally:
        for process in processes.values():
            process.kill()
            process.stdin.close()
    for name in processes:
        lines = (folder / f'{name}.log').read_text().splitlines()
        # what a node says that is ended before its first run
        assert moment.delay > 0.5 or all('waiting for' in line or 'ended' in line for line in lines), (moment, lines)
        assert not any('Traceback' in line for line in lines), (moment, name)


def _signal_an_experiment(folder, moment):
    """Interrupt an experiment of one simulated second, and read its bag."""
    log = folder.with_suffix('.log')
    arguments = ['--duration', '1', '--output', folder, '--params-file', CONFIG / 'fuzzy.yaml']
    run = subprocess.Popen([sys.executable, '-m', 'mobile_robot_control.experiment.command', *map(str, arguments)],
                           stdout=log.open('wb'), stderr=subprocess.STDOUT)
    try:
        wait_until(lambda: catches_sigterm(run.pid))
        time.sleep(moment.delay)
        run.send_signal(moment.number)
        # 1, unless the run had ended before the signal came
        assert run.wait(120.0) in (0, 1), (moment, log.read_text())
    finally:
        run.kill()
    assert 'Traceback' not in log.read_text(), (moment, log.read_text())
    bag.read_bag(folder / 'bag')
    outcome = json.loads((folder / 'metrics.json').read_text())['outcome']
    assert (run.returncode, outcome) in ((0, 'completed'), (1, 'interrupted'))
    assert ('experiment: interrupted' in log.read_text()) == (outcome == 'interrupted')
    wait_until(lambda: not processes_of(folder))


def _signal(folder, moment):
    """Run one case."""
    (_signal_an_experiment if moment.target == 'experiment' else _signal_a_node)(folder, moment)


# start-up, discovery, paused, running, end
CHOSEN = [
    Moment('plant', 0.0, signal.SIGINT),
    Moment('plant', 0.1, signal.SIGHUP),
    Moment('plant', 0.2, signal.SIGTERM),
    Moment('reference_cart', 0.35, signal.SIGHUP),
    Moment('position_controller', 0.7, signal.SIGINT),
    Moment('velocity_controller', 1.2, signal.SIGQUIT),
    Moment('experiment', 0.0, signal.SIGTERM),
    Moment('experiment', 1.4, signal.SIGINT),
    Moment('experiment', 2.6, signal.SIGHUP),
    Moment('experiment', 3.6, signal.SIGINT),
]

# each is close to another of the moments
LONG_TESTS_ALONE = (CHOSEN[4], CHOSEN[8])


@pytest.mark.parametrize('moment', [
    pytest.param(moment, id=f'{moment.target} {moment.delay}', marks=[pytest.mark.soak] * (moment in LONG_TESTS_ALONE))
    for moment in CHOSEN])
def test_signals_at_chosen_moments_leave_nothing_behind(domain, tmp_path, moment):
    _signal(tmp_path / 'run', moment)


@pytest.mark.soak
@pytest.mark.timeout(900)
def test_signals_at_fifty_random_moments_leave_nothing_behind(domain, tmp_path):
    moments = [*_moments(list(NODES), 3.0, 25, 3), *_moments(['experiment'], 6.0, 25, 4)]
    for number, moment in enumerate(moments):
        print(f'\r{number} of {len(moments)}: {moment.target} after {moment.delay:.2f} s          ', end='', flush=True)
        _signal(tmp_path / f'run{number}', moment)


@pytest.mark.parametrize('number', [signal.SIGINT, *(
    pytest.param(number, marks=pytest.mark.soak) for number in (signal.SIGTERM, signal.SIGHUP))])
def test_running_nodes_end_with_exit_code_0_and_print_nothing(robot, number):
    robot.start(arguments=['-p', 'peer_timeout:=60.0'])
    robot.spin_until(lambda: robot.time() > 0.5)
    robot.stop(number=number)
    for name in NODES:
        lines = robot.log(name).splitlines()
        assert [word for line, word in zip(lines, ('waiting for', 'a run begins', 'ended at t ='), strict=True)
                if word not in line] == []


def test_a_node_has_no_type_lookup_and_ends_when_its_standard_input_closes(robot, bare_domain):
    robot.start('plant')
    robot.spin_until(lambda: 'waiting for' in robot.log('plant'))
    assert not [name for name in threads_of(robot.processes['plant'].pid) if name.startswith('dds.tls')]
    robot.processes['plant'].close_input()
    robot.finish()
