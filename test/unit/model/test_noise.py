"""Noise: standard normal numbers, and the covariances that odometry publishes."""

import itertools
import math
import statistics

import pytest

from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.model.noise import (
    Noise,
    gaussian,
    measured_pose,
    measured_twist,
    measured_wheels,
    pose_variances,
    twist_variances,
)
from mobile_robot_control.model.robot import Robot
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelVelocity

N = 20000
HERE = Pose(1.0, -2.0, 3.1)


def correlation(a, b):
    return statistics.fmean(x * y for x, y in zip(a, b, strict=True))


def test_the_noise_is_standard_normal_and_independent_and_the_same_in_every_version():
    drawn = [[gaussian(seed, channel, k) for k in range(N)] for seed in (0, 1) for channel in (0, 1)]
    for numbers in drawn:
        assert abs(statistics.fmean(numbers)) < 4.0 / math.sqrt(N)
        assert statistics.pvariance(numbers) == pytest.approx(1.0, abs=4.0 * math.sqrt(2.0 / N))
        assert sum(abs(x) < 1.0 for x in numbers) / N == pytest.approx(0.6827, abs=0.015)
        assert abs(correlation(numbers[1:], numbers[:-1])) < 4.0 / math.sqrt(N)
    assert all(abs(correlation(*two)) < 4.0 / math.sqrt(N) for two in itertools.combinations(drawn, 2))
    assert [gaussian(*place) for place in ((7, 1, 5), (7, 1, 6), (123456, 3, 10**6))] == [
        0.12711440351769684, -1.2278496992711858, -0.31690598789478797]


def test_without_noise_measurements_equal_the_true_values():
    wheels, velocity = WheelVelocity(1.0, 2.0), BodyVelocity(0.1, 0.2)
    assert measured_pose(HERE, Noise(), 3) is HERE
    assert measured_wheels(wheels, Noise(), 3) is wheels
    assert measured_twist(velocity, wheels, Noise(), Robot()) is velocity


def test_the_noise_has_the_covariances_published_in_odom_and_its_heading_is_wrapped():
    noise, robot, velocity = Noise((0.01, 0.02, 0.03), 0.5, seed=3), Robot(), BodyVelocity(0.3, -0.4)
    poses = [measured_pose(Pose(1.0, -2.0, 0.3), noise, k) for k in range(N)]
    twists = [measured_twist(velocity, measured_wheels(wheel_velocity(velocity, robot), noise, k), noise, robot)
              for k in range(N)]
    found = [*zip(*poses, strict=True), *zip(*twists, strict=True)]
    of_pose, of_twist = pose_variances(noise), twist_variances(noise, robot)
    variances = (of_pose[0], of_pose[1], of_pose[5], of_twist[0], of_twist[5])
    for values, mean, variance in zip(found, (1.0, -2.0, 0.3, 0.3, -0.4), variances, strict=True):
        assert statistics.fmean(values) == pytest.approx(mean, abs=2e-3)
        assert statistics.pvariance(values) == pytest.approx(variance, rel=0.05)
    both = correlation([v - 0.3 for v, _ in twists], [w + 0.4 for _, w in twists])
    assert abs(both) < 0.05 * math.sqrt(of_twist[0] * of_twist[5])
    headings = [measured_pose(HERE, Noise((0.0, 0.0, 0.5)), k).heading for k in range(100)]
    assert -math.pi < min(headings) < 0.0 < max(headings) <= math.pi
