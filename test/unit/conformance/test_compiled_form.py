"""Compiled and plain form: differences in last bits are warned of by line, larger ones and built-in laws fail."""

import cmath
import ctypes
import inspect
import itertools
import math
import re
import warnings
from functools import partial
from pathlib import Path
from random import Random

import numpy as np
import pytest
import scipy.special
from helpers import broken_laws
from helpers.outside_laws import OF_THE_LIBRARY, OUTSIDE, of_the_library

from mobile_robot_control import BodyVelocity, Law
from mobile_robot_control.conformance.checks import ConformanceWarning, LeftOutError, holding
from mobile_robot_control.conformance.compiled_form import (
    DIFFERENT,
    UNCOMPILED,
    _elsewhere,
    _is_foreign,
    compiled_equals_plain,
    same_bits_elsewhere,
    suspects,
)
from mobile_robot_control.conformance.sampling import bits_of
from mobile_robot_control.control.laws import BUILT_IN, LAWS

PAGE = (Path(__file__).parents[3] / 'docs' / 'extending.md').read_text(encoding='utf-8')


def products_step(state, observation, gains, dt):
    e1, e2, e3 = observation.error
    return state, BodyVelocity(gains.k * e1 * e1 * e1 + math.cos(e3) % 2.0, math.atan2(e2, e1) + math.tanh(e2))


def cube_step(state, observation, gains, dt):
    e1, _, e3 = observation.error
    return state, BodyVelocity(gains.k * e1**3, math.cos(e3))


def length_step(state, observation, gains, dt):
    e1, e2, _ = observation.error
    return state, BodyVelocity(
        gains.k * math.hypot(e1, e2), 0.0)


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
    law = Law('compared', step, broken_laws.Gains)
    with holding(LAWS, law), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter('always')
        found = list(compiled_equals_plain(law))
    caught = [warning for warning in caught if warning.category is ConformanceWarning]
    return found, [f'{warning.filename}:{warning.lineno}: {warning.message}' for warning in caught]


def line_of(step, offset):
    return f'{__file__}:{step.__code__.co_firstlineno + offset}'


def test_products_and_safe_functions_are_equal_to_the_last_bit():
    pytest.importorskip('numba')
    assert compared(products_step) == ([], [])


@pytest.mark.parametrize(('step', 'offset', 'expression'), [
    (cube_step, 2, 'e1 ** 3 (write products'), (length_step, 3, 'math.hypot(e1, e2) (write math.sqrt(x * x + y * y)'),
])
def test_a_difference_in_last_bits_warns_with_its_line_and_fails_a_law_of_the_package(
        step, offset, expression, monkeypatch):
    pytest.importorskip('numba')
    found, (warning,) = compared(step)
    assert not found
    assert warning.startswith(f"{line_of(step, offset)}: the law 'compared' returns (")
    assert f'{line_of(step, offset)}: {expression}' in warning
    assert 'equal within 1e-12 only, at e1 = ' in warning
    law = Law('compared', step, broken_laws.Gains)
    monkeypatch.setattr('mobile_robot_control.conformance.compiled_form.BUILT_IN', (*BUILT_IN, law))
    with holding(LAWS, law):
        assert f'{line_of(step, offset)}: {expression}' in next(compiled_equals_plain(law))


def test_a_law_that_does_not_compile_is_left_out_with_a_warning():
    pytest.importorskip('numba')
    law = Law('compared', remainder_step, broken_laws.Gains)
    with holding(LAWS, law), pytest.warns(ConformanceWarning) as warned, pytest.raises(LeftOutError, match='fmod'):
        list(compiled_equals_plain(law))
    file, _, line = line_of(remainder_step, 1).rpartition(':')
    assert f"Unknown attribute 'fmod' of type Module(<module 'math'>), at {file}, line {line}" in str(warned[0].message)


def test_a_larger_difference_fails_with_its_input():
    pytest.importorskip('numba')
    found, _ = compared(guarded_step)
    # Python raises ZeroDivisionError, compiled code divides as C does
    assert 'BodyVelocity(linear=0.0, angular=0.0)) plain and' in found[0]
    assert 'BodyVelocity(linear=5.0, angular=0.0)) compiled, at e1 = 0.0 m' in found[0]


def _fourth_power(x):
    x **= 4
    return x


def calling_step(state, observation, gains, dt):
    """The word pow( in a text is no call."""
    return state, (_fourth_power(math.cos(dt)), math.log(dt, 2.0), broken_laws.command(observation))


def test_powers_and_calls_are_named_with_their_lines():
    found = suspects(calling_step)
    first, power = calling_step.__code__.co_firstlineno, _fourth_power.__code__.co_firstlineno
    assert [(one.line, one.expression) for one in found] == [(first + 2, 'math.log(dt, 2.0)'), (power + 1, 'x **= 4')]
    assert {one.file for one in found} == {__file__}


def test_what_a_step_is_bound_to_is_looked_into():
    power = _fourth_power
    assert [one.expression for one in suspects(lambda state, observation, gains, dt: (state, power(dt)))] == ['x **= 4']


@pytest.mark.parametrize('step', [broken_laws.sound_step, len, partial(math.fmod, 2.0)])
def test_safe_steps_and_those_without_a_source_have_none(step):
    assert suspects(step) == []


