"""The fuzzy law: Eq. (34) and the ten rules of section 3.3, with deviation 6."""

import math

import pytest
from helpers.observation import ask

from mobile_robot_control.control import fuzzy
from mobile_robot_control.control.fuzzy import FuzzyGains, memberships, surface
from mobile_robot_control.parameters.declaration import ParameterError, build

# Z holds alone within 0.4, SP alone in [0.5, 1.9], GP alone from 2.0; every output has its own value
GAINS = FuzzyGains(a=0.5, b=(0.5, 0.4, 1.0, 2.0, 1.9, 2.5), c=(-4.0, -1.0, 0.5, 2.0, 7.0), d=(-3.0, 0.25, 5.0))
FB, B, S, F, FF = GAINS.c
CW, ST, CCW = GAINS.d


@pytest.mark.parametrize(('bearing', 'shares'), [
    (0.0, (1.0, 0.0, 0.0)),
    (0.25, (0.5, 0.0, 0.0)),
    (0.4, (0.2, 0.0, 0.0)),
    (0.45, (0.1, 0.05 / 0.6, 0.0)),
    (0.5, (0.0, 0.1 / 0.6, 0.0)),
    (1.0, (0.0, 1.0, 0.0)),
    (1.5, (0.0, 0.5, 0.0)),
    (1.95, (0.0, 0.05, 0.05 / 0.6)),
    (2.0, (0.0, 0.0, 0.1 / 0.6)),
    (2.5, (0.0, 0.0, 1.0)),
    (math.pi, (0.0, 0.0, 1.0)),
])
def test_deviation_6_shapes_over_the_bearing(bearing, shares):
    left, right = memberships(0.1, bearing, GAINS), memberships(0.1, -bearing, GAINS)
    assert (left.zero, left.small_positive, left.great_positive) == pytest.approx(shares, abs=1e-15)
    assert (right.zero, right.small_negative, right.great_negative) == pytest.approx(shares, abs=1e-15)
    assert left.small_negative == left.great_negative == right.small_positive == right.great_positive == 0.0


@pytest.mark.parametrize(('distance', 'bearing', 'command'), [
    (0.0, -2.8, (B, CW)),
    (0.0, -1.2, (F, CW)),
    (0.0, 0.0, (S, ST)),
    (0.0, 1.2, (F, CCW)),
    (0.0, 2.8, (B, CCW)),
    (0.9, -2.8, (FB, CW)),
    (0.9, -1.2, (FF, CW)),
    (0.9, 0.0, (FF, ST)),
    (0.9, 1.2, (FF, CCW)),
    (0.9, 2.8, (FB, CCW)),
])
def test_each_of_the_ten_rules_where_it_fires_alone(distance, bearing, command):
    assert surface(distance, bearing, GAINS) == pytest.approx(command, rel=1e-15)


@pytest.mark.parametrize(('heading', 'velocity'), [(0.0, (0.0, 0.0)), (2.0, (3.0, -1.0))])
def test_equation_34_the_law_sees_distance_and_bearing_alone(heading, velocity):
    _, command = ask(fuzzy, (0.25 * math.cos(1.5), 0.25 * math.sin(1.5), heading), velocity, GAINS)
    assert command == pytest.approx(surface(0.25, 1.5, GAINS), rel=1e-14)


@pytest.mark.parametrize(('name', 'value', 'remedy'), [
    ('b', [0.5, 1.0, 1.0, 2.0, 1.5, 2.5], 'it must hold that b2 < b3 < b4'),
    ('b', [0.5, 0.1, 2.0, 2.0, 1.5, 2.5], 'it must hold that b2 < b3 < b4'),
    ('b', [0.5, 0.5, 1.0, 2.0, 1.5, 2.5], 'it must hold that b2 < b1'),
    ('b', [0.5, 0.1, 1.0, 2.0, 2.0, 2.5], 'it must hold that b5 < b4'),
    ('b', [0.5, 0.1, 1.0, 2.0, 1.5, 1.5], 'it must hold that b5 < b6'),
    ('c', [-0.4, 0.0, -0.1, 0.3, 0.8], 'write [-0.4, -0.1, 0.0, 0.3, 0.8]'),
    ('d', [3.0, 0.0, -3.0], 'write [-3.0, 0.0, 3.0]'),
])
def test_deviation_6_shapes_that_leave_a_gap_and_outputs_out_of_order_are_refused(name, value, remedy):
    with pytest.raises(ParameterError) as refusal:
        build(FuzzyGains, {name: value})
    assert any(text.startswith(f'fuzzy.{name} = {value}') and text.endswith(remedy)
               for text in refusal.value.violations)
