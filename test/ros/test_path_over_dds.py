"""A path of waypoints over DDS: equal to `simulate`, from its start at rest to its stop."""

import pytest
from harness import experiment, run_command

from mobile_robot_control.configuration.configure import at_cart_start, configure
from mobile_robot_control.configuration.files import load
from mobile_robot_control.configuration.nodes import course_of
from mobile_robot_control.simulation.rollout import rollout

FILE = """
/**: {ros__parameters: {reference_horizon: 2, feedforward.enabled: true, friction.coulomb: 0.01}}
/**/reference_cart:
  ros__parameters:
    curve: path
    path: {file: bend.csv, corner_tolerance: 0.1}
    timing: {max_linear_velocity: 0.5, max_linear_acceleration: 1.0, max_wheel_torque: 0.4}
"""


def test_nodes_and_simulate_drive_a_path_alike_to_its_end(domain, tmp_path):
    file = tmp_path / 'path.yaml'
    file.write_text(FILE)
    (tmp_path / 'bend.csv').write_text('x,y\n0,0\n0.5,0\n0.5,0.5\n')
    configuration = at_cart_start(configure(load([file])))
    seconds = course_of(configuration.reference_cart).period + 0.5
    assert 3.0 < seconds < 10.0
    metrics, recording = experiment(tmp_path / 'run', '--duration', seconds, '--params-file', file, '--composed')
    simulated = list(rollout(configuration, seconds))
    assert not recording.problems
    assert len(recording.samples) == len(simulated)
    for recorded, sample in zip(recording.samples, simulated, strict=True):
        # the acceleration has a topic of its own
        assert recorded.tick.reference.velocity == sample.tick.reference.velocity
        assert recorded.tick.reference.pose == pytest.approx(sample.tick.reference.pose, rel=1e-9, abs=1e-9)
        assert recorded.torque == pytest.approx(sample.torque, rel=1e-9, abs=1e-9)
        assert recorded.tick.pose == pytest.approx(sample.tick.pose, rel=1e-9, abs=1e-9)
    last = recording.samples[-1].tick
    assert last.reference.velocity == (0.0, 0.0)
    assert last.reference.pose[:2] == pytest.approx((0.5, 0.5))
    assert metrics['max_position_error'] < 0.01


def test_an_experiment_keeps_its_waypoints_and_is_replayed_when_the_file_has_gone(domain, tmp_path):
    file, run = tmp_path / 'path.yaml', tmp_path / 'run'
    file.write_text(FILE)
    (tmp_path / 'bend.csv').write_text('x,y\n0,0\n0.5,0\n0.5,0.5\n')
    experiment(run, '--duration', 0.5, '--params-file', file, '--composed')
    (tmp_path / 'bend.csv').unlink()
    done = run_command('experiment', '--replay', run, '--output', tmp_path / 'again', '--composed', '--no-report',
                       '-p', 'plant.real_time_factor:=0.0')
    assert 'the replay equals the recorded run to the last bit' in done.stderr
    done = run_command('report', run, '--output', tmp_path / 'report')
    assert done.returncode == 0, done.stderr
    assert 'Plan of the path' in (tmp_path / 'report' / 'report.html').read_text()
