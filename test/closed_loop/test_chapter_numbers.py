"""The chapter's runs with its evolved gains: section 3.1 and 4.1, and the numbers of an independent solver."""

import math

import pytest
from helpers import chapter
from helpers.measuring import configuration, measured, measured_run

from mobile_robot_control.loop.batch import run_trials
from mobile_robot_control.loop.trial import make_trial
from mobile_robot_control.runs.metrics import summary

VELOCITY = {f'gains.{name}': value for name, value in chapter.EVOLVED_VELOCITY_GAINS.items()}
POSITION = {f'backstepping.{name}': value for name, value in chapter.EVOLVED_BACKSTEPPING_GAINS.items()}
ON_THE_CURVE = [1.0, 0.0, 0.5 * math.pi]


def parameters(rate, law='backstepping', curve='trifolium', start=ON_THE_CURVE):
    return configuration(
        rate, rate, plant={'initial_pose': start}, velocity_controller=VELOCITY,
        position_controller={'controller_type': law, 'backstepping.alpha': 1.0, **POSITION},
        reference_cart={'curve': curve, 'scale': 1.0, 'period': 16.0},
    )


def test_one_lap_of_the_trifolium_at_20_khz_matches_an_independent_solver():
    # compiled: in plain form a lap at this rate takes a minute, and gives the same bits
    trial = make_trial(parameters(20000.0), 16.0)
    outcome, = run_trials([trial], compile_them=True)
    found = summary(measured_run(trial, outcome))
    assert found['outcome'] == 'completed'
    assert found['duration'] == 16.0
    assert found['initial_wheel_torque']['right'] == pytest.approx(411.28, rel=1e-4)
    assert found['initial_wheel_torque']['left'] == pytest.approx(-159.08, rel=1e-4)
    assert found['rms_position_error'] == pytest.approx(1.237e-4, rel=0.02)
    assert found['peak_wheel_torque']['right'] == found['initial_wheel_torque']['right']


def test_ordinary_backstepping_needs_torques_beyond_50_newton_metres():
    # section 4.1, on the lemniscate: both torques exceed 50 N m, at the beginning
    found, _ = measured(parameters(4000.0, curve='lemniscate'), 0.5)
    assert min(found['peak_wheel_torque'].values()) > 50.0
    assert {side: abs(value) for side, value in found['initial_wheel_torque'].items()} == found['peak_wheel_torque']


@pytest.mark.parametrize(('start', 'seconds'), [(ON_THE_CURVE, 3.0), ([0.8, -0.1, 0.3], 6.0)])
def test_hybrid_backstepping_needs_far_smaller_torques(start, seconds):
    found, last = measured(parameters(4000.0, 'hybrid_backstepping', 'lemniscate', start), seconds)
    assert max(found['peak_wheel_torque'].values()) < 3.0
    assert found['initial_wheel_torque'] == {'right': 0.0, 'left': 0.0}
    # and tracks in the end
    assert math.hypot(*last.tick.error[:2]) < 0.05
    ordinary, _ = measured(parameters(4000.0, 'backstepping', 'lemniscate', start), 0.1)
    assert min(ordinary['peak_wheel_torque'].values()) > 25.0 * max(found['peak_wheel_torque'].values())
