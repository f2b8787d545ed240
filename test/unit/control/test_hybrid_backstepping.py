"""The hybrid law: Eq. (30)-(33), with deviations 4, 5 and 10."""

import math

import numpy as np
import pytest
from helpers.observation import ask
from scipy.linalg import expm

from mobile_robot_control.control import backstepping, hybrid_backstepping
from mobile_robot_control.control.backstepping import BacksteppingGains
from mobile_robot_control.control.hybrid_backstepping import HybridState, SeekingGains, fade_step
from mobile_robot_control.parameters.declaration import ParameterError, build

BACKSTEPPING = BacksteppingGains(p=1.5, q=0.5, alpha=1.0, f=2.0, g=3.0)
SEEKING = SeekingGains(b0=0.25, b1=1.25, seek_acceleration=0.5, seek_speed=1.0)
CART = (0.6, -0.2)
LEFT = (1.0, 0.5, 0.3)


def step(state, error):
    return ask(hybrid_backstepping, error, CART, (BACKSTEPPING, SEEKING), 0.1, state)


def towards(bearing, distance=1.0):
    return distance * math.cos(bearing), distance * math.sin(bearing), 0.3


def test_equation_30_before_the_cart_is_seen_the_robot_only_turns():
    # deviation 4: alpha(0) = alpha'(0) = 0; deviation 5: omega_s(0) = 0
    assert HybridState() == (0.0, 0.0, 0.0, 0.0, 0.0)
    assert step(HybridState(seek=0.35, last_bearing=0.5), LEFT)[1] == (0.0, 0.35)


def test_equation_30_while_fading_in():
    _, inner = ask(backstepping, LEFT, CART, BACKSTEPPING)
    _, command = step(HybridState(seen=1.0, fade=0.25, fade_rate=0.5, seek=-0.4), LEFT)
    # alpha u1 and alpha u2 + (1 - alpha) omega_s
    assert command == pytest.approx((0.25 * inner.linear, 0.25 * inner.angular - 0.75 * 0.4), rel=1e-14)


@pytest.mark.parametrize('bearing', [0.1, 0.5 * math.pi, 3.0])
def test_equation_31_turns_towards_the_cart(bearing):
    for side in (1.0, -1.0):
        assert step(HybridState(), towards(side * bearing))[0].seek == pytest.approx(side * 0.05, rel=1e-14)


@pytest.mark.parametrize('lateral', [0.0, -0.0])
def test_deviation_4_straight_behind_counts_as_left(lateral):
    assert step(HybridState(), (-1.0, lateral, 0.0))[0].seek == pytest.approx(0.05, rel=1e-14)


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_deviation_5_the_seeking_rotation_grows_up_to_its_speed(sign):
    state, turns = HybridState(), []
    for _ in range(30):
        state, command = step(state, towards(0.5 * sign))
        turns.append(command.angular)
    # 0, 0.05, 0.1, ... 1.0, 1.0
    assert turns == pytest.approx([sign * min(1.0, 0.05 * k) for k in range(30)], abs=1e-14)


@pytest.mark.parametrize(('distance', 'seen'), [(0.999e-6, 1.0), (1.001e-6, 0.0)])
def test_equation_33_latches_within_a_micrometre_of_the_cart(distance, seen):
    assert step(HybridState(last_bearing=2.0), towards(2.0, distance))[0].seen == seen


@pytest.mark.parametrize(('last', 'now', 'seen'), [
    (1.5, -1.5, 1.0),
    (-0.1, 0.1, 1.0),
    (0.1, 0.05, 0.0),
    (-0.1, -0.2, 0.0),
    (0.5 * math.pi, -0.1, 1.0),
    (-0.1, 0.5 * math.pi, 1.0),
    # one of the two samples farther than pi/2 from zero
    (1.6, -0.1, 0.0),
    (0.1, -1.6, 0.0),
    # deviation 4: never behind
    (3.1, -3.1, 0.0),
    (-3.1, math.pi, 0.0),
    # the first sample of a run has none before it
    (0.0, 0.3, 0.0),
    (0.0, -0.3, 0.0),
])
def test_equation_33_latches_when_the_bearing_crosses_zero(last, now, seen):
    state, _ = step(HybridState(seek=0.1, last_bearing=last), towards(now))
    assert state.seen == seen
    assert state.last_bearing == pytest.approx(now, abs=1e-15)


def test_deviation_4_the_seeking_rotation_is_frozen_once_the_cart_is_seen():
    state, _ = step(HybridState(seek=0.3, last_bearing=0.2), towards(0.1))
    assert (state.fade, state.fade_rate) == (0.0, 0.0)
    state, command = step(state, towards(-0.1))
    assert command == pytest.approx((0.0, 0.35), abs=1e-15)
    # the fade-in starts at once: the poles of 0.25 s² + 1.25 s + 1 are -1 and -4
    assert state.fade == pytest.approx(1.0 - (4.0 * math.exp(-0.1) - math.exp(-0.4)) / 3.0, rel=1e-13)
    for bearing in (0.2, 2.0, -2.0, math.pi):
        state, _ = step(state, towards(bearing))
        assert state.seek == 0.35


# poles a million apart, apart, and at the double pole and beside it
@pytest.mark.parametrize(('b0', 'b1'), [(1e-6, 1.0), (0.25, 1.25), *((0.25, math.sqrt(1.0 + excess)) for excess in (
    0.0, 1e-15, 1e-13, 1e-12, 1e-9, 1e-4))])
@pytest.mark.parametrize('start', [(0.3, -0.7, 1.0), (0.8, 0.4, 0.0)])
def test_equation_32_exactly_under_held_z(b0, b1, start):
    # y' = F y with y = (alpha - z, alpha'), by the exponential of F
    (fade, rate, z), dt = start, 0.02
    change, slope = expm(np.array([[0.0, 1.0], [-1.0 / b0, -b1 / b0]]) * dt) @ [fade - z, rate]
    assert fade_step(fade, rate, z, SeekingGains(b0=b0, b1=b1), dt) == pytest.approx(
        (z + change, slope), rel=1e-10, abs=1e-14)


def test_deviation_4_a_fade_in_that_swings_is_refused():
    with pytest.raises(ParameterError, match=r'b1² must be at least 4 b0: take b0 at most 0\.25 s²'):
        build(SeekingGains, {'b0': 0.2500001, 'b1': 1.0})
    assert build(SeekingGains, {'b0': 0.25, 'b1': 1.0}).b0 == 0.25
