"""Stability of the sampled velocity loop: spectral radius and slowest stable rate."""

import re

import chapter
import pytest
from each import each_row

from mobile_robot_control.control.velocity_pi import VelocityGains
from mobile_robot_control.control.velocity_stability import instability, slowest_stable_rate, spectral_radius
from mobile_robot_control.model.robot import Robot

ROBOT = Robot()
EVOLVED = VelocityGains(**chapter.EVOLVED_VELOCITY_GAINS)
THRESHOLDS = [(0, 1577.0), (1, 3154.0), (2, 5104.0)]


@each_row(('delay', 'rate'), THRESHOLDS)
def test_the_slowest_stable_rate_of_the_evolved_gains(delay, rate):
    assert slowest_stable_rate(EVOLVED, ROBOT, 500.0, (delay,)) == pytest.approx(rate, rel=1e-3)
    assert spectral_radius(EVOLVED, ROBOT, 0.999 * rate, delay) > 1.0
    assert spectral_radius(EVOLVED, ROBOT, 1.001 * rate, delay) < 1.0


def test_the_spectral_radius_by_hand():
    # without friction and with a negligible integral the poles are 1 - gain dt / inertia and 1
    robot = Robot(viscous_friction=0.0)
    gains = VelocityGains(k1=100.0, ti1=1e12, k2=1e-6, ti2=1e12)
    # K1 R / (A+B) = 17.5 / 0.007125
    assert spectral_radius(gains, robot, 1000.0, 0) == pytest.approx(17.5 / 7.125 - 1.0, rel=1e-9)


@each_row(('rate', 'lockstep', 'slowest'), [(1000.0, True, 1577.0), (4000.0, False, 5104.0)])
def test_instability_names_the_radius_and_the_slowest_rate(rate, lockstep, slowest):
    text = instability(EVOLVED, ROBOT, rate, lockstep)
    radius = max(spectral_radius(EVOLVED, ROBOT, rate, delay) for delay in ((0,) if lockstep else (1, 2)))
    assert f'spectral radius {radius:.4f}' in text
    named = re.search(r'the slowest stable rate is ([\d.]+) Hz', text)
    assert float(named[1]) == pytest.approx(slowest, rel=1e-3)
    assert f'velocity_rate = {rate} Hz' in text
    for name, value in EVOLVED._asdict().items():
        assert f'gains.{name} = {value}' in text
    assert ('in lockstep' in text) == lockstep
    assert ('on the wall clock' in text) == (not lockstep)


def test_constants_that_no_robot_has_are_named_and_no_rate_beyond_what_is_allowed():
    text = instability(VelocityGains(), Robot(wheel_separation=1e6), 500.0, lockstep=True)
    assert 'with robot.wheel_separation = 1000000.0: ' in text
    assert 'no rate that is allowed is stable; set robot.*' in text
    assert 'Hz: raise' not in text


def test_the_wall_clock_takes_the_worse_of_one_and_two_samples():
    # stable with one sample of delay at 4 kHz, not with two
    assert spectral_radius(EVOLVED, ROBOT, 4000.0, 1) < 1.0 < spectral_radius(EVOLVED, ROBOT, 4000.0, 2)
    assert instability(EVOLVED, ROBOT, 4000.0, lockstep=False)


@each_row('gain', [1e200, 1e308])
def test_absurd_gains_are_unstable_rather_than_an_overflow(gain):
    for name in ('k1', 'k2'):
        assert instability(VelocityGains()._replace(**{name: gain}), ROBOT, 500.0, lockstep=False)
