"""Input/output linearisation of a point ahead, by hand and by the closed forms of its error and of the heading."""

import math

import numpy as np
import pytest
from helpers.observation import ask, driven

from mobile_robot_control.control import input_output_linearization
from mobile_robot_control.control.input_output_linearization import PointGains
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference
from mobile_robot_control.reference.cart import Placement, reference_at
from mobile_robot_control.reference.curves import CURVES

GAINS = PointGains(k=2.0, distance=0.5)


# the cart's point is 0.1 ahead and 0.2 aside, and moves as the cart; turned by a right angle it is at (0.1 - 0.5, 0.7)
@pytest.mark.parametrize(('error', 'command'), [
    ((0.1, 0.2, 0.0), (0.4 + 0.2, (0.5 * 0.3 + 0.4) / 0.5)),
    ((0.1, 0.2, 0.5 * math.pi), (-0.5 * 0.3 - 0.8, (0.4 + 1.4) / 0.5))])
def test_the_command_is_the_one_by_hand(error, command):
    assert ask(input_output_linearization, error, (0.4, 0.3), GAINS)[1] == pytest.approx(command, abs=1e-14)


def point(pose):
    ahead = np.array([math.cos(pose.heading), math.sin(pose.heading)])
    return np.array(pose[:2]) + GAINS.distance * ahead


# beside the cart, and far from it and facing away
@pytest.mark.parametrize('start', [(0.6, 0.3, 0.2), (-2.0, 3.0, -1.6)])
def test_the_error_of_the_point_decays_at_the_rate_k_however_large_it_is(start):
    def cart_at(t):
        return reference_at(CURVES['trifolium'], t, Placement())

    times = np.linspace(0.0, 5.0, 51)
    poses = driven(input_output_linearization, GAINS, cart_at, start, times)
    errors = np.array([point(cart_at(t).pose) - point(pose)
                       for t, pose in zip(times, poses, strict=True)])
    assert errors == pytest.approx(np.outer(np.exp(-GAINS.k * times), errors[0]), abs=1e-8)


@pytest.mark.parametrize('v_r', [0.4, -0.4])
def test_the_heading_decays_at_v_r_by_b_and_in_reverse_turns_round(v_r):
    def cart_at(t):
        return Reference(Pose(v_r * t, 0.0, 0.0), BodyVelocity(v_r, 0.0))

    # the robot's point is that of the cart
    heading, times = 0.8, np.linspace(0.0, 6.0, 13)
    start = (GAINS.distance * (1.0 - math.cos(heading)), -GAINS.distance * math.sin(heading), heading)
    poses = driven(input_output_linearization, GAINS, cart_at, start, times)
    expected = math.tan(0.4) * np.exp(-v_r / GAINS.distance * times)
    assert [math.tan(0.5 * pose.heading) for pose in poses] == pytest.approx(expected, rel=1e-6)
