"""Rollouts in batches, of torques and of a base: compiled and plain form, and the rollout sample by sample, agree."""

import subprocess
import sys

import pytest
from helpers.measuring import configuration, measured_run

from mobile_robot_control.loop import batch
from mobile_robot_control.loop.metric_table import INDICES
from mobile_robot_control.loop.pool import Pool
from mobile_robot_control.loop.trial import cart_motion, make_trial, references
from mobile_robot_control.runs.metrics import RunMeter, summary
from mobile_robot_control.runs.rollout import measure, rollout

LAP = 16.0
ROUGH = {
    'initial_pose': [0.9, 0.1, 1.0], 'noise.pose': [0.01, 0.01, 0.02], 'noise.velocity': 0.05, 'noise.seed': 7,
    'disturbance.time': 2.0, 'disturbance.impulse': [0.01, -0.01], 'disturbance.step': [0.0, 0.02],
    'max_wheel_torque': 3.0,
}

ROUGH_BASE = {
    'base.wheel_gain': [1.02, 0.98], 'base.turn_gain': 0.9, 'base.command_jitter': 0.012, 'odometry.jitter': 0.015,
    'drive': 'velocity', 'base.lag': [0.15, 0.1], 'base.dead_time': [0.02, 0.043], 'base.max_speed': [0.7, 2.0],
    'base.max_acceleration': [1.0, 4.0], 'base.dead_zone': [0.01, 0.02], 'base.quantum': [0.001, 0.01],
    'base.command_rate': 30.0, 'encoders.ticks': 2000, 'encoders.window': 0.01, 'odometry.dead_reckoning': True,
    'odometry.radius_error': [0.002, -0.001], 'odometry.slip': 0.002, 'odometry.rate': 30.0, 'odometry.latency': 0.05,
    'noise.velocity': 0.01, 'noise.pose': [0.001, 0.001, 0.002], 'noise.seed': 3,
}


def configured(law, plant):
    return configuration(plant=plant, position_controller={'controller_type': law})


def numbers(value):
    return [x for part in value for x in numbers(part)] if isinstance(value, tuple) else [value]


@pytest.mark.parametrize('plant', [ROUGH, pytest.param({'initial_pose': [0.9, 0.1, 1.0]}, marks=pytest.mark.soak)])
@pytest.mark.parametrize(('law', 'delay', 'varies'), [
    # each takes seconds to compile, and the hybrid law has the ordinary one within
    pytest.param('backstepping', 0, True, marks=pytest.mark.soak), ('hybrid_backstepping', 1, True),
    pytest.param('fuzzy', 0, False, marks=pytest.mark.soak),
])
def test_plain_and_compiled_form_agree_over_a_lap(law, delay, varies, plant):
    pytest.importorskip('numba')
    trial = make_trial(configured(law, {**plant, 'delay.velocity_steps': delay}), LAP, late=12.0)
    trial = trial._replace(form=trial.form._replace(varies=varies, indices=varies))
    (compiled,), (plain,) = batch.run_trials([trial], True), batch.run_trials([trial], False)
    assert compiled.steps == plain.steps == 8000
    assert (plain.variation > 0.0) == varies
    for a, b in zip(numbers(compiled), numbers(plain), strict=True):
        # the highest torque of no torque at all is -inf
        assert a == b or abs(a - b) <= 1e-9 * max(1.0, abs(b))


@pytest.mark.parametrize('law', ['backstepping', pytest.param('fuzzy', marks=pytest.mark.soak)])
def test_plain_and_compiled_form_of_a_base_with_everything_are_equal_to_the_last_bit(law):
    pytest.importorskip('numba')
    parameters = configuration(plant=ROUGH_BASE, position_controller={
        'controller_type': law, 'compensate_latency': True, 'odom_latency': 0.07})
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
    at_once, lagging = (
        summary(measure(configuration(plant={'drive': 'velocity', 'base.lag': [lag, lag]}), 4.0))['rms_position_error']
        for lag in (0.0, 0.1))
    assert at_once < 0.001 < lagging < 0.03


@pytest.mark.parametrize(('law', 'plant'), [
    ('backstepping', {'delay.velocity_steps': 2, 'noise.pose': [0.01, 0.02, 0.01]}),
    ('fuzzy', {'delay.velocity_steps': 2, 'disturbance.step': [0.01, 0.0]}),
    ('backstepping', {'drive': 'velocity', 'base.lag': [0.1, 0.1]}),
])
def test_metrics_and_performance_indices_are_those_of_the_rollout_sample_by_sample(law, plant):
    parameters = configured(law, {'initial_pose': [0.9, 0.1, 1.0], **plant})
    trial = make_trial(parameters, 3.0)
    with_indices = trial._replace(form=trial.form._replace(indices=True))
    (without,), (outcome,) = (batch.run_trials([one], False) for one in (trial, with_indices))
    # as text: a base has no torque, which is nan
    assert repr(outcome._replace(indices=())) == repr(without)
    # what odometry shows is not measured in trials
    expected = {**summary(measure(parameters, 3.0)), 'measured_rms_position_error': None}
    found = {**summary(measured_run(with_indices, outcome)), 'measured_rms_position_error': None}
    assert found == expected
    assert summary(measured_run(trial, without)) == {
        name: value for name, value in expected.items() if name not in INDICES}


def test_a_diverging_trial_ends_at_the_step_of_the_rollout():
    wild = configuration(plant={'disturbance.step': [1e9, 1e9]})
    trial = make_trial(wild, 1.0)
    samples = list(rollout(wild, 1.0))
    (outcome,) = batch.run_trials([trial], False)
    assert outcome.steps == len(samples) - 1 < trial.steps
    assert measured_run(trial, outcome).outcome == 'diverged'


def test_trials_with_the_same_curve_share_their_references():
    one, other = (make_trial(configuration(plant={'initial_pose': [x, 0.0, 0.0]}), 1.0) for x in (0.5, 1.0))
    assert references(cart_motion(one)) is references(cart_motion(other))
    assert len(references(cart_motion(one))) == 100


@pytest.mark.parametrize('workers', [1, 2])
def test_a_pool_keeps_the_order(workers):
    trials = [make_trial(configuration(plant={'initial_pose': [x / 10.0, 0.0, 0.0]}), 0.2) for x in range(9)]
    pool = Pool(workers)
    try:
        assert pool(trials) == batch.run_trials(trials)
        assert pool([]) == []
    finally:
        pool.close()


@pytest.mark.parametrize(('module', 'reason'), [
    ('numba', 'numba is not installed'), ('llvmlite', 'the Python module llvmlite.binding is missing')])
def test_without_compilation_trials_run_with_one_warning_of_the_true_reason(module, reason):
    code = (
        f'import sys; sys.modules["{module}"] = None\n'
        'from mobile_robot_control.settings.configure import configure\n'
        'from mobile_robot_control.loop import batch\n'
        'from mobile_robot_control.loop.pool import Pool\n'
        'from mobile_robot_control.loop.trial import make_trial\n'
        'if __name__ == "__main__":\n'
        '    pool = Pool(2); Pool(1)\n'
        '    trials = [make_trial(configure({}), 0.1)] * 3\n'
        '    print(pool(trials) == batch.run_trials(trials, False)); pool.close()\n'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout == 'True\n'
    assert done.stderr.count(reason) == 1
    assert ('numba is not installed' in done.stderr) == (module == 'numba')
