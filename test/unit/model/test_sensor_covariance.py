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
    sensed_pose_variances,
    sensed_twist_variances,
    wheel_velocity_variance,
)
from mobile_robot_control.quantities import BodyVelocity

NOISE = Noise((0.01, 0.02, 0.03), 0.1, seed=3)


def constants_of(encoders=TRUE_ANGLES, odometry=TRUE_ODOMETRY, noise=NOISE):
    return sensor_constants(Robot(), noise, encoders, odometry, PERIOD, 5 * PERIOD)


def test_with_noise_alone_they_are_those_of_the_noise():
    assert sensed_twist_variances(constants_of()) == pytest.approx(twist_variances(NOISE, Robot()))
    assert sensed_pose_variances(constants_of()) == pose_variances(NOISE)


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


def test_the_rounding_of_the_last_angles_is_in_the_pose_of_dead_reckoning():
    plain, ticked = (sensed_pose_variances(constants_of(encoders, WheelOdometry(True), Noise()))
                     for encoders in (Encoders(), Encoders(1000)))
    assert plain == (0.0,) * 6
    way = (0.035 * 2.0 * math.pi / 1000.0) ** 2 / 12.0
    assert ticked == pytest.approx((0.5 * way, 0.5 * way, 0.0, 0.0, 0.0, 2.0 * way / 0.35**2))
