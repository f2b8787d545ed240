"""Sensors that are not ideal: numbers by hand, when odometry is sampled and arrives, and its covariances."""

import itertools
import math
import statistics

import pytest
from helpers.driving import DT, PERIOD, QUIET, ROBOT, TRUE_ANGLES, TRUE_ODOMETRY, drive, shown_steps

from mobile_robot_control.model.dynamics import PlantState, at_rest
from mobile_robot_control.model.events import events_at, events_until, is_event
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.model.noise import Noise, measured_pose, measured_wheels, pose_variances, twist_variances
from mobile_robot_control.model.odometry import (
    Calibration,
    Encoders,
    WheelAngles,
    WheelOdometry,
    angle_velocity,
    encoder_angles,
    encoder_constants,
    odometer_motion,
    wheel_slip,
)
from mobile_robot_control.model.sensors import (
    advance_sensors,
    is_ideal,
    sensed_pose_variances,
    sensed_twist_variances,
    sensor_constants,
    sensor_violations,
    sensors_at_start,
    wheel_velocity_variance,
)
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelVelocity

STRAIGHT = [BodyVelocity(0.5, 0.0)] * 1000
QUARTER = [BodyVelocity(0.5, 1.0)] * round(0.5 * math.pi / DT)
NOISE = Noise((0.01, 0.02, 0.03), 0.1, seed=3)


def constants_of(encoders=TRUE_ANGLES, odometry=TRUE_ODOMETRY, noise=QUIET):
    return sensor_constants(ROBOT, noise, encoders, odometry, PERIOD, 5 * PERIOD)


def test_angles_are_in_whole_ticks_and_the_wheels_start_between_two_edges():
    encoders = encoder_constants(Encoders(ticks=8), PERIOD)
    tick = math.pi / 4.0
    for turned, ticks in ((0.0, 0), (0.49, 0), (0.51, 1), (1.49, 1), (-0.49, 0), (-0.51, -1), (17.2, 17)):
        assert encoder_angles(turned * tick, -turned * tick, encoders) == (ticks * tick, -ticks * tick)
    assert encoder_angles(1.25, -7.5, encoder_constants(Encoders(), PERIOD)) == (1.25, -7.5)


def test_a_velocity_is_a_difference_of_ticks_over_the_window():
    # 0.01 s is 5 periods of 2 ms, 0.0101 s is 6 of them
    for window, expected in ((0.01, (5, 0.01, True)), (0.0101, (6, 0.012, True)), (0.0, (1, 0.002, True))):
        assert encoder_constants(Encoders(1000, window), PERIOD)[1:] == expected
    assert encoder_constants(Encoders(), PERIOD).differences is False
    assert angle_velocity(WheelAngles(3.0, 1.0), WheelAngles(2.0, 2.0), 0.5) == (2.0, -2.0)
    # 1 rad/s turns the wheel by 1.59 ticks in 0.01 s: velocities of one and of two ticks of 0.628 rad/s each
    run = drive([BodyVelocity(ROBOT.wheel_radius, 0.0)] * 200, Encoders(1000, 0.01))
    tick = 2.0 * math.pi / 1000.0 / 0.01
    seen = [step.wheels.right for step in run[10:]]
    assert {round(velocity / tick, 9) for velocity in seen} == {1.0, 2.0}
    assert statistics.fmean(seen) == pytest.approx(1.0, rel=0.03)


@pytest.mark.parametrize(('period', 'taken', 'arrived'), [
    # 33.3 ms, 66.7 ms, 100 ms ... at the next multiple of 2 ms, and 30 steps for 60 ms
    (2_000_000, [0, 17, 34, 50, 67, 84, 100], [30, 47, 64, 80, 97, 114, 130]),
    # ... of 10 ms, and 6 steps
    (10_000_000, [0, 4, 7, 10, 14, 17, 20], [6, 10, 13, 16, 20, 23, 26]),
])
def test_odometry_at_30_hz_that_is_60_ms_late(period, taken, arrived):
    shown = shown_steps(WheelOdometry(rate=30.0, latency=0.06), period, arrived[-1] + 1)
    # before the first arrives, the start is shown
    assert shown[:arrived[0] + 1] == [0] * (arrived[0] + 1)
    changes = [k for k in range(1, len(shown)) if shown[k] != shown[k - 1]]
    assert changes == arrived[1:]
    assert [shown[k] for k in changes] == taken[1:]


