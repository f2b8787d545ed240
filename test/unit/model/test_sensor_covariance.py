"""The covariances of odometry are those of the errors that its sensors make."""

import math
import statistics

import pytest
from driving import PERIOD, TRUE_ANGLES, TRUE_ODOMETRY, drive

from mobile_robot_control.model.encoders import Encoders
from mobile_robot_control.model.noise import Noise, pose_variances, twist_variances
from mobile_robot_control.model.odometry import WheelOdometry
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.model.sensor_constants import sensor_constants
from mobile_robot_control.model.sensor_covariance import (
    PoseCovariance,
    grown_covariance,
    sensed_pose_variances,
    sensed_twist_variances,
    wheel_velocity_variance,
)
from mobile_robot_control.quantities import BodyVelocity, Pose

NOISE = Noise((0.01, 0.02, 0.03), 0.1, seed=3)


def constants_of(encoders=TRUE_ANGLES, odometry=TRUE_ODOMETRY, noise=NOISE):
    return sensor_constants(Robot(), noise, encoders, odometry, PERIOD, 5 * PERIOD)


def test_with_noise_alone_they_are_those_of_the_noise():
    assert sensed_twist_variances(constants_of()) == pytest.approx(twist_variances(NOISE, Robot()))
    assert sensed_pose_variances(PoseCovariance(), constants_of()) == pose_variances(NOISE)


def test_rounding_to_ticks_by_hand():
    # a tick of 0.1 rad in 0.01 s: 10 rad/s, 100 / 6 rad²/s², beside 0.01 of the noise
    constants = constants_of(Encoders(1, 0.01))
    constants = constants._replace(encoders=constants.encoders._replace(tick=0.1))
    assert wheel_velocity_variance(constants) == pytest.approx(16.6766667)
    linear, *_, angular = sensed_twist_variances(constants)
    assert linear == pytest.approx(0.5 * 0.035**2 * 16.6766667)
    assert angular == pytest.approx(2.0 * 0.035**2 / 0.35**2 * 16.6766667)


def test_the_twist_from_ticks_errs_by_its_variance():
    encoders = Encoders(100, 0.01)
    # speeds that change slowly against a tick, which the wheels cross at any place
    run = drive([BodyVelocity(0.5 + 2e-5 * k, 0.3) for k in range(3000)], encoders)
    linear, *_, angular = sensed_twist_variances(constants_of(encoders, noise=Noise()))
    errors = [(step.wheels.right - step.wheels.left) * 0.1 - 0.3 for step in run[50:]]
    assert statistics.pvariance(errors) == pytest.approx(angular, rel=0.25)
    errors = [(step.wheels.right + step.wheels.left) * 0.0175 - step.plant.velocity.linear for step in run[50:]]
    assert statistics.pvariance(errors) == pytest.approx(linear, rel=0.25)


def grown_along(velocities, constants):
    """Propagate the covariance along a motion."""
    covariance, pose, before = PoseCovariance(), Pose(0.0, 0.0, 0.0), (0.0, 0.0)
    for step in drive(velocities, period=25_000_000):
        covariance = grown_covariance(
            covariance, pose, step.angles.right - before[0], step.angles.left - before[1], constants)
        pose, before = step.plant.pose, step.angles
    return covariance


def test_on_a_straight_line_slip_grows_as_by_hand():
    constants = constants_of(odometry=WheelOdometry(True, slip=0.01))
    # 2 m: x 2 s² / 2, heading 2 s² 2 / b², and y as the integral of the heading, 2 s² L³ / (3 b²), but for the grid
    covariance = grown_along([BodyVelocity(1.0, 0.0)] * 80, constants)
    assert covariance.x_x == pytest.approx(1e-4)
    assert covariance.heading_heading == pytest.approx(4e-4 / 0.35**2)
    assert covariance.y_y == pytest.approx(2e-4 * 8.0 / 3.0 / 0.35**2, rel=0.02)
    assert covariance.y_heading == pytest.approx(2e-4 * 2.0 / 0.35**2, rel=0.02)
    variances = sensed_pose_variances(covariance, constants)
    assert variances == pytest.approx((1e-4 + 1e-4, covariance.y_y + 4e-4, 0.0, 0.0, 0.0,
                                       covariance.heading_heading + 9e-4))


def test_a_long_step_propagates_as_its_derivatives_say():
    constants = constants_of(odometry=WheelOdometry(True, (0.1, -0.1), 0.2, slip=0.01))
    right_radius, left_radius, separation = constants.odometry.calibration
    before = PoseCovariance(0.04, 0.01, 0.02, 0.05, -0.01, 0.03)

    def end(x, y, heading, right, left):
        distance, turn = 0.5 * (right + left), (right - left) / separation
        return (x + distance * math.cos(heading + 0.5 * turn), y + distance * math.sin(heading + 0.5 * turn),
                heading + turn)

    place, ways = (1.0, 2.0, 0.5), (20.0 * right_radius, 12.0 * left_radius)
    columns = []
    for n in range(5):
        ends = [end(*(value + side * 1e-5 * (m == n) for m, value in enumerate((*place, *ways)))) for side in (1, -1)]
        columns.append([(a - b) / 2e-5 for a, b in zip(*ends, strict=True)])
    xx, xy, xh, yy, yh, hh = before
    inner = [[xx, xy, xh, 0, 0], [xy, yy, yh, 0, 0], [xh, yh, hh, 0, 0],
             [0, 0, 0, 1e-4 * right_radius**2 / 0.035 * 20.0, 0], [0, 0, 0, 0, 1e-4 * left_radius**2 / 0.035 * 12.0]]
    expected = [sum(columns[i][a] * inner[i][j] * columns[j][b] for i in range(5) for j in range(5))
                for a, b in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]
    assert grown_covariance(before, Pose(*place), 20.0, 12.0, constants) == pytest.approx(expected, rel=1e-6)


def test_dead_reckoning_errs_by_the_covariance_that_has_grown():
    odometry, arc = WheelOdometry(True, slip=0.005), [BodyVelocity(1.0, 1.5)] * 40
    ends = [drive(arc, odometry=odometry, noise=Noise(seed=seed), period=25_000_000)[-1] for seed in range(300)]
    covariance = grown_along(arc, constants_of(odometry=odometry))
    true = ends[0].plant.pose
    errors = [(end.pose.x - true.x, end.pose.y - true.y, end.pose.heading - true.heading) for end in ends]

    def product(a, b):
        return statistics.fmean(error[a] * error[b] for error in errors)

    for (a, b), expected in zip(((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)), covariance, strict=True):
        size = math.sqrt(product(a, a) * product(b, b))
        assert product(a, b) == pytest.approx(expected, abs=0.25 * size)


def test_the_rounding_of_the_last_angles_is_in_the_pose_of_dead_reckoning():
    plain, ticked = (sensed_pose_variances(PoseCovariance(), constants_of(encoders, WheelOdometry(True), Noise()))
                     for encoders in (Encoders(), Encoders(1000)))
    assert plain == (0.0,) * 6
    way = (0.035 * 2.0 * math.pi / 1000.0) ** 2 / 12.0
    assert ticked == pytest.approx((0.5 * way, 0.5 * way, 0.0, 0.0, 0.0, 2.0 * way / 0.35**2))
