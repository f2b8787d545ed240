"""A law of one's own that fails at the very first step, or only with the gains before a search, ends a run in order."""

import json

from helpers.harness import numbers_in, run_command
from mcap_ros2.reader import read_ros2_messages

LAW = '''
from typing import Annotated, NamedTuple

from mobile_robot_control import BodyVelocity, Field, Law


class Gains(NamedTuple):
    k: Annotated[float, Field('1/s', 'gain: larger closes the gap sooner', above=0.0, live=True,
                              search=(2.0, 3.0))] = 1.0


def step(state, observation, gains, dt):
    if gains.k == 1.0:
        raise ValueError('no such gain')
    return state, BodyVelocity(gains.k * observation.error.longitudinal, gains.k * observation.error.lateral)


LAW = Law('failing', step, Gains, with_velocity_gains=False)
'''


def _law(folder):
    (folder / 'failing.py').write_text(LAW)
    return ['--law', folder / 'failing.py', '-p', 'position_controller.controller_type:=failing']


def test_a_simulation_ends_with_the_outcome_and_the_reason(tmp_path):
    done = run_command('simulate', *_law(tmp_path), '--duration', 1, '--json', '--output', tmp_path / 'run.csv')
    assert done.returncode == 1
    metrics = json.loads(done.stdout)
    assert (metrics['outcome'], metrics['duration'], metrics['energy']) == ('law_failed', 0.0, 0.0)
    assert numbers_in(tmp_path / 'run.metrics.json') == metrics
    assert done.stderr == ("simulate: the position law 'failing' failed at t = 0 s: ValueError: no such gain in "
                           f'{tmp_path / "failing.py"}, line 14\n')


def test_the_last_diagnostics_of_a_short_experiment_have_the_reason(domain, tmp_path):
    """A run may end before the experiment has found /diagnostics."""
    done = run_command('experiment', *_law(tmp_path), '--duration', 0.5, '--output', tmp_path / 'run', '--composed',
                       '--no-report', '-p', 'plant.real_time_factor:=0.0')
    assert done.returncode == 1
    assert 'experiment: position_controller: law failed: ValueError: no such gain' in done.stderr
    conditions = [status.message for message in read_ros2_messages(tmp_path / 'run' / 'bag' / 'bag.mcap',
                                                                   topics=['/diagnostics'])
                  for status in message.ros_msg.status if status.name == 'position_controller']
    assert conditions[-1] == f'law failed: ValueError: no such gain in {tmp_path / "failing.py"}, line 14'


def test_a_search_begins_with_gains_with_which_the_law_fails(tmp_path, monkeypatch):
    # to compile takes longer than five short runs and the margins of a short lap
    monkeypatch.setenv('NUMBA_DISABLE_JIT', '1')
    short = (word for value in ('/**.velocity_rate:=100.0', '/**.position_rate:=50.0', 'reference_cart.period:=0.5',
                                'reference_cart.scale:=0.05') for word in ('-p', value))
    done = run_command('tune', 'failing', *_law(tmp_path), '--seed', 1, '--generations', 1, '--population', 5,
                       '--workers', 1, '--output', tmp_path / 'gains.yaml', *short)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / 'gains.png').is_file()
    assert 'Traceback' not in done.stderr
