"""The fuzzy law: Eq. (34) and the ten rules of section 3.3, with deviation 6."""

import math

import pytest
from each import each_row
from observation import observed

from mobile_robot_control.control import fuzzy
from mobile_robot_control.control.fuzzy import surface
from mobile_robot_control.control.law import NoState
from mobile_robot_control.control.membership import FuzzyGains, memberships
from mobile_robot_control.parameters.checking import ParameterError, build
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError

# Z holds alone within 0.4, SP alone in [0.5, 1.9], GP alone from 2.0; every output has its own value
GAINS = FuzzyGains(a=0.5, b=(0.5, 0.4, 1.0, 2.0, 1.9, 2.5), c=(-4.0, -1.0, 0.5, 2.0, 7.0), d=(-3.0, 0.25, 5.0))
FB, B, S, F, FF = GAINS.c
CW, ST, CCW = GAINS.d
NEAR, FAR = 0.0, 0.9
GREAT, SMALL = 2.8, 1.2


@each_row(('bearing', 'zero', 'small', 'great'), [
    (0.0, 1.0, 0.0, 0.0),
    (0.25, 0.5, 0.0, 0.0),
    (0.4, 0.2, 0.0, 0.0),
    (0.45, 0.1, 0.05 / 0.6, 0.0),
    (0.5, 0.0, 0.1 / 0.6, 0.0),
    (1.0, 0.0, 1.0, 0.0),
    (1.5, 0.0, 0.5, 0.0),
    (1.95, 0.0, 0.05, 0.05 / 0.6),
    (2.0, 0.0, 0.0, 0.1 / 0.6),
    (2.2, 0.0, 0.0, 0.5),
    (2.5, 0.0, 0.0, 1.0),
    (math.pi, 0.0, 0.0, 1.0),
])
def test_deviation_6_shapes_over_the_bearing(bearing, zero, small, great):
    left = memberships(0.1, bearing, GAINS)
    right = memberships(0.1, -bearing, GAINS)
    assert (left.zero, left.small_positive, left.great_positive) == pytest.approx((zero, small, great), abs=1e-15)
    assert (left.small_negative, left.great_negative) == (0.0, 0.0)
    assert (right.zero, right.small_negative, right.great_negative) == pytest.approx((zero, small, great), abs=1e-15)
    assert (right.small_positive, right.great_positive) == (0.0, 0.0)


@each_row(('distance', 'bearing', 'linear', 'angular'), [
    (NEAR, -GREAT, B, CW),
    (NEAR, -SMALL, F, CW),
    (NEAR, 0.0, S, ST),
    (NEAR, SMALL, F, CCW),
    (NEAR, GREAT, B, CCW),
    (FAR, -GREAT, FB, CW),
    (FAR, -SMALL, FF, CW),
    (FAR, 0.0, FF, ST),
    (FAR, SMALL, FF, CCW),
    (FAR, GREAT, FB, CCW),
])
def test_each_of_the_ten_rules_where_it_fires_alone(distance, bearing, linear, angular):
    m = memberships(distance, bearing, GAINS)
    assert sum(part > 0.0 for part in m[:2]) == 1
    assert sum(part > 0.0 for part in m[2:]) == 1
    assert surface(distance, bearing, GAINS) == pytest.approx((linear, angular), rel=1e-15)


def test_equation_34_the_law_sees_distance_and_bearing_alone():
    error = TrackingError(0.25 * math.cos(1.5), 0.25 * math.sin(1.5), 0.0)
    expected = surface(0.25, 1.5, GAINS)
    for heading in (0.0, 2.0, -3.0):
        for velocity in ((0.0, 0.0), (3.0, -1.0)):
            reference = Reference(Pose(1.0, 2.0, 3.0), BodyVelocity(*velocity))
            state, command = fuzzy.step(NoState(), observed(error._replace(heading=heading), reference), GAINS, 0.02)
            assert command == pytest.approx(expected, rel=1e-14)
            assert state == NoState()


@each_row(('b', 'order'), [
    ((0.5, 1.0, 1.0, 2.0, 1.5, 2.5), 'b2 < b3 < b4'),
    ((0.5, 0.1, 2.0, 2.0, 1.5, 2.5), 'b2 < b3 < b4'),
    ((0.5, 0.5, 1.0, 2.0, 1.5, 2.5), 'b2 < b1'),
    ((0.3, 0.5, 1.0, 2.0, 1.5, 2.5), 'b2 < b1'),
    ((0.5, 0.1, 1.0, 2.0, 2.0, 2.5), 'b5 < b4'),
    ((0.5, 0.1, 1.0, 2.0, 1.5, 1.5), 'b5 < b6'),
])
def test_deviation_6_shapes_that_leave_a_gap_are_refused(b, order):
    with pytest.raises(ParameterError) as refusal:
        build(FuzzyGains, {'b': b})
    assert any(f'fuzzy.b = {list(b)} rad' in text and text.endswith(f'it must hold that {order}')
               for text in refusal.value.violations)


@each_row(('name', 'values', 'remedy'), [
    ('c', (-0.4, 0.0, -0.1, 0.3, 0.8), 'write [-0.4, -0.1, 0.0, 0.3, 0.8]'),
    ('d', (3.0, 0.0, -3.0), 'write [-3.0, 0.0, 3.0]'),
])
def test_deviation_6_outputs_out_of_order_are_refused(name, values, remedy):
    with pytest.raises(ParameterError) as refusal:
        build(FuzzyGains, {name: values})
    text, = refusal.value.violations
    assert f'fuzzy.{name} = {list(values)}' in text
    assert text.endswith(remedy)


@each_row(('name', 'value'), [
    ('a', 0.0), ('a', -1.0), ('b', (0.6, -0.1, 0.7, 1.6, 0.8, 2.2)), ('b', (0.6, 0.1, 0.7, 1.6, 0.8, 3.2)),
    ('b', (0.6, 0.1, 0.7, 1.6, 0.8)), ('c', (0.0,) * 4), ('d', (0.0,) * 4), ('d', ()),
])
def test_values_out_of_bounds_are_refused(name, value):
    with pytest.raises(ParameterError, match=f'{name} = .* is not allowed'):
        build(FuzzyGains, {name: value})
