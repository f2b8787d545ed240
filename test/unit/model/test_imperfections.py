"""Noise, delay and disturbance, each by itself."""

import math
import statistics

import pytest
from each import each_row

from mobile_robot_control.model.actuators import Delay, delayed, empty_line
from mobile_robot_control.model.disturbance import Disturbance, disturbed, wheel_torques_of, with_push
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
from mobile_robot_control.quantities import BodyVelocity, Pose, Push, WheelTorque, WheelVelocity

N = 20000
HERE = Pose(1.0, -2.0, 3.1)


def correlation(a, b):
    return statistics.fmean(x * y for x, y in zip(a, b, strict=True))


def test_the_noise_is_standard_normal_and_independent():
    drawn = {(seed, channel): [gaussian(seed, channel, k) for k in range(N)] for seed in (0, 1) for channel in (0, 1)}
    for numbers in drawn.values():
        assert abs(statistics.fmean(numbers)) < 4.0 / math.sqrt(N)
        assert statistics.pvariance(numbers) == pytest.approx(1.0, abs=4.0 * math.sqrt(2.0 / N))
        inside = sum(abs(x) < 1.0 for x in numbers) / N
        assert inside == pytest.approx(0.6827, abs=0.015)
        assert abs(correlation(numbers[1:], numbers[:-1])) < 4.0 / math.sqrt(N)
    first, *others = drawn.values()
    for other in others:
        assert abs(correlation(first, other)) < 4.0 / math.sqrt(N)


def test_without_noise_measurements_equal_the_true_values():
    wheels, velocity = WheelVelocity(1.0, 2.0), BodyVelocity(0.1, 0.2)
    assert measured_pose(HERE, Noise(), 3) is HERE
    assert measured_wheels(wheels, Noise(), 3) is wheels
    assert measured_twist(velocity, wheels, Noise(), Robot()) is velocity


def test_the_noise_has_the_covariances_published_in_odom():
    noise, robot = Noise((0.01, 0.02, 0.03), 0.5, seed=3), Robot()
    velocity = BodyVelocity(0.3, -0.4)
    poses, twists = [], []
    for k in range(N):
        pose = measured_pose(Pose(1.0, -2.0, 0.3), noise, k)
        wheels = measured_wheels(wheel_velocity(velocity, robot), noise, k)
        poses.append(pose)
        twists.append(measured_twist(velocity, wheels, noise, robot))
    for axis, mean, variance in ((0, 1.0, 0), (1, -2.0, 1), (2, 0.3, 5)):
        values = [pose[axis] for pose in poses]
        assert statistics.fmean(values) == pytest.approx(mean, abs=1e-3)
        assert statistics.pvariance(values) == pytest.approx(pose_variances(noise)[variance], rel=0.05)
    for axis, mean, variance in ((0, 0.3, 0), (1, -0.4, 5)):
        values = [twist[axis] for twist in twists]
        assert statistics.fmean(values) == pytest.approx(mean, abs=2e-3)
        assert statistics.pvariance(values) == pytest.approx(twist_variances(noise, robot)[variance], rel=0.05)
    both = correlation([v - 0.3 for v, _ in twists], [w + 0.4 for _, w in twists])
    assert abs(both) < 0.05 * math.sqrt(twist_variances(noise, robot)[0] * twist_variances(noise, robot)[5])


def test_a_noisy_heading_is_wrapped():
    headings = [measured_pose(HERE, Noise((0.0, 0.0, 0.5)), k).heading for k in range(100)]
    assert all(-math.pi < heading <= math.pi for heading in headings)
    assert min(headings) < 0.0 < max(headings)


@each_row('steps', [0, 1, 3])
def test_torques_are_applied_late_by_the_delay(steps):
    line, acting = empty_line(Delay(steps)), []
    for k in range(1, 7):
        line, torque = delayed(line, WheelTorque(float(k), -float(k)))
        acting.append(torque)
        assert len(line) == steps
    late = [WheelTorque(0.0, 0.0)] * steps + [WheelTorque(float(k), -float(k)) for k in range(1, 7)]
    assert acting == late[:6]


def test_an_impulse_lasts_one_period_and_a_step_for_good():
    torque = WheelTorque(1.0, 2.0)
    pushed = [disturbed(torque, Disturbance(0.25, (0.5, 0.25), (0.0, -3.0)), k, 0.125) for k in range(5)]
    assert pushed == [(1.0, 2.0), (1.0, 2.0), (5.0, 1.0), (1.0, -1.0), (1.0, -1.0)]
    assert disturbed(torque, Disturbance(0.25), 7, 0.125) is torque


def test_a_push_does_the_same_work_as_its_torques_on_the_wheels():
    robot, wrench = Robot(wheel_radius=0.1, wheel_separation=0.4), Push(3.0, -0.5)
    torque = wheel_torques_of(wrench, robot)
    # 0.05 (3 ± 0.5 / 0.2)
    assert torque == pytest.approx((0.025, 0.275))
    for velocity in (BodyVelocity(1.0, 0.0), BodyVelocity(0.0, 1.0), BodyVelocity(-0.7, 2.0)):
        wheels = wheel_velocity(velocity, robot)
        assert torque.right * wheels.right + torque.left * wheels.left == pytest.approx(
            3.0 * velocity.linear - 0.5 * velocity.angular)


def test_a_push_acts_in_one_step_beside_impulse_and_step():
    robot, lasting = Robot(wheel_radius=0.1, wheel_separation=0.4), Disturbance(0.25, (0.5, 0.0), (0.0, -3.0))
    one = with_push(lasting, Push(3.0, -0.5), 2, 0.125, robot)
    assert disturbed(WheelTorque(1.0, 2.0), one, 2, 0.125) == pytest.approx((5.025, -0.725))
    before = with_push(lasting, Push(3.0, -0.5), 1, 0.125, robot)
    assert disturbed(WheelTorque(1.0, 2.0), before, 1, 0.125) == pytest.approx((1.025, 2.275))


def test_the_same_place_of_a_sequence_has_the_same_number_in_every_version():
    assert [gaussian(*place) for place in ((7, 1, 5), (7, 1, 6), (123456, 3, 10**6))] == [
        0.12711440351769684, -1.2278496992711858, -0.31690598789478797]
