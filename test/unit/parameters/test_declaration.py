"""Parameters declared as fields, built from values, and refused by name."""

import math
from collections.abc import Iterator
from typing import Annotated, NamedTuple

import pytest

from mobile_robot_control.parameters.declaration import (
    INLINE,
    Field,
    ParameterError,
    build,
    declarations,
    describe_bounds,
    flatten,
    rule,
)


class Wheel(NamedTuple):
    radius: Annotated[float, Field('m', 'of the wheel', above=0.0)] = 0.035
    slip: Annotated[float, Field('', 'a fraction', minimum=0.0, maximum=1.0)] = 0.0


class Frame(NamedTuple):
    width: Annotated[float, Field('m', 'of the frame', minimum=0.1)] = 0.4
    holes: Annotated[int, Field('', 'how many')] = 4


class Cart(NamedTuple):
    wheel: Wheel = Wheel()
    frame: Annotated[Frame, INLINE] = Frame()
    colour: Annotated[str, Field('', 'of the paint', choices=('red', 'green', 'blue'), live=True)] = 'red'
    name: Annotated[str, Field('', 'any text')] = 'cart'
    braked: Annotated[bool, Field('', 'whether the brake is on')] = False
    pose: Annotated[tuple[float, ...], Field('m, m, rad', 'x, y, yaw', length=3)] = (0.0, 0.0, 0.0)
    gaps: Annotated[tuple[float, ...], Field('m', 'any number of them', above=0.0, maximum=2.0)] = (1.0,)


@rule
def _wheels_fit(cart: Cart) -> Iterator[str]:
    if cart.wheel.radius > cart.frame.width:
        yield f'wheel.radius = {cart.wheel.radius} m exceeds width = {cart.frame.width} m'
    if cart.braked and cart.frame.holes > 8:
        yield f'holes = {cart.frame.holes} leave no room for the brake'


def refused(values, group=Cart):
    with pytest.raises(ParameterError) as refusal:
        build(group, values)
    return refusal.value.violations


def only(values):
    violation, = refused(values)
    return violation


def test_declarations_have_dotted_names_in_order_maybe_a_prefix_and_other_defaults():
    assert list(declarations(Cart)) == [
        'wheel.radius', 'wheel.slip', 'width', 'holes', 'colour', 'name', 'braked', 'pose', 'gaps']
    declared = declarations(Cart)['wheel.radius']
    assert (declared.name, declared.kind, declared.default, declared.field.unit) == ('wheel.radius', float, 0.035, 'm')
    assert declarations(Cart)['pose'].kind is tuple
    found = declarations(Cart, 'my.', Cart(wheel=Wheel(radius=0.5)))
    assert (found['my.wheel.radius'].default, found['my.width'].default) == (0.5, 0.4)


def test_given_values_are_set_and_the_rest_keeps_its_default():
    cart = build(Cart, {'wheel.slip': 0.25, 'width': 0.6, 'holes': 2, 'colour': 'blue', 'braked': True,
                        'pose': [1.0, 2.0, 3.0], 'gaps': (0.5, 2.0), 'name': 'b'})
    assert cart == Cart(Wheel(0.035, 0.25), Frame(0.6, 2), 'blue', 'b', True, (1.0, 2.0, 3.0), (0.5, 2.0))


@pytest.mark.parametrize(('name', 'value', 'expected'), [
    ('wheel.radius', 1, 1.0), ('pose', [1, 2, 3], (1.0, 2.0, 3.0)), ('pose', (0, 0.5, 1), (0.0, 0.5, 1.0)),
])
def test_a_whole_number_is_accepted_as_a_float(name, value, expected):
    found = flatten(build(Cart, {name: value, 'width': 2.0}))[name]
    assert found == expected
    assert all(type(part) is float for part in (found if isinstance(found, tuple) else (found,)))


@pytest.mark.parametrize(('name', 'values', 'wanted'), [
    ('wheel.radius', ('wide', '0.1', True, None, [0.1]), 'write a number [m], such as 0.035'),
    ('wheel.slip', (False,), 'write a number, such as 0.0'), ('holes', (4.0, True), 'write a whole number, such as 4'),
    ('colour', (7,), 'write a text, such as red'), ('name', (None,), 'write a text, such as cart'),
    ('braked', (1, 'true'), 'write true or false, such as false'),
    ('pose', (1.0, '123', b'123', [1.0, True, 0.0], [1.0, 'a', 0.0], [1.0, None, 0.0]),
     'write an array of numbers [m, m, rad], such as [0.0, 0.0, 0.0]'),
])
def test_a_value_of_the_wrong_type_is_refused(name, values, wanted):
    for value in values:
        assert only({name: value}) == f'{name} = {value!r} is of type {type(value).__name__}; {wanted}'


