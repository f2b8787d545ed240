"""A robot as it is, in lockstep over DDS: equal to `simulate`, equal from run to run, and whole after kill -9."""

import re

import pytest
from harness import Robots, experiment
from real_robot import MORE, ROBOTS, assignments

from mobile_robot_control.configuration.configure import at_cart_start, configure
from mobile_robot_control.configuration.files import load
from mobile_robot_control.simulation.rollout import rollout

CASES = [*(pytest.param(options, id=name) for name, options in ROBOTS.items()),
         *(pytest.param(options, id=name, marks=pytest.mark.soak) for name, options in MORE.items())]
SECONDS = 2


def _close(a, b):
    return all(abs(x - y) <= 1e-9 * max(1.0, abs(y)) for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize('options', CASES)
def test_nodes_and_simulate_agree(domain, quick_discovery, tmp_path, options):
    given = [word for one in assignments(options) for word in ('-p', one)]
    metrics, recording = experiment(tmp_path / 'run', '--duration', SECONDS, '--composed', *given)
    simulated = list(rollout(at_cart_start(configure(load([], assignments(options)))), SECONDS))
    assert metrics['outcome'] == 'completed'
    assert not recording.problems
    assert len(recording.samples) == len(simulated) == 500 * SECONDS + 1
    takes_torque = options.get('plant.drive') != 'velocity'
    for recorded, sample in zip(recording.samples, simulated, strict=True):
        assert (recorded.time, recorded.tick.time) == (sample.time, sample.tick.time)
        assert _close(recorded.command, sample.command)
        assert _close(recorded.wheels, sample.wheels)
        assert _close(recorded.tick.pose, sample.tick.pose)
        assert _close(recorded.tick.velocity, sample.tick.velocity)
        assert _close(recorded.tick.error, sample.tick.error)
        assert _close((recorded.right_angle, recorded.left_angle), (sample.right_angle, sample.left_angle))
        if takes_torque:
            assert _close(recorded.torque, sample.torque)
            assert _close(recorded.applied, sample.applied)
    assert (metrics['energy'] is not None) == takes_torque
    assert metrics['error'] == 'true'


def _messages(folder, drive, options, use_sim_time):
    """Run the nodes composed, as fast as they go; returns the bytes of each topic by stamp."""
    robots = Robots(folder, drive=drive)
    try:
        given = [word for one in assignments(options) for word in ('-p', one.removeprefix('/**.').replace('.', ':', 1))]
        robots.start(composed=True, arguments=['-p', 'duration:=1.0', '-p', 'real_time_factor:=0.0', '-p',
                                               'paused:=true', '-p', f'use_sim_time:={use_sim_time}', *given])
        robots.resume()
        robots.finish()
        return robots.messages()
    finally:
        robots.close()


@pytest.mark.parametrize(('drive', 'name'), [
    ('velocity', 'base with everything'), ('torque', 'torques with everything')])
def test_two_runs_are_equal_to_the_last_bit(domain, lossless, tmp_path, drive, name):
    # in lockstep /clock changes no bit
    first, second = (_messages(tmp_path / use_sim_time, drive, ROBOTS[name], use_sim_time)
                     for use_sim_time in ('false', 'true'))
    assert first == second
    assert len(first['joint_states']) == 501
    assert len(first['cmd_vel']) == len(first['odom']) == 101
    assert all(len(bytes_) == 1 for stamps in first.values() for bytes_ in stamps.values())


@pytest.mark.soak
def test_a_base_waits_for_killed_nodes_and_the_run_goes_on(domain, quick_discovery, tmp_path):
    robots = Robots(tmp_path, drive='velocity')
    try:
        options = [word for one in assignments(ROBOTS['base with everything'])
                   for word in ('-p', one.replace('.', ':', 1))]
        arguments = ['-p', 'duration:=3.0', '-p', 'peer_timeout:=0.5', *options]
        robots.start(arguments=[*arguments, '-p', 'paused:=true'])
        # the recorder, which tells the time, may find the plant later than the nodes do
        robots.resume()
        for number, name in enumerate(('reference_cart', 'position_controller'), start=1):
            robots.spin_until(lambda: robots.time() > 0.8 * number)  # noqa: B023
            robots.processes[name].kill()
            robots.spin_until(lambda: f'waiting for {name} at t =' in robots.log('plant'))  # noqa: B023
            robots.start(name, arguments=arguments)
            robots.spin_until(lambda: re.search(f'{name}.* answered: the run goes on', robots.log('plant')))  # noqa: B023
        robots.finish()
        assert 'velocity_controller' not in robots.log('plant')
    finally:
        robots.close()