def test_jitter_delays_each_sample_by_up_to_its_length():
    odometry = WheelOdometry(rate=20.0, latency=0.02, jitter=0.01)
    shown = shown_steps(odometry, PERIOD, 5000)
    late = [k - shown[k] - 10 for k in range(1, len(shown)) if shown[k] != shown[k - 1]]
    assert len(late) == 5000 // 25 - 1
    assert {*late} == {0, 1, 2, 3, 4, 5}
    assert statistics.fmean(late) == pytest.approx(2.5, abs=0.3)


@pytest.mark.parametrize(('rate', 'period', 'step', 'number'), [
    (30.0, 2_000_000, 500 * 86400 * 365, 30 * 86400 * 365), (60.0, 2_000_000, 50, 6),
    (1.0 / 0.033, 33_000_000, 10**9, 10**9), (62.5, 1_000_000, 16 * 10**9, 10**9), (0.001, 10_000, 10**8, 1),
])
def test_events_do_not_drift(rate, period, step, number):
    events = events_at(rate, period)
    assert [events_until(step + offset, events) for offset in (-1, 0)] == [number - 1, number]
    assert [is_event(step + offset, events) for offset in (0, 1)] == [True, number == step]
    # products stay below 2**63 for as many steps as a compiled run can have
    assert max(events) <= 10**9


def test_with_all_off_the_sensors_show_what_ideal_ones_do():
    for step in drive([BodyVelocity(0.3, 0.02 * k) for k in range(50)], noise=NOISE):
        wheels = measured_wheels(wheel_velocity(step.plant.velocity, ROBOT), NOISE, step.k)
        assert step.wheels == wheels
        assert step.angles == (step.plant.right_angle, step.plant.left_angle)
        if step.k % 5 == 0:
            assert step.pose == measured_pose(step.plant.pose, NOISE, step.k)
            assert step.velocity == pytest.approx(
                odometer_motion(wheels, Calibration(0.035, 0.035, 0.35)), abs=1e-12)


def test_with_all_off_the_covariance_is_that_of_the_noise():
    assert sensed_twist_variances(constants_of(noise=NOISE)) == pytest.approx(twist_variances(NOISE, ROBOT))
    assert sensed_pose_variances(constants_of(noise=NOISE)) == pose_variances(NOISE)


def test_the_twist_is_that_of_the_wheels_with_the_radii_and_the_separation_of_odometry():
    # r_R = 0.0385 m, r_L = 0.0315 m, b = 0.4375 m: v = (0.0385 + 0.0315) / 2 * 10, omega = 0.007 * 10 / 0.4375
    calibration = constants_of(odometry=WheelOdometry(radius_error=(0.1, -0.1), separation_error=0.25)
                               ).odometry.calibration
    assert calibration == pytest.approx((0.0385, 0.0315, 0.4375))
    assert odometer_motion(WheelVelocity(10.0, 10.0), calibration) == pytest.approx((0.35, 0.16))


@pytest.mark.parametrize(('velocities', 'errors', 'length', 'curvature'), [
    # 1000 steps of 1 mm
    (STRAIGHT, {'radius_error': (0.02, 0.02)}, 1.02, 0.0),
    # a quarter of a circle of 0.5 m becomes a part of one of 0.625 m
    (QUARTER, {'separation_error': 0.25}, 0.5 * DT * len(QUARTER), 1.0 / 0.625),
    # the difference of both radii over their mean and over the separation
    (STRAIGHT, {'radius_error': (0.01, -0.01)}, 1.0, 0.02 / 0.35),
])
def test_errors_of_radius_and_separation_lengthen_or_bend_the_way(velocities, errors, length, curvature):
    end = drive(velocities, odometry=WheelOdometry(True, **errors))[-1].pose
    turn = length * curvature
    assert end == pytest.approx((length, 0.0, 0.0) if not turn else (
        math.sin(turn) / curvature, (1.0 - math.cos(turn)) / curvature, turn), abs=1e-12)


def test_slip_spreads_the_pose_by_the_square_root_of_the_way():
    for steps, period in ((40, 25_000_000), (20, 50_000_000)):
        ends = [drive([BodyVelocity(1.0, 0.0)] * steps, odometry=WheelOdometry(True, slip=0.01), period=period,
                      noise=Noise(seed=seed))[-1].pose for seed in range(150)]
        # of the mean of two wheels, and of their difference over the separation, after 1 m
        assert statistics.stdev(end.x for end in ends) == pytest.approx(0.01 / math.sqrt(2.0), rel=0.15)
        assert statistics.stdev(end.heading for end in ends) == pytest.approx(0.01 * math.sqrt(2.0) / 0.35, rel=0.15)
        assert abs(statistics.fmean(end.heading for end in ends)) < 4.0 * 0.04 / math.sqrt(300.0)


