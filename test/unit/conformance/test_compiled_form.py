"""Compiled and plain form: differences in last bits are warned of by line, larger ones and built-in laws fail."""

import math
import warnings

import pytest
from broken_laws import Gains

from mobile_robot_control import BodyVelocity, Law
from mobile_robot_control.conformance.checks import ConformanceWarning, LeftOutError, holding
from mobile_robot_control.conformance.compiled_form import compiled_equals_plain
from mobile_robot_control.control.laws import BUILT_IN, LAWS

pytest.importorskip('numba')


def products_step(state, observation, gains, dt):
    e1, e2, e3 = observation.error
    return state, BodyVelocity(gains.k * e1 * e1 * e1 + math.cos(e3) % 2.0, math.atan2(e2, e1) + math.tanh(e2))


def cube_step(state, observation, gains, dt):
    e1, _, e3 = observation.error
    v = gains.k * e1**3
    return state, BodyVelocity(v, math.cos(e3))


def length_step(state, observation, gains, dt):
    e1, e2, _ = observation.error
    return state, BodyVelocity(
        gains.k * math.hypot(e1, e2),
        0.0)


def remainder_step(state, observation, gains, dt):
    return state, BodyVelocity(math.fmod(observation.error.longitudinal, 2.0), 0.0)


def guarded_step(state, observation, gains, dt):
    try:
        v = gains.k / observation.error.longitudinal
    except Exception:
        v = 0.0
    return state, BodyVelocity(min(v, 5.0), 0.0)


def compared(step):
    """Return what a check yields and warns of."""
    law = Law('compared', step, Gains)
    with holding(LAWS, law), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter('always')
        found = list(compiled_equals_plain(law))
    caught = [warning for warning in caught if warning.category is ConformanceWarning]
    return found, [f'{warning.filename}:{warning.lineno}: {warning.message}' for warning in caught]


def line_of(step, offset):
    return f'{__file__}:{step.__code__.co_firstlineno + offset}'


def test_products_and_safe_functions_are_equal_to_the_last_bit():
    assert compared(products_step) == ([], [])


@pytest.mark.parametrize(('step', 'offset', 'expression'), [
    (cube_step, 2, 'e1 ** 3 (write products'), (length_step, 3, 'math.hypot(e1, e2) (write math.sqrt(x * x + y * y)'),
])
def test_a_difference_in_last_bits_is_a_warning_that_names_the_line(step, offset, expression):
    found, (warning,) = compared(step)
    assert not found
    assert warning.startswith(f"{line_of(step, offset)}: the law 'compared' returns (")
    assert f'{line_of(step, offset)}: {expression}' in warning
    assert 'equal within 1e-12 only, at e1 = ' in warning


def test_a_law_of_the_package_may_not_differ_in_last_bits(monkeypatch):
    law = Law('compared', cube_step, Gains)
    monkeypatch.setattr('mobile_robot_control.conformance.compiled_form.BUILT_IN', (*BUILT_IN, law))
    with holding(LAWS, law):
        assert f'{line_of(cube_step, 2)}: e1 ** 3' in next(compiled_equals_plain(law))


def test_a_law_that_does_not_compile_is_left_out_with_a_warning():
    law = Law('compared', remainder_step, Gains)
    with holding(LAWS, law), pytest.warns(ConformanceWarning) as warned, pytest.raises(LeftOutError, match='fmod'):
        list(compiled_equals_plain(law))
    file, _, line = line_of(remainder_step, 1).rpartition(':')
    assert f"Unknown attribute 'fmod' of type Module(<module 'math'>), at {file}, line {line}" in str(warned[0].message)


def test_a_larger_difference_fails_with_its_input():
    found, _ = compared(guarded_step)
    # Python raises ZeroDivisionError, compiled code divides as C does
    assert 'BodyVelocity(linear=0.0, angular=0.0)) plain and' in found[0]
    assert 'BodyVelocity(linear=5.0, angular=0.0)) compiled, at e1 = 0.0 m' in found[0]