def basic(x, y):
    part = max(-1.0, min(1.0, x))
    return (
        x + y, x - y, x * y, x / y, x % y, x // y, x * x * x, abs(x), round(x), round(x, 2), int(x), sum((x, y)),
        math.sqrt(abs(x)), math.sqrt(x * x + y * y), math.sin(x), math.cos(x), math.tan(x), math.asin(part),
        math.acos(part), math.atan(x), math.atan2(y, x), math.fabs(x), math.floor(x), math.ceil(x), math.trunc(x),
        math.copysign(x, y), math.degrees(x), math.radians(x), math.isfinite(x), math.isnan(x), math.isinf(x),
    )


def transcendental(x, y):
    size = abs(x) + 1e-9
    return (
        math.sinh(x), math.cosh(x), math.tanh(x), math.asinh(x), math.acosh(size + 1.0), math.atanh(math.sin(x)),
        math.exp(x), 2.0 / (1.0 + math.exp(-x)), math.expm1(x), math.log(size), math.log1p(size), math.log2(size),
        math.log10(size), math.erf(x), math.erfc(x), size**y, pow(size, y), math.pow(size, y),
    )


@pytest.mark.parametrize('expressions', [basic, transcendental])
def test_safe_expressions_are_compiled_to_the_last_bit(expressions):
    numba = pytest.importorskip('numba')
    compiled = numba.njit(error_model='numpy')(expressions)
    draws = Random(3)  # noqa: S311 (no secret)
    for _ in range(3000):
        x, y = draws.uniform(-6.0, 6.0), draws.choice((-1.0, 1.0)) * draws.uniform(1e-6, 6.0)
        x = draws.choice((x, 1e-3 * x, math.pi, -0.0))
        for n, (plain, other) in enumerate(zip(expressions(x, y), compiled(x, y), strict=True)):
            assert bits_of(float(plain)) == bits_of(float(other)), (n, x, y)


def matrix_step(state, observation, gains, dt):
    return state, BodyVelocity(float(np.dot(observation.error, observation.error)), np.sin(dt) + 2.0**-3)


def test_what_depends_on_the_machine_is_warned_of_by_line():
    with pytest.warns(ConformanceWarning, match='the last bits of .* depend on the machine') as caught:
        assert list(same_bits_elsewhere(OF_THE_LIBRARY)) == []
    line = of_the_library.__code__.co_firstlineno + 5
    assert caught[0].lineno == line
    assert f':{line}: math.sin(e3) (write sin of mobile_robot_control.elementary instead)' in str(caught[0].message)
    with pytest.warns(ConformanceWarning, match=r'np\.dot\(.*\) \(write sums in order instead\)') as caught:
        assert list(same_bits_elsewhere(Law('matrix', matrix_step, broken_laws.Gains))) == []
    assert '2.0' not in str(caught[0].message)


LIBRARY = ctypes.CDLL(None)
LIBRARY.fabs.restype, LIBRARY.fabs.argtypes = ctypes.c_double, [ctypes.c_double]
magnitude = LIBRARY.fabs


def foreign_step(state, observation, gains, dt):
    e1, e2, e3 = observation.error
    pushed = min(abs(e2), len(observation.error), np.add(e1, e2), float(ctypes.c_double(e3).value))
    return state, BodyVelocity(LIBRARY.fabs(e1) + pushed, magnitude(e2) + cmath.phase(1j))


def test_functions_of_c_that_a_law_calls_by_name_are_told_by_line():
    with pytest.warns(ConformanceWarning, match='depend on the machine') as caught:
        assert list(same_bits_elsewhere(Law('foreign', foreign_step, broken_laws.Gains))) == []
    found = suspects(foreign_step, _elsewhere)
    assert [one.line - foreign_step.__code__.co_firstlineno for one in found] == [3]
    assert 'LIBRARY.fabs(e1) (write a formula in Python, since what C computes is not seen, instead)' in str(
        caught[0].message)


@pytest.mark.parametrize(('function', 'is_foreign'), [
    (magnitude, True), (cmath.phase, True), (scipy.special.expit, True), (ctypes.c_double, False), (np.sin, False),
    (np.zeros, False), (np.random.default_rng, False), (len, False), ({}.get, False), (math.sqrt, False),
    (np.zeros(3).sum, False), (itertools.islice, False), (BodyVelocity, False)])
def test_a_function_of_c_is_told_from_those_of_python_and_numpy(function, is_foreign):
    assert _is_foreign(function) is is_foreign


@pytest.mark.parametrize('law', [*OUTSIDE, *BUILT_IN], ids=lambda law: law.name)
def test_laws_of_the_elementary_functions_do_not(law):
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        assert list(same_bits_elsewhere(law)) == []
    assert suspects(law.step) == []


def _row(first):
    row = next(line for line in PAGE.splitlines() if line.startswith(f'| {first}'))
    return set(re.findall(r'\w+', ' '.join(re.findall(r'`([^`]*)`', row)))) - {'x', 'y', 'math', 'base'}


def test_the_functions_of_the_page_are_those_of_this_test_and_of_the_check():
    # exp2 is of Python 3.11
    used = inspect.getsource(basic) + inspect.getsource(transcendental)
    assert {name for name in _row('equal to the last bit') - {'exp2'} if not re.search(rf'\b{name}\(', used)} == set()
    assert [one.expression for one in suspects(basic)] == []
    assert set(DIFFERENT) - {'pow'} == _row('different in last bits') - {'sqrt', 'of', 'y'}
    assert set(UNCOMPILED) == {name for name in _row('not compiled') if not name.isdigit()} - {'log', 'float'}
