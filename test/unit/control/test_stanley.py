"""The law of Stanley by hand, and by the closed forms of its errors."""

import math

import numpy as np
import pytest
from helpers.observation import ask, driven

from mobile_robot_control.control import stanley
from mobile_robot_control.control.stanley import StanleyGains
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference

GAINS = StanleyGains(k=2.0, kx=0.5, wheelbase=0.5, softening=0.05, max_steer=1.5708)


# v = 0.4 + 0.5 * 0.1, and k e = 0.5 = k_soft + v: δ = π/4; one that faces away turns on the spot; the cart is behind
@pytest.mark.parametrize(('error', 'command'), [
    ((0.1, 0.25, 0.0), (0.45 * math.sqrt(0.5), 0.45 * math.sqrt(0.5) / 0.5)),
    ((0.9, 0.2, 3.0), (0.0, (0.65 + 0.2 * math.cos(3.0) + 0.1 * math.sin(3.0)) / 0.5)),
    ((-4.0, 0.25, 0.0), (0.0, 0.0))])
def test_the_command_is_the_one_by_hand(error, command):
    assert ask(stanley, error, (0.4, 0.0), GAINS)[1] == pytest.approx(command, abs=1e-5)


def test_a_front_wheel_on_that_of_the_cart_moves_as_it_does():
    sin, cos = math.sin(0.5), math.cos(0.5)
    _, command = ask(stanley, (0.5 - 0.5 * cos, -0.5 * sin, 0.5), (0.4, 0.6), GAINS)
    assert command == pytest.approx((0.4 * cos - 0.3 * sin, (0.4 * sin + 0.3 * cos) / 0.5), abs=1e-12)


def driven_on_the_line(gains, start, times):
    """Return the gaps of the front wheel ahead and aside of a robot behind a cart at 0.4 m/s, by time."""
    poses = driven(stanley, gains, lambda t: Reference(Pose(0.4 * t, 0.0, 0.0), BodyVelocity(0.4, 0.0)), start, times)
    return np.array([(0.4 * t + gains.wheelbase * (1.0 - math.cos(pose.heading)) - pose.x,
                      -pose.y - gains.wheelbase * math.sin(pose.heading))
                     for t, pose in zip(times, poses, strict=True)]).T


@pytest.mark.parametrize('start', [(0.0, -0.6, 0.3), (0.0, 0.4, -0.3)])
def test_the_cross_track_error_obeys_its_closed_form_however_large_it_is(start):
    """Of ė = -k e / √(1 + (k e / v)²): √(1 + u²) - arsinh(1 / u) falls at the rate k, where u = k e / v."""
    times = np.linspace(0.0, 3.0, 31)
    _, aside = driven_on_the_line(GAINS._replace(kx=0.0, softening=1e-9), start, times)
    u = GAINS.k * np.abs(aside) / 0.4
    fallen = np.sqrt(1.0 + u * u) - np.arcsinh(1.0 / u)
    assert u[0] > 1.2
    assert fallen == pytest.approx(fallen[0] - GAINS.k * times, abs=1e-6)


@pytest.mark.parametrize('kx', [0.0, 0.5])
def test_a_gap_ahead_decays_at_the_rate_k_x_and_stays_without_it(kx):
    times = np.linspace(0.0, 3.0, 31)
    ahead, _ = driven_on_the_line(GAINS._replace(kx=kx), (-0.3, 0.0, 0.0), times)
    assert ahead == pytest.approx(0.3 * np.exp(-kx * times), abs=1e-8)


def test_a_cart_in_reverse_turns_the_robot_round():
    times = np.linspace(0.0, 8.0, 9)
    poses = driven(stanley, GAINS, lambda t: Reference(Pose(-0.4 * t, 0.0, 0.0), BodyVelocity(-0.4, 0.0)),
                   (0.0, 0.0, 1e-3), times)
    # at the rate v_r / wheelbase, as soon as the front wheel is on the line
    assert poses[5].heading / poses[3].heading == pytest.approx(math.exp(1.6), rel=0.01)
