"""The curves of section 4 of the chapter, whose sizes, lap times and starts are the contract's (deviation 9)."""

import cmath
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.parameters.declaration import ParameterError, build
from mobile_robot_control.reference.cart import CurveParameters, Placement, accelerated_at, reference_at
from mobile_robot_control.reference.curves import CURVES, Curve, CurvePoint


def rounded_rectangle(s):
    """Walk along sides and corners, one after the other."""
    quarter = 0.1 * math.pi
    sides = [(0.8, 0), (quarter, 1), (0.6, 0), (quarter, 1), (1.6, 0), (quarter, 1), (0.6, 0), (quarter, 1), (0.8, 0)]
    left = s / (2 * math.pi) % 1.0 * sum(length for length, _ in sides)
    at, heading = -0.5j, 1.0 + 0.0j
    for length, turns in sides:
        way = min(left, length)
        turn = cmath.exp(1j * way / 0.2) if turns else 1.0
        at += heading * 0.2 * (turn - 1.0) / 1j if turns else heading * way
        heading, left = heading * turn, left - way
    return at.real, at.imag


# the contract's formulas, of scale 1
FORMULAS = {
    'lemniscate': lambda s: (math.cos(s) / (1 + math.sin(s)**2), math.sin(s) * math.cos(s) / (1 + math.sin(s)**2)),
    'trifolium': lambda s: (math.cos(3 * s / 2) * math.cos(s / 2), math.cos(3 * s / 2) * math.sin(s / 2)),
    'circle': lambda s: (math.cos(s), math.sin(s)),
    'lissajous': lambda s: (math.sin(s), math.sin(2 * s)),
    'line': lambda s: (s / (2 * math.pi), 0.0),
    'sinusoid': lambda s: (s / (2 * math.pi), math.sin(s) / (2 * math.pi)),
    'rounded_rectangle': rounded_rectangle,
}
# the curvature of the rectangle jumps; its derivatives are checked by one-sided differences, as those of any curve
SMOOTH = st.sampled_from(sorted({*CURVES} - {'rounded_rectangle'}))
NAMES, PARAMETERS, TIMES = st.sampled_from(sorted(CURVES)), st.floats(-7.0, 10.0), st.floats(0.0, 20.0)
PLACED = Placement(scale=0.5, period=12.0, phase=0.15, center=(0.3, -0.8), rotation=0.7)

# of central differences of eighth order
FIRST = (4 / 5, -1 / 5, 4 / 105, -1 / 280)


def first_difference(function, at, h=0.02):
    return sum(c * (function(at + n * h) - function(at - n * h)) for n, c in enumerate(FIRST, start=1)) / h


def test_the_curves_are_those_of_the_contract():
    assert {name: curve.closed for name, curve in CURVES.items()} == {
        name: name not in ('line', 'sinusoid') for name in FORMULAS}


@given(NAMES, PARAMETERS)
def test_points_are_those_of_the_contracts_formula(name, s):
    point = CURVES[name](s)
    assert (point.x, point.y) == pytest.approx(FORMULAS[name](s), abs=1e-14)


@pytest.mark.parametrize('name', ['trifolium', 'lemniscate', 'circle'])
def test_deviation_9_closed_curves_start_at_a_heading_up(name):
    reference = reference_at(CURVES[name], 0.0, Placement(scale=2.5))
    assert reference.pose == pytest.approx((2.5, 0.0, 0.5 * math.pi), abs=1e-15)


@pytest.mark.parametrize(('name', 'v_r', 'omega_r'), [
    # s' = 2 pi / 16; trifolium: |dr/ds| = 1/2, turning at 5 s'; lemniscate: 1, 3 s'; circle: 1, s'
    ('trifolium', 0.5, 5.0), ('lemniscate', 1.0, 3.0), ('circle', 1.0, 1.0), ('line', 0.5 / math.pi, 0.0),
])
def test_deviation_9_velocities_at_the_start_by_hand(name, v_r, omega_r):
    rate = 2.0 * math.pi / 16.0
    reference = reference_at(CURVES[name], 0.0, Placement())
    assert reference.velocity == pytest.approx((v_r * rate, omega_r * rate), rel=1e-13)
    # twice the size is twice as fast and turns alike
    large = reference_at(CURVES[name], 0.0, Placement(scale=2.0))
    assert large.velocity == pytest.approx((2.0 * v_r * rate, omega_r * rate), rel=1e-13)


