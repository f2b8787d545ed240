"""Metrics by the rectangle rule, and the objective: Eq. (29), with deviation 7."""

import math

import pytest

from mobile_robot_control.quantities import (
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    Truth,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.simulation.closed_loop import PositionTick, Sample
from mobile_robot_control.simulation.metrics import MEASURED, MeasuredRun, RunMeter, summary
from mobile_robot_control.simulation.totals import Totals, add_error, add_torque, objective

STILL = BodyVelocity(0.0, 0.0)
ORIGIN = Pose(0.0, 0.0, 0.0)
# four periods of 0.5 s, a position tick every second one: what holds at each time, what was applied before it
ERRORS = {0.0: TrackingError(3.0, -4.0, 0.5), 1.0: TrackingError(0.0, 1.0, -1.5), 2.0: TrackingError(99.0, 99.0, 3.0)}
POSES = {0.0: Pose(1.0, 2.0, 0.0), 1.0: Pose(1.5, 2.0, 0.1), 2.0: Pose(2.5, 1.0, 0.2)}
WHEELS = [(0.0, 0.0), (2.0, -1.0), (4.0, 3.0), (-5.0, 1.0), (100.0, 100.0)]
APPLIED = [(0.0, 0.0), (6.0, -2.0), (-1.0, 7.0), (0.5, -8.0), (2.0, 1.0)]


def series():
    tick = None
    for k in range(5):
        time = 0.5 * k
        if time in ERRORS:
            tick = PositionTick(time, POSES[time], STILL, Reference(ORIGIN, STILL), ERRORS[time])
        # the requested torque never counts, the applied one does
        yield Sample(time, tick, STILL, 0.0, 0.0, WheelVelocity(*WHEELS[k]), WheelTorque(*APPLIED[k]),
                     WheelTorque(1e9, -1e9))


@pytest.fixture
def meter():
    meter = RunMeter(0.5, 1.0)
    for sample in series():
        meter.add(sample)
    return meter


def test_errors_by_the_rectangle_rule_at_the_position_ticks_before_the_end(meter):
    totals = meter.totals
    assert totals.time == 2.0
    assert totals.squared_position == 25.0 + 1.0
    assert totals.squared_heading == 0.25 + 2.25
    assert totals.max_position == 5.0
    assert totals.log_longitudinal == pytest.approx(math.log(4.0), rel=1e-15)
    assert totals.log_lateral == pytest.approx(math.log(5.0) + math.log(2.0), rel=1e-15)
    assert totals.log_heading == pytest.approx(math.log(1.5) + math.log(2.5), rel=1e-15)


def test_torque_power_and_energy_over_the_velocity_periods(meter):
    totals = meter.totals
    assert (totals.peak_right, totals.peak_left) == (6.0, 8.0)
    assert (totals.highest_right, totals.highest_left) == (6.0, 7.0)
    # power with the wheels at each period's start: right 0, -2, 2, -10; left 0, -7, -24, 1
    assert (totals.power_right, totals.power_left) == (10.0, 24.0)
    # 2 of the right wheel and 1 of the left, for 0.5 s each; what brakes gives nothing back
    assert totals.energy == 1.5


def test_the_summary_has_the_contracts_names_and_values(meter):
    found = summary(meter.run('completed'))
    assert found == {
        'outcome': 'completed',
        'duration': 2.0,
        'final_pose': [2.5, 1.0, 0.2],
        'error': 'true',
        'rms_position_error': pytest.approx(math.sqrt(13.0), rel=1e-15),
        'max_position_error': 5.0,
        'rms_heading_error': pytest.approx(math.sqrt(1.25), rel=1e-15),
        'measured_rms_position_error': pytest.approx(math.sqrt(13.0), rel=1e-15),
        'initial_wheel_torque': {'right': 6.0, 'left': -2.0},
        'peak_wheel_torque': {'right': 6.0, 'left': 8.0},
        'peak_wheel_power': {'right': 10.0, 'left': 24.0},
        'energy': 1.5,
        'objective': pytest.approx(math.log(4.0) + 5.0 * math.log(10.0) + math.log(3.75) + 14.0, rel=1e-15),
    }


def test_equation_29_with_hand_numbers():
    totals = Totals(log_longitudinal=0.5, log_lateral=0.25, log_heading=2.0, peak_right=3.0, peak_left=7.0,
                    highest_right=1.0, highest_left=-2.0)
    # 1 * 0.5 + 5 * 0.25 + 1 * 2 = 3.75, and the torques
    assert objective(totals, literal=False) == 3.75 + 3.0 + 7.0
    assert objective(totals, literal=True) == 3.75 + 1.0 - 2.0


def test_deviation_7_large_negative_torques_escape_the_literal_objective():
    totals = Totals()
    for torque in ((0.99, 0.5), (-123.0, 0.5)):
        totals = add_torque(totals, WheelTorque(*torque), WheelVelocity(0.0, 0.0), 0.1)
    assert objective(totals, literal=True) == 0.99 + 0.5
    assert objective(totals, literal=False) == 123.0 + 0.5


def test_an_error_and_a_torque_each_change_their_own_totals_alone():
    base = Totals(*map(float, range(1, 15)))
    with_error = add_error(base, TrackingError(0.3, -0.4, -0.2), 0.5)
    assert with_error[7:] == base[7:]
    assert with_error[:7] == pytest.approx(
        (1.5, 2.125, 3.02, 4.0, 5.0 + 0.5 * math.log(1.3), 6.0 + 0.5 * math.log(1.4), 7.0 + 0.5 * math.log(1.2)))
    assert add_error(base, TrackingError(-30.0, 40.0, 0.0), 0.5).max_position == 50.0
    with_torque = add_torque(base, WheelTorque(-20.0, 30.0), WheelVelocity(1.0, 2.0), 0.5)
    assert with_torque[:7] == base[:7]
    # peaks 8, 9; highest 10, 11; power 12, 13; energy 14
    assert with_torque[7:] == (20.0, 30.0, 10.0, 30.0, 20.0, 60.0, 14.0 + 30.0)


def without_torque():
    return [sample._replace(applied=WheelTorque(math.nan, math.nan), torque=WheelTorque(math.nan, math.nan))
            for sample in series()]


def test_a_base_that_takes_no_torque_has_the_same_errors_and_no_torque_metrics(meter):
    other = RunMeter(0.5, 1.0)
    for sample in without_torque():
        other.add(sample)
    found, expected = (summary(one.run('completed')) for one in (other, meter))
    torque = {'initial_wheel_torque', 'peak_wheel_torque', 'peak_wheel_power', 'energy'}
    assert {name for name, value in found.items() if value is None} == torque
    assert found['objective'] == pytest.approx(expected['objective'] - 14.0, rel=1e-15)
    assert objective(other.totals, literal=True) == objective(other.totals, literal=False)
    for name in set(found) - torque - {'objective'}:
        assert found[name] == expected[name]


def test_the_metrics_are_of_the_true_error_and_pose_where_they_are_known(meter):
    truths = {0.0: TrackingError(1.0, 0.0, 0.5), 1.0: TrackingError(0.0, -2.0, 0.5), 2.0: TrackingError(9.0, 9.0, 9.0)}
    true = RunMeter(0.5, 1.0, MEASURED)
    for sample in series():
        error = truths[sample.tick.time]
        true.add(sample._replace(truth=Truth(Pose(7.0, 8.0, sample.tick.time), STILL, error)))
    found = summary(true.run('completed'))
    assert found['error'] == 'true'
    assert found['final_pose'] == [7.0, 8.0, 2.0]
    assert found['rms_position_error'] == pytest.approx(math.sqrt(2.5), rel=1e-15)
    assert found['max_position_error'] == 2.0
    assert found['rms_heading_error'] == 0.5
    assert found['measured_rms_position_error'] == summary(meter.run('completed'))['rms_position_error']
    assert found['objective'] == pytest.approx(
        math.log(2.0) + 5.0 * math.log(3.0) + 2.0 * math.log(1.5) + 14.0, rel=1e-15)


def test_a_truth_that_is_not_known_counts_nothing():
    meter = RunMeter(0.5, 1.0)
    for sample in series():
        error = TrackingError(math.nan, math.nan, math.nan) if sample.tick.time == 0.0 else TrackingError(0.0, 2.0, 0.0)
        meter.add(sample._replace(truth=Truth(ORIGIN, STILL, error)))
    found = summary(meter.run('completed'))
    assert meter.totals.time == 1.0
    assert found['rms_position_error'] == 2.0
    assert found['measured_rms_position_error'] == 1.0


def test_the_errors_of_a_single_sample_are_none():
    meter = RunMeter(0.5, 1.0)
    meter.add(next(series()))
    found = summary(meter.run('interrupted'))
    assert found['outcome'] == 'interrupted'
    assert found['duration'] == 0.0
    assert found['rms_position_error'] is None
    assert found['rms_heading_error'] is None
    assert found['initial_wheel_torque'] == {'right': 0.0, 'left': 0.0}


def test_values_that_are_not_finite_become_none():
    totals = Totals(1.0, math.inf, 1.0, math.nan, 0.0, 0.0, 0.0, math.inf, 2.0, 3.0, 4.0, 5.0, -math.inf, math.nan)
    found = summary(MeasuredRun('diverged', 1.0, Pose(math.nan, 1.0, math.inf), WheelTorque(math.inf, 0.5), totals))
    assert found == {
        'outcome': 'diverged', 'duration': 1.0, 'final_pose': [None, 1.0, None], 'error': 'true',
        'rms_position_error': None, 'measured_rms_position_error': None,
        'max_position_error': None, 'rms_heading_error': 1.0, 'initial_wheel_torque': {'right': None, 'left': 0.5},
        'peak_wheel_torque': {'right': None, 'left': 2.0}, 'peak_wheel_power': {'right': 5.0, 'left': None},
        'energy': None, 'objective': None,
    }
