"""Metrics by the rectangle rule, the objective of Eq. (29) with deviation 7, and performance indices by hand."""

import math

import pytest
from helpers.measuring import configuration

from mobile_robot_control.loop import batch
from mobile_robot_control.loop.closed_loop import PositionTick, Sample
from mobile_robot_control.loop.indices import MEASURED, MeasuredRun, Totals, add_error, add_torque, objective
from mobile_robot_control.loop.metric_table import BAND, INDICES, RUN_METRICS
from mobile_robot_control.loop.trial import make_trial
from mobile_robot_control.quantities import (
    BodyVelocity,
    Pose,
    Reference,
    TrackingError,
    Truth,
    WheelTorque,
    WheelVelocity,
)
from mobile_robot_control.runs.metrics import IndexMeter, RunMeter, summary
from mobile_robot_control.runs.rollout import measure, rollout

STILL, ORIGIN = BodyVelocity(0.0, 0.0), Pose(0.0, 0.0, 0.0)
NAN = math.nan
UNKNOWN = WheelTorque(NAN, NAN)
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


def metered(samples, *error):
    meter = RunMeter(0.5, 1.0, *error)
    for sample in samples:
        meter.add(sample)
    return meter


def test_errors_torque_power_and_energy_are_those_of_the_periods_before_the_end():
    meter = metered(series())
    # power with the wheels at each period's start: right 0, -2, 2, -10; left 0, -7, -24, 1; of these 2 of the right
    # wheel and 1 of the left count as energy, for 0.5 s each: what brakes gives nothing back
    assert meter.totals == pytest.approx(Totals(
        2.0, 26.0, 2.5, 5.0, math.log(4.0), math.log(10.0), math.log(3.75), 6.0, 8.0, 6.0, 7.0, 10.0, 24.0, 1.5))
    assert summary(meter.run('completed')) == {
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
    assert ({metric.name for metric in RUN_METRICS if metric.of_wheels}
            == {name for name, value in summary(meter.run('completed')).items() if isinstance(value, dict)})


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
    with_torque = add_torque(base, WheelTorque(-20.0, 30.0), WheelVelocity(1.0, 2.0), 0.5)
    assert with_torque[:7] == base[:7]
    # peaks 8, 9; highest 10, 11; power 12, 13; energy 14
    assert with_torque[7:] == (20.0, 30.0, 10.0, 30.0, 20.0, 60.0, 14.0 + 30.0)


def test_a_base_that_takes_no_torque_has_the_same_errors_and_no_torque_metrics():
    other, meter = metered(sample._replace(applied=UNKNOWN, torque=UNKNOWN) for sample in series()), metered(series())
    found, expected = (summary(one.run('completed')) for one in (other, meter))
    torque = dict.fromkeys(('initial_wheel_torque', 'peak_wheel_torque', 'peak_wheel_power', 'energy'))
    assert found == {**expected, **torque, 'objective': pytest.approx(expected['objective'] - 14.0, rel=1e-15)}
    assert objective(other.totals, literal=True) == objective(other.totals, literal=False)


def test_the_metrics_are_of_the_true_error_and_pose_where_they_are_known():
    truths = {0.0: TrackingError(1.0, 0.0, 0.5), 1.0: TrackingError(0.0, -2.0, 0.5), 2.0: TrackingError(9.0, 9.0, 9.0)}
    found = summary(metered((sample._replace(truth=Truth(
        Pose(7.0, 8.0, sample.tick.time), STILL, truths[sample.tick.time])) for sample in series()), MEASURED).run(''))
    assert (found['error'], found['final_pose']) == ('true', [7.0, 8.0, 2.0])
    assert found['rms_position_error'] == pytest.approx(math.sqrt(2.5), rel=1e-15)
    assert (found['max_position_error'], found['rms_heading_error']) == (2.0, 0.5)
    assert found['measured_rms_position_error'] == pytest.approx(math.sqrt(13.0), rel=1e-15)
    # a truth that is not known counts nothing
    truths = {0.0: TrackingError(NAN, NAN, NAN), 1.0: TrackingError(0.0, 2.0, 0.0), 2.0: TrackingError(0.0, 2.0, 0.0)}
    meter = metered(sample._replace(truth=Truth(ORIGIN, STILL, truths[sample.tick.time])) for sample in series())
    found = summary(meter.run('completed'))
    assert (meter.totals.time, found['rms_position_error'], found['measured_rms_position_error']) == (1.0, 2.0, 1.0)


def test_what_is_not_known_or_not_finite_is_none():
    found = summary(metered([next(series())]).run('interrupted'))
    assert (found['duration'], found['rms_position_error'], found['rms_heading_error']) == (0.0, None, None)
    assert found['initial_wheel_torque'] == {'right': 0.0, 'left': 0.0}
    totals = Totals(1.0, math.inf, 1.0, NAN, 0.0, 0.0, 0.0, math.inf, 2.0, 3.0, 4.0, 5.0, -math.inf, NAN)
    assert summary(MeasuredRun('diverged', 1.0, Pose(NAN, 1.0, math.inf), WheelTorque(math.inf, 0.5), totals)) == {
        'outcome': 'diverged', 'duration': 1.0, 'final_pose': [None, 1.0, None], 'error': 'true',
        'rms_position_error': None, 'measured_rms_position_error': None,
        'max_position_error': None, 'rms_heading_error': 1.0, 'initial_wheel_torque': {'right': None, 'left': 0.5},
        'peak_wheel_torque': {'right': None, 'left': 2.0}, 'peak_wheel_power': {'right': 5.0, 'left': None},
        'energy': None, 'objective': None,
    }


KNOWN = configuration(reference_cart={'curve': 'line'})
"""With a robot whose wheels are 0.35 m apart, and a cart that starts at the origin along x."""
IN, OUT = 0.5 * BAND, 2.0 * BAND


def each_second(errors, torques=(), commands=()):
    """Return a sample a second, at each of which there is a position tick, with e2 as given and the cart at rest."""
    return [Sample(float(k), PositionTick(float(k), ORIGIN, STILL, Reference(ORIGIN, STILL),
                                          TrackingError(0.0, aside, 0.0)),
                   commands[k] if commands else STILL, 0.0, 0.0, WheelVelocity(0.0, 0.0),
                   torques[k] if torques else WheelTorque(0.0, 0.0), UNKNOWN) for k, aside in enumerate(errors)]


def indices(given, parameters=None, outcome='completed'):
    meter = RunMeter(1.0, 1.0, indices=IndexMeter(1.0, parameters))
    for sample in given:
        meter.add(sample)
    return summary(meter.run(outcome))


def test_the_integrals_are_sums_over_the_ticks_before_the_end():
    found = indices(each_second([0.3, -0.5, 0.1, 9.0]))
    assert [found[name] for name in ('iae', 'ise', 'itae', 'itse')] == pytest.approx(
        [0.3 + 0.5 + 0.1, 0.09 + 0.25 + 0.01, 0.5 + 2.0 * 0.1, 0.25 + 2.0 * 0.01], rel=1e-15)
    # of a single sample nothing has an index
    found = indices(each_second([IN]), KNOWN)
    assert {name for name in INDICES if found[name] is None} == {*INDICES} - {'torque_variation', 'command_variation'}


@pytest.mark.parametrize(('errors', 'settling', 'share', 'outcome'), [
    ([OUT, IN, OUT, IN, IN], 3.0, 0.5, 'completed'), ([OUT, OUT, BAND, -BAND, OUT], 2.0, 0.5, 'interrupted'),
    # never outside, never inside, outside at the last tick that counts
    ([IN, IN, IN], 0.0, 1.0, 'broken off'), ([OUT, OUT, IN], None, 0.0, 'completed'),
    ([IN, IN, IN, OUT, IN], None, 0.75, 'completed'),
    # the error of a run that failed has not settled
    *(([OUT, IN, IN], None, 0.5, outcome) for outcome in ('diverged', 'law_failed', 'node_died')),
])
def test_an_error_has_settled_from_the_tick_on_after_which_it_stays_within_the_band(errors, settling, share, outcome):
    found = indices(each_second(errors), outcome=outcome)
    assert (found['settling_time'], found['share_within_band']) == (settling, share)


def test_true_and_cross_track_errors_are_measured_where_they_are_known():
    shown = each_second([OUT, OUT, OUT])
    truth = Truth(Pose(0.1, -0.3, 0.0), STILL, TrackingError(0.0, 0.3, 0.0))
    gone = Truth(Pose(NAN, NAN, NAN), STILL, TrackingError(NAN, NAN, NAN))
    known = indices([shown[0]._replace(truth=truth), shown[1]._replace(truth=gone), shown[2]], KNOWN)
    assert known['iae'] == 0.3
    # the cart is at the origin of the line, of which 0.1 m is within a quarter lap
    assert known['rms_cross_track_error'] == known['max_cross_track_error'] == pytest.approx(0.3, rel=1e-12)
    # where one is not known the largest is not
    first, *others = each_second([0.3, 0.1, 0.1])
    away = Reference(Pose(0.0, 5.0, 0.0), STILL)
    found = indices([first, *(sample._replace(tick=sample.tick._replace(reference=away)) for sample in others)], KNOWN)
    assert found['rms_cross_track_error'] is found['max_cross_track_error'] is None
    assert found['iae'] == 0.4


def test_the_variations_are_sums_of_changes_from_rest():
    torques = [WheelTorque(*pair) for pair in ((0.0, 0.0), (2.0, -1.0), (1.0, -1.0), (1.0, 3.0))]
    commands = [BodyVelocity(*pair) for pair in ((0.5, 0.0), (0.5, 0.0), (0.1, 2.0), (9.0, 9.0))]
    found = indices(each_second([IN] * 4, torques, commands), KNOWN)
    assert found['torque_variation'] == 3.0 + 1.0 + 4.0
    # both rims: 0.5 m/s each, then 0.1 + 0.35 and 0.1 - 0.35 m/s
    assert found['command_variation'] == pytest.approx(2.0 * 0.5 + 0.05 + 0.75, rel=1e-12)
    assert indices(each_second([IN] * 3, [UNKNOWN] * 3), KNOWN)['torque_variation'] is None
    # one that is missing counts as unchanged
    torques = [UNKNOWN, WheelTorque(2.0, 0.0), UNKNOWN, WheelTorque(3.0, 0.0)]
    assert indices(each_second([IN] * 4, torques), KNOWN)['torque_variation'] == 3.0


def test_a_robot_that_stands_while_the_cart_drives_a_lap_of_a_circle():
    parameters = configuration(
        plant={'drive': 'velocity', 'base.dead_zone': [9.0, 9.0], 'initial_pose': [1.0, 0.0, 1.5]},
        reference_cart={'curve': 'circle', 'period': 2.0})
    found = summary(measure(parameters, 2.0))
    assert found['max_position_error'] == pytest.approx(2.0)
    # the chord to the nearer end of the quarters, which is longest when the cart is opposite
    assert found['max_cross_track_error'] == pytest.approx(math.sqrt(2.0), abs=1e-8)
    chords = [2.0 * math.sin(math.pi * max(0.0, min(n, 200 - n) / 200 - 0.25)) for n in range(200)]
    rms = math.sqrt(sum(chord**2 for chord in chords) / 200)
    assert found['rms_cross_track_error'] == pytest.approx(rms, abs=1e-8)


START = {'initial_pose': [0.9, 0.1, 1.0]}
MOTORS = configuration(plant={**START, 'delay.velocity_steps': 1}, position_controller={'controller_type': 'fuzzy'})
BASE = configuration(plant={**START, 'drive': 'velocity', 'base.lag': [0.1, 0.1]})


def trial(parameters, varies):
    made = make_trial(parameters, 1.0)
    return made._replace(form=made.form._replace(varies=varies))


def total(numbers):
    """Return the sum of the changes of some numbers, the first one from 0."""
    return sum(abs(b - a) for a, b in zip([0.0, *numbers], numbers, strict=False))


def test_trials_of_several_forms_sum_the_variation_of_torques_applied_or_rims_commanded():
    """The compiled form is compared in test/closed_loop/test_batch.py."""
    plain, motors, plain_base, base = batch.run_trials(
        [trial(parameters, varies) for parameters in (MOTORS, BASE) for varies in (False, True)], False)
    applied = [sample.applied for sample in rollout(MOTORS, 1.0)][1:]
    assert motors.variation == pytest.approx(
        total([one.right for one in applied]) + total([one.left for one in applied]), rel=1e-12)
    commands = [sample.command for sample in rollout(BASE, 0.998)]
    half = 0.5 * BASE.plant.shared.robot.wheel_separation
    assert base.variation == pytest.approx(
        sum(total([one.linear + side * one.angular for one in commands]) for side in (half, -half)), rel=1e-9)
    # nothing else changes, as text: a base has no torque, which is nan
    assert repr([one._replace(variation=0.0) for one in (motors, base)]) == repr([plain, plain_base])
