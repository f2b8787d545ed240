"""Regulated pure pursuit by hand, and by the closed forms of a line and a circle."""

import cmath
import math

import numpy as np
import pytest
from helpers.observation import driven, observed

from mobile_robot_control.control import regulated_pure_pursuit
from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.regulated_pure_pursuit import PursuitGains, lookahead_point
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference

GAINS = PursuitGains(lookahead_time=1.5, least_lookahead=0.1, radius=0.01, kx=0.0)


def on_the_line(v, t):
    return Reference(Pose(v * t, 0.0, 0.0), BodyVelocity(v, 0.0))


def seen(pose, cart, coming=()):
    """Return what a robot at a pose sees."""
    return observed(tracking_error(cart.pose, Pose(*pose)), cart)._replace(horizon=coming)


def asked(observation, **gains):
    return regulated_pure_pursuit.step(NoState(), observation, GAINS._replace(**gains), 0.01)[1]


UP = 0.5 * math.pi
# the cart and its next two ticks, around a corner
BEND = [Reference(Pose(x, y, heading), BodyVelocity(0.2, 0.0))
        for x, y, heading in ((1.0, 0.0, UP), (1.0, 0.3, UP), (0.6, 0.3, math.pi))]
LINE = [on_the_line(0.2, 0.1 * n) for n in range(3)]


@pytest.mark.parametrize(('pose', 'path', 'lookahead', 'point'), [
    # between two ticks the share of the way is that of the distance
    ((1.0, 0.0, UP), BEND, 0.2, (1.0, 0.2)), ((1.0, 0.0, UP), BEND, 0.4, (0.8, 0.3)),
    # beyond the horizon straight on, and round a circle to its far side at most
    ((1.0, 0.0, UP), BEND, math.hypot(0.3, 1.0), (0.0, 0.3)), ((0.0, -0.3, 0.5), LINE, 0.5, (0.4, 0.0)),
    ((0.0, 0.0, 0.0), [Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.2, 4.0))], 0.3, (0.0, 0.1)),
    # the cart, where all is farther away, and not while its path comes nearer
    ((1.0, -2.0, 0.2), BEND, 0.3, (1.0, 0.0)), ((0.5, 0.0, 0.2), LINE, 0.3, (0.8, 0.0)),
])
def test_the_lookahead_point_is_the_first_one_at_its_distance(pose, path, lookahead, point):
    ahead, left = lookahead_point(seen(pose, path[0], tuple(path[1:])), lookahead)
    found = complex(*pose[:2]) + complex(ahead, left) * cmath.exp(1j * pose[2])
    assert (found.real, found.imag) == pytest.approx(point, abs=1e-12)


def test_on_a_line_a_small_error_decays_at_1_by_the_lookahead_time_at_every_speed():
    """It obeys s² + 2 s / l_t + 2 / l_t² = 0, whose damping is 1 / √2."""
    times = np.linspace(0.0, 6.0, 31)
    for v in (0.2, 1.0):
        poses = driven(regulated_pure_pursuit, GAINS, lambda t, v=v: on_the_line(v, t), (0.0, -1e-5, 0.0), times)
        rate = times / GAINS.lookahead_time
        expected = np.exp(-rate) * (np.cos(rate) + np.sin(rate))
        assert [-1e5 * pose.y for pose in poses] == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(('v', 'omega'), [(0.5, 0.25), (0.5, -0.25), (-0.5, 0.25)])
@pytest.mark.parametrize('count', [0, 20])
def test_on_a_circle_the_arc_is_the_circle_whatever_the_horizon_shows(v, omega, count):
    def cart_at(t):
        return Reference(Pose(v / omega * math.sin(omega * t), v / omega * (1.0 - math.cos(omega * t)), omega * t),
                         BodyVelocity(v, omega))

    coming = tuple(cart_at(0.05 * (n + 1)) for n in range(count))
    command = asked(seen((0.0, 0.0, 0.0), cart_at(0.0), coming))
    # between two ticks the path is a chord
    assert command == pytest.approx((v, omega), rel=1e-3 if count else 1e-12)


# a point of the line 0.3 ahead and 0.4 aside has an arc of 0.5² / 0.8 = 0.3125 m
@pytest.mark.parametrize(('radius', 'speed'), [(0.3, 0.2), (0.625, 0.1)])
def test_an_arc_below_the_radius_is_driven_slower_in_proportion(radius, speed):
    command = asked(seen((0.0, -0.4, 0.0), on_the_line(0.2, 0.0)), radius=radius, lookahead_time=2.5)
    assert command == pytest.approx((speed, speed / 0.3125), rel=1e-12)


def test_a_gap_ahead_along_the_path_adds_to_the_speed_and_stays_without_its_gain():
    for kx in (0.0, 0.5):
        poses = driven(regulated_pure_pursuit, GAINS._replace(kx=kx), lambda t: on_the_line(0.4, t), (-0.3, 0.0, 0.0),
                       times := np.linspace(0.0, 3.0, 16))
        ahead = [0.4 * t - pose.x for t, pose in zip(times, poses, strict=True)]
        assert ahead == pytest.approx(0.3 * np.exp(-kx * times), abs=1e-8)


def test_it_does_so_whichever_way_the_robot_faces():
    assert asked(seen((-0.3, 0.0, 0.5), on_the_line(0.4, 0.0)), kx=0.5).linear == pytest.approx(0.55, rel=1e-12)


def test_a_point_behind_is_turned_to_as_if_it_were_beside_the_robot():
    command = asked(seen((0.0, -0.3, math.pi), on_the_line(0.2, 0.0)), lookahead_time=2.5)
    assert command == pytest.approx((0.2, -0.2 * 2.0 / 0.5), rel=1e-12)
    assert asked(seen((0.0, -0.3, math.pi), on_the_line(0.0, 0.0))) == (0.0, 0.0)