@given(SMOOTH, TIMES, st.sampled_from([Placement(), PLACED]))
def test_v_r_and_omega_r_are_the_derivatives_of_the_pose(name, time, placement):
    def at(t):
        return accelerated_at(CURVES[name], t, placement)

    reference = at(time)
    v, heading = reference.velocity.linear, reference.pose.heading
    assert first_difference(lambda t: at(t).pose.x, time) == pytest.approx(v * math.cos(heading), abs=1e-10)
    assert first_difference(lambda t: at(t).pose.y, time) == pytest.approx(v * math.sin(heading), abs=1e-10)
    # from here on, without a jump
    turned = first_difference(lambda t: wrap_angle(at(t).pose.heading - heading), time, h=0.01)
    assert turned == pytest.approx(reference.velocity.angular, abs=1e-9)


@given(SMOOTH, TIMES, st.sampled_from([Placement(), PLACED]))
def test_the_acceleration_is_the_derivative_of_the_velocity(name, time, placement):
    def at(t):
        return accelerated_at(CURVES[name], t, placement)

    reference = at(time)
    assert first_difference(lambda t: at(t).velocity.linear, time, h=0.01) == pytest.approx(
        reference.acceleration.linear, abs=1e-9)
    assert first_difference(lambda t: at(t).velocity.angular, time, h=0.01) == pytest.approx(
        reference.acceleration.angular, abs=1e-6)


@given(NAMES, TIMES)
def test_placement_by_the_contract(name, time):
    pose = reference_at(CURVES[name], time, PLACED).pose
    x, y = FORMULAS[name](2.0 * math.pi * (time / 12.0 + 0.15))
    cos, sin = math.cos(0.7), math.sin(0.7)
    assert pose.x == pytest.approx(0.3 + 0.5 * (cos * x - sin * y), abs=1e-14)
    assert pose.y == pytest.approx(-0.8 + 0.5 * (sin * x + cos * y), abs=1e-14)


@pytest.mark.parametrize(('values', 'text'), [
    ({'curve': 'trifolum'}, "did you mean 'trifolium'"),
    ({'scale': 0.0}, 'scale = 0.0 is not allowed; it must be above 0.0 m'),
    ({'period': -1.0}, 'period = -1.0 is not allowed; it must be above 0.0 s'),
    ({'center': [1.0]}, '2 elements'),
    ({'scale': 1e12, 'center': [1e12, 0.0]}, 'center = [1000000000000.0, 0.0] m take the cart to 2e+12 m'),
    ({'scale': 1e9, 'period': 1e-3}, 'scale = 1000000000.0 m and period = 0.001 s ask for a velocity'),
    ({'period': 1e-12}, 'raise the period'),
])
def test_invalid_curve_parameters_are_refused(values, text):
    with pytest.raises(ParameterError) as refusal:
        build(CurveParameters, values)
    assert text in str(refusal.value)


@pytest.mark.parametrize('curve', CURVES)
def test_the_largest_accepted_curves_give_references_within_1e12(curve):
    for scale, period in ((0.99e12, 1e3), (1.0, 1e-10), (1e5, 1e-5)):
        taken = build(CurveParameters, {'curve': curve, 'scale': scale, 'period': period})
        for n in range(1000):
            pose, velocity, _ = reference_at(CURVES[curve], period * n / 1000, taken.placement)
            assert max(map(abs, (*pose, *velocity))) <= 1e12


def cycloid(at):
    """Return a curve whose speed vanishes at s = at."""
    def curve(s):
        s -= at
        return CurvePoint(s - math.sin(s), 1.0 - math.cos(s), 1.0 - math.cos(s), math.sin(s), math.sin(s), math.cos(s))

    return curve


@pytest.mark.parametrize(('curve', 'phase', 'place'), [
    (cycloid(0.0), 0.0, 't = 0 s, at (0, 0)'), (cycloid(1.25 * math.pi), 0.0, 't = 10 s, at ('),
    (cycloid(1.25 * math.pi), 0.5, 't = 2 s, at ('),
    (lambda _: CurvePoint(1.0, 2.0, 0.0, 0.0, 0.0, 0.0), 0.0, 'at (1, 2) times the scale'),
])
def test_a_standing_cart_is_refused_with_the_place(registered, curve, phase, place):
    registered(Curve('standing', curve))
    with pytest.raises(ParameterError) as refused:
        build(CurveParameters, {'curve': 'standing', 'phase': phase})
    violation, = refused.value.violations
    for words in ("curve = 'standing' stands still", place, 'speed never vanishes'):
        assert words in violation
