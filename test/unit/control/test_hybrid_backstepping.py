"""The hybrid law: Eq. (30)-(33), with deviations 4 and 5."""

import math

import numpy as np
import pytest
from each import each_row
from observation import observed
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from mobile_robot_control.control import backstepping, hybrid_backstepping
from mobile_robot_control.control.backstepping import BacksteppingGains
from mobile_robot_control.control.hybrid_backstepping import (
    HybridState,
    SeekingGains,
    fade_step,
)
from mobile_robot_control.control.law import NoState
from mobile_robot_control.parameters.checking import ParameterError, build
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError

BACKSTEPPING = BacksteppingGains(p=1.5, q=0.5, alpha=1.0, f=2.0, g=3.0)
SEEKING = SeekingGains(b0=0.25, b1=1.25, seek_acceleration=0.5, seek_speed=1.0)
GAINS = (BACKSTEPPING, SEEKING)
REFERENCE = Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.6, -0.2))
DT = 0.1
LEFT = TrackingError(1.0, 0.5, 0.3)


def step(state, error, gains=GAINS, dt=DT):
    return hybrid_backstepping.step(state, observed(error, REFERENCE), gains, dt)


def towards(bearing, distance=1.0):
    return TrackingError(distance * math.cos(bearing), distance * math.sin(bearing), 0.3)


def test_a_run_starts_with_zero_fade_in_and_zero_rotation():
    # deviation 4: alpha(0) = alpha'(0) = 0; deviation 5: omega_s(0) = 0
    assert HybridState() == (0.0, 0.0, 0.0, 0.0, 0.0)
    assert step(HybridState(), LEFT)[1] == (0.0, 0.0)


def test_equation_30_before_the_cart_is_seen_the_robot_only_turns():
    state = HybridState(seek=0.35, last_bearing=0.5)
    assert step(state, LEFT)[1] == (0.0, 0.35)


def test_equation_30_while_fading_in():
    _, inner = backstepping.step(NoState(), observed(LEFT, REFERENCE), BACKSTEPPING, DT)
    _, command = step(HybridState(seen=1.0, fade=0.25, fade_rate=0.5, seek=-0.4), LEFT)
    # alpha u1 and alpha u2 + (1 - alpha) omega_s
    assert command == pytest.approx((0.25 * inner.linear, 0.25 * inner.angular - 0.75 * 0.4), rel=1e-14)


@each_row('bearing', [0.1, 1.0, 0.5 * math.pi, 3.0, math.pi])
def test_equation_31_turns_towards_the_cart(bearing):
    assert step(HybridState(), towards(bearing))[0].seek == pytest.approx(0.05, rel=1e-14)
    if bearing < math.pi:
        assert step(HybridState(), towards(-bearing))[0].seek == pytest.approx(-0.05, rel=1e-14)


@each_row('lateral', [0.0, -0.0])
def test_deviation_4_straight_behind_counts_as_left(lateral):
    assert step(HybridState(), TrackingError(-1.0, lateral, 0.0))[0].seek == pytest.approx(0.05, rel=1e-14)


@each_row(('direction', 'sign'), [(0.5, 1.0), (-0.5, -1.0)])
def test_deviation_5_the_seeking_rotation_grows_up_to_its_speed(direction, sign):
    state, turns = HybridState(), []
    for _ in range(30):
        state, command = step(state, towards(direction))
        turns.append(command.angular)
    # 0, 0.05, 0.1, ... 1.0, 1.0
    expected = [sign * min(1.0, 0.05 * k) for k in range(30)]
    assert turns == pytest.approx(expected, abs=1e-14)


@each_row(('distance', 'seen'), [(0.999e-6, 1.0), (1.001e-6, 0.0)])
def test_equation_33_latches_within_a_micrometre_of_the_cart(distance, seen):
    assert step(HybridState(last_bearing=2.0), towards(2.0, distance))[0].seen == seen


@each_row(('last', 'now', 'seen'), [
    (0.1, -0.1, 1.0),
    (-0.1, 0.1, 1.0),
    (1.5, -1.5, 1.0),
    (-1.5, 1.5, 1.0),
    (0.1, 0.05, 0.0),
    (-0.1, -0.2, 0.0),
    (0.5 * math.pi, -0.1, 1.0),
    (-0.1, 0.5 * math.pi, 1.0),
    # one of the two samples farther than pi/2 from zero
    (1.6, -0.1, 0.0),
    (0.1, -1.6, 0.0),
    # deviation 4: never behind
    (3.1, -3.1, 0.0),
    (-3.1, 3.1, 0.0),
    (math.pi, -3.1, 0.0),
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
    state = HybridState(seek=0.3, last_bearing=0.1)
    for bearing in (-0.1, 0.2, 2.0, -2.0, math.pi):
        state, _ = step(state, towards(bearing))
        assert state.seek == 0.3


def test_the_fade_in_starts_with_the_latch():
    state = HybridState(seek=0.3, last_bearing=0.2)
    state, _ = step(state, towards(0.1))
    assert (state.fade, state.fade_rate) == (0.0, 0.0)
    state, command = step(state, towards(-0.1))
    assert command == pytest.approx((0.0, 0.35), abs=1e-15)
    # the poles of 0.25 s² + 1.25 s + 1 are -1 and -4
    assert state.fade == pytest.approx(1.0 - (4.0 * math.exp(-0.1) - math.exp(-0.4)) / 3.0, rel=1e-13)


@each_row(('b0', 'b1'), [
    (0.25, 1.25),
    # the double pole, exactly and nearly
    (0.25, 1.0),
    (0.25, 1.0 + 1e-9),
    # poles a million apart
    (1e-6, 1.0),
])
@each_row('start', [(0.3, -0.7, 1.0), (0.8, 0.4, 0.0)])
def test_equation_32_exactly_under_held_z(b0, b1, start):
    fade, rate, z = start

    def equation_32(t, state):
        return [state[1], (z - b1 * state[1] - state[0]) / b0]

    dt = 0.02
    solution = solve_ivp(equation_32, (0.0, dt), [fade, rate], method='Radau', rtol=1e-12, atol=1e-13)
    expected = solution.y[0, -1], solution.y[1, -1]
    gains = SeekingGains(b0=b0, b1=b1)
    assert fade_step(fade, rate, z, gains, dt) == pytest.approx(expected, rel=1e-8, abs=1e-10)


@each_row('excess', [0.0, 1e-15, 1e-13, 1e-12, 1e-9, 1e-4])
def test_equation_32_keeps_its_precision_near_the_double_pole(excess):
    # y' = F y with y = (alpha - 1, alpha'), by the exponential of F
    gains, dt = SeekingGains(b0=0.25, b1=math.sqrt(1.0 + excess)), 0.02
    transition = expm(np.array([[0.0, 1.0], [-1.0 / gains.b0, -gains.b1 / gains.b0]]) * dt)
    fade, rate = transition @ [0.3 - 1.0, -0.7]
    assert fade_step(0.3, -0.7, 1.0, gains, dt) == pytest.approx((1.0 + fade, rate), abs=1e-14)


def test_deviation_4_a_fade_in_that_swings_is_refused():
    with pytest.raises(ParameterError, match=r'b1² must be at least 4 b0: take b0 at most 0\.25 s²'):
        build(SeekingGains, {'b0': 0.2500001, 'b1': 1.0})
    assert build(SeekingGains, {'b0': 0.25, 'b1': 1.0}).b0 == 0.25
