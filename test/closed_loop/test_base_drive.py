"""A base that takes velocity commands, in the loop: a published track, and the plain and the compiled form."""

import csv
import json
import math
from pathlib import Path

import pytest
from harness import run_command
from measuring import configuration

from mobile_robot_control.simulation import batch
from mobile_robot_control.simulation.metrics import RunMeter, summary
from mobile_robot_control.simulation.rollout import rollout
from mobile_robot_control.simulation.trial import make_trial, measured_run

KLANCAR = Path(__file__).parents[1] / 'plugins' / 'klancar.py'
RATE = repr(1.0 / 0.033)
TRACK = ['plant.drive:=velocity', f'/**.velocity_rate:={RATE}', f'/**.position_rate:={RATE}',
         'plant.initial_pose:=[1.1, 0.8, 0.0]', 'position_controller.controller_type:=klancar',
         'reference_cart.curve:=lissajous', 'reference_cart.scale:=0.7', 'reference_cart.center:=[1.1, 0.9]',
         'reference_cart.period:=30.0']
ROUGH = {
    'base.wheel_gain': [1.02, 0.98], 'base.turn_gain': 0.9, 'base.command_jitter': 0.012, 'odometry.jitter': 0.015,
    'drive': 'velocity', 'base.lag': [0.15, 0.1], 'base.dead_time': [0.02, 0.043], 'base.max_speed': [0.7, 2.0],
    'base.max_acceleration': [1.0, 4.0], 'base.dead_zone': [0.01, 0.02], 'base.quantum': [0.001, 0.01],
    'base.command_rate': 30.0, 'encoders.ticks': 2000, 'encoders.window': 0.01, 'odometry.dead_reckoning': True,
    'odometry.radius_error': [0.002, -0.001], 'odometry.slip': 0.002, 'odometry.rate': 30.0, 'odometry.latency': 0.05,
    'noise.velocity': 0.01, 'noise.pose': [0.001, 0.001, 0.002], 'noise.seed': 3,
}
COMPENSATED = {'compensate_latency': True, 'odom_latency': 0.07}


def test_klancars_linear_law_on_the_published_track(tmp_path):
    # the book's listing, moved along the exact arc: 12.469 mm, 0.077823 m s and 113.66 mm
    table = tmp_path / 'track.csv'
    done = run_command('simulate', '--law', KLANCAR, '--duration', 30.03, '--json', '--output', table,
                       *(word for assignment in TRACK for word in ('-p', assignment)))
    assert done.returncode == 0, done.stderr
    metrics = json.loads(done.stdout)
    assert metrics['rms_position_error'] == pytest.approx(12.469e-3, abs=5e-7)
    assert metrics['max_position_error'] == pytest.approx(113.66e-3, abs=5e-6)
    with table.open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 911
    apart = [math.hypot(float(row['tracking_error.vector.x']), float(row['tracking_error.vector.y']))
             for row in rows[:-1]]
    assert 0.033 * sum(apart) == pytest.approx(0.077823, abs=5e-7)
    # there is no torque
    assert metrics['peak_wheel_torque'] is metrics['energy'] is None
    assert {row[name] for row in rows for name in row if 'effort' in name} == {''}


@pytest.mark.parametrize('law', ['backstepping', pytest.param('fuzzy', marks=pytest.mark.soak)])
def test_plain_and_compiled_form_of_a_base_with_everything_are_equal_to_the_last_bit(law):
    pytest.importorskip('numba')
    parameters = configuration(plant=ROUGH, position_controller={'controller_type': law, **COMPENSATED})
    trial = make_trial(parameters, 8.0, late=6.0)
    compiled, plain = batch.run_trials([trial], True), batch.run_trials([trial], False)
    # nan, which torques are, is not equal to itself
    assert repr(compiled) == repr(plain)
    assert plain[0].steps == 4000
    meter = RunMeter(0.002, 0.01)
    for sample in rollout(parameters, 8.0):
        meter.add(sample)
    measured = summary(meter.run('completed'))
    assert summary(measured_run(trial, plain[0])) == {**measured, 'measured_rms_position_error': None}
    # dead reckoning drifts: what odometry shows is not how far the robot is from the cart
    assert measured['measured_rms_position_error'] != measured['rms_position_error'] < 0.3


def test_a_base_that_follows_at_once_tracks_like_the_kinematic_loop():
    metrics = summary(measured_run(*_tried({'drive': 'velocity'})))
    lagging = summary(measured_run(*_tried({'drive': 'velocity', 'base.lag': [0.1, 0.1]})))
    assert metrics['rms_position_error'] < 0.001 < lagging['rms_position_error'] < 0.03


def _tried(plant):
    trial = make_trial(configuration(plant=plant), 4.0)
    return trial, batch.run_trials([trial], False)[0]