@pytest.mark.parametrize(('name', 'values', 'reason'), [
    ('wheel.radius', (math.nan, math.inf, -math.inf), 'is not finite; it must be a finite number, above 0.0 m'),
    ('wheel.radius', (1e13, -1e308, 10**13), 'is beyond 1e+12; write a smaller number, above 0.0 m'),
    ('wheel.radius', (9e-13, 5e-324), 'is below 1e-12; write a larger number, above 0.0 m'),
    ('pose', ([0.5, math.nan, 0.5],), 'is not finite; it must be a finite number, 3 elements'),
    ('pose', ([0.0, 0.0, 2.2e-311],), 'is too small for parameter files of ROS; write 0.0, 3 elements'),
])
def test_numbers_that_are_not_finite_too_large_or_too_close_to_zero_are_refused(name, values, reason):
    for value in values:
        assert only({name: value}) == f'{name} = {value!r} {reason}'


@pytest.mark.parametrize(('name', 'bad', 'good', 'allowed'), [
    ('wheel.radius', 0.0, 1e-12, 'above 0.0 m'),
    ('wheel.radius', -1.0, 0.1, 'above 0.0 m'),
    ('width', 0.0999, 0.1, 'at least 0.1 m'),
    ('wheel.slip', -1e-9, 0.0, 'at least 0.0, at most 1.0'),
    ('wheel.slip', 1.0000001, 1.0, 'at least 0.0, at most 1.0'),
    ('gaps', [1.0, 0.0], [1.0, 1e-9], 'above 0.0 m, at most 2.0 m'),
    ('gaps', [2.1, 1.0], [2.0, 1.0], 'above 0.0 m, at most 2.0 m'),
    ('pose', [1.0, 2.0], [1.0, 2.0, 3.0], '3 elements'),
    ('pose', [1.0] * 4, [1.0] * 3, '3 elements'),
    ('pose', [], [0.0] * 3, '3 elements'),
])
def test_a_value_out_of_bounds_is_refused_with_the_rule(name, bad, good, allowed):
    assert only({name: bad}) == f'{name} = {bad!r} is not allowed; it must be {allowed}'
    build(Cart, {name: good})


@pytest.mark.parametrize(('name', 'value', 'text'), [
    ('colour', 'gren', "colour = 'gren' is not allowed; it must be one of red, green, blue; did you mean 'green'?"),
    ('name', '', "name = '' is empty; write a text such as 'cart'"),
    ('wheel.radios', 0.1, "unknown parameter 'wheel.radios'; did you mean 'wheel.radius'?"),
    ('zzz', 0.1, "unknown parameter 'zzz'; known are braked, colour, gaps, holes, name, pose, wheel.radius, "
     'wheel.slip, width'),
])
def test_an_unknown_choice_or_name_is_refused_with_the_nearest(name, value, text):
    assert only({name: value}) == text


def test_every_violation_is_named_at_once():
    violations = refused(
        {'wheel.radios': 1.0, 'wheel.radius': -1.0, 'holes': 'many', 'name': '', 'pose': [math.nan] * 3})
    assert len(violations) == 5
    for start in ("unknown parameter 'wheel.radios'", 'wheel.radius = -1.0 is not allowed', "holes = 'many' is of type",
                  "name = '' is empty", 'pose = [nan, nan, nan] is not finite'):
        assert sum(violation.startswith(start) for violation in violations) == 1


def test_rules_between_parameters_are_all_checked_once_the_values_are_sound():
    broken = {'wheel.radius': 0.5, 'braked': True, 'holes': 9}
    assert refused(broken) == ('wheel.radius = 0.5 m exceeds width = 0.4 m', 'holes = 9 leave no room for the brake')
    # rules are not checked on values that are themselves invalid
    assert refused({**broken, 'width': -1.0}) == ('width = -1.0 is not allowed; it must be at least 0.1 m',)

    class Train(NamedTuple):
        first: Cart = Cart()
        last: Cart = Cart()

    assert refused({'last.wheel.radius': 0.5}, Train) == ('wheel.radius = 0.5 m exceeds width = 0.4 m',)


@pytest.mark.parametrize(('field', 'text'), [
    (Field('', 'anything'), ''),
    (Field('kg', 'x', above=0.0), 'above 0.0 kg'),
    (Field('', 'x', minimum=1.0, maximum=5.0), 'at least 1.0, at most 5.0'),
    (Field('rad', 'x', minimum=0.0, length=6), 'at least 0.0 rad, 6 elements'),
    (Field('', 'x', choices=('a', 'b')), 'one of a, b'),
])
def test_bounds_are_described_in_words(field, text):
    assert describe_bounds(field) == text
