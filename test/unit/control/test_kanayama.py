"""The law of Kanayama et al."""

import math

import pytest
from each import each_row
from observation import observed

from mobile_robot_control.control import backstepping, kanayama
from mobile_robot_control.control.backstepping import BacksteppingGains
from mobile_robot_control.control.kanayama import KanayamaGains
from mobile_robot_control.control.law import NoState
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError

GAINS = KanayamaGains(kx=2.0, ky=10.0, ktheta=4.0)


def ask(error, velocity=(0.5, 0.2), gains=GAINS):
    return kanayama.step(NoState(), observed(
        TrackingError(*error), Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(*velocity))), gains, 0.01)[1]


@each_row(('error', 'command'), [
    # faster by kx e1, turning left by v_r ky e2, by v_r ktheta sin e3 with the speed v_r cos e3
    ((0.1, 0.0, 0.0), (0.7, 0.2)), ((0.0, 0.1, 0.0), (0.5, 0.7)), ((0.0, 0.0, 0.5 * math.pi), (0.0, 2.2)),
])
def test_equation_8_of_the_paper_with_hand_numbers(error, command):
    assert ask(error) == pytest.approx(command, abs=1e-15)


@each_row('error', [(0.3, -0.2, 0.7), (-1.0, 0.5, 2.9), (0.1, 0.4, -1.8)])
@each_row('v_r', [0.2, 0.7])
def test_backstepping_at_alpha_1_is_this_law_with_a_constant_heading_gain(error, v_r):
    gains = BacksteppingGains(p=1.5, q=0.5, alpha=1.0, f=2.0, g=3.0)
    # K_x = p f, K_y = 2 p / q, and the heading gain is q g where this law has K_θ v_r
    same = KanayamaGains(kx=1.5 * 2.0, ky=2.0 * 1.5 / 0.5, ktheta=0.5 * 3.0 / v_r)
    _, other = backstepping.step(NoState(), observed(
        TrackingError(*error), Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(v_r, -0.4))), gains, 0.01)
    assert ask(error, (v_r, -0.4), same) == pytest.approx(other, rel=1e-14)