def test_slip_is_independent_of_the_noise_on_the_velocities():
    odometry = constants_of(odometry=WheelOdometry(True, slip=math.sqrt(0.035))).odometry
    drawn = [(*wheel_slip(WheelAngles(1.0, 1.0), k, 3, odometry),
              *measured_wheels(WheelVelocity(0.0, 0.0), Noise(velocity=1.0, seed=3), k)) for k in range(2000)]
    for one, other in itertools.combinations(range(4), 2):
        assert abs(statistics.fmean(numbers[one] * numbers[other] for numbers in drawn)) < 4.0 / math.sqrt(2000.0)


@pytest.mark.parametrize('value', [math.inf, math.nan])
def test_a_motion_that_has_diverged_is_not_measured(value):
    constants = constants_of(Encoders(100), WheelOdometry(True, slip=0.1))
    sensors = sensors_at_start(at_rest(Pose(0.0, 0.0, 0.0)), constants)
    gone = PlantState(Pose(value, 0.0, value), BodyVelocity(value, value), value, value)
    assert advance_sensors(sensors, gone, 1, constants) is sensors


@pytest.mark.parametrize(('changed', 'ideal'), [
    (TRUE_ODOMETRY, True), (WheelOdometry(slip=0.1), True), (WheelOdometry(dead_reckoning=True), False),
    (WheelOdometry(rate=30.0), False), (WheelOdometry(latency=0.01), False),
    (WheelOdometry(radius_error=(0.0, 0.1)), False), (WheelOdometry(separation_error=0.1), False),
    (Encoders(ticks=100), False), (Encoders(window=0.1), False),
])
def test_sensors_are_ideal_until_a_parameter_changes_but_for_slip_without_dead_reckoning(changed, ideal):
    both = (changed, TRUE_ODOMETRY) if isinstance(changed, Encoders) else (TRUE_ANGLES, changed)
    assert is_ideal(*both) is ideal


@pytest.mark.parametrize(('changed', 'text', 'accepted', 'refused'), [
    (Encoders(window=0.5), 'encoders.window = 0.5 s is 250 periods of the velocity loop, more than 64; '
     'take at most 0.128 s', {'window': 0.128}, {'window': 0.1281}),
    (WheelOdometry(latency=1.0), 'odometry.latency = 1.0 s with a sample at each position tick keeps 100 samples on '
     'their way, more than 64; take a latency of at most 0.64 s, or a lower odometry.rate', {'latency': 0.64},
     {'latency': 0.68}),
    (WheelOdometry(rate=30.0, latency=3.0), 'odometry.latency = 3.0 s with odometry.rate = 30.0 Hz keeps 90 samples on '
     'their way, more than 64; take a latency of at most 2.132 s, or a lower odometry.rate', {'latency': 2.132},
     {'latency': 2.172}),
    (WheelOdometry(rate=1e-4), 'odometry.rate = 0.0001 Hz is below 0.001 Hz; take at least 0.001 Hz, or 0 for every '
     'position tick', {'rate': 1e-3}, {'rate': 0.9e-3}),
])
def test_sensors_that_keep_too_many_samples_are_refused_with_the_largest_value_allowed(
        changed, text, accepted, refused):
    def violations(one):
        both = (one, TRUE_ODOMETRY) if isinstance(one, Encoders) else (TRUE_ANGLES, one)
        return list(sensor_violations(*both, PERIOD, 5 * PERIOD))

    assert violations(changed) == [text]
    assert not violations(changed._replace(**accepted))
    assert violations(changed._replace(**refused))


def test_rounding_to_ticks_by_hand():
    # a tick of 0.1 rad in 0.01 s: 10 rad/s, 100 / 6 rad²/s², beside 0.01 of the noise
    constants = constants_of(Encoders(1, 0.01), noise=NOISE)
    constants = constants._replace(encoders=constants.encoders._replace(tick=0.1))
    assert wheel_velocity_variance(constants) == pytest.approx(16.6766667)
    linear, *_, angular = sensed_twist_variances(constants)
    assert (linear, angular) == pytest.approx(
        (0.5 * 0.035**2 * 16.6766667, 2.0 * 0.035**2 / 0.35**2 * 16.6766667))
    # the last angles are in the pose of dead reckoning
    plain, ticked = (sensed_pose_variances(constants_of(encoders, WheelOdometry(True)))
                     for encoders in (TRUE_ANGLES, Encoders(1000)))
    assert plain == (0.0,) * 6
    way = (0.035 * 2.0 * math.pi / 1000.0) ** 2 / 12.0
    assert ticked == pytest.approx((0.5 * way, 0.5 * way, 0.0, 0.0, 0.0, 2.0 * way / 0.35**2))
