"""The functions that docs/extending.md calls safe are compiled to the last bit, on the machine of the test."""

import inspect
import math
import re
from pathlib import Path
from random import Random

import pytest

from mobile_robot_control.conformance.compiled_form import DIFFERENT, UNCOMPILED, suspects
from mobile_robot_control.conformance.sampling import bits_of

PAGE = (Path(__file__).parents[3] / 'docs' / 'extending.md').read_text(encoding='utf-8')


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


def _drawn():
    draws = Random(3)  # noqa: S311 (no secret)
    for _ in range(3000):
        x, y = draws.uniform(-6.0, 6.0), draws.choice((-1.0, 1.0)) * draws.uniform(1e-6, 6.0)
        yield draws.choice((x, 1e-3 * x, math.pi, -0.0)), y


@pytest.mark.parametrize('expressions', [basic, transcendental])
def test_safe_expressions_are_compiled_to_the_last_bit(expressions):
    numba = pytest.importorskip('numba')
    compiled = numba.njit(error_model='numpy')(expressions)
    for x, y in _drawn():
        for n, (plain, other) in enumerate(zip(expressions(x, y), compiled(x, y), strict=True)):
            assert bits_of(float(plain)) == bits_of(float(other)), (n, x, y)


def _row(first):
    row = next(line for line in PAGE.splitlines() if line.startswith(f'| {first}'))
    return set(re.findall(r'\w+', ' '.join(re.findall(r'`([^`]*)`', row)))) - {'x', 'y', 'math', 'base'}


def test_the_functions_of_the_page_are_those_of_this_test_and_of_the_check():
    # exp2 is of Python 3.11
    used = inspect.getsource(basic) + inspect.getsource(transcendental)
    assert {name for name in _row('equal to the last bit') - {'exp2'} if not re.search(rf'\b{name}\(', used)} == set()
    assert [one.text for one in suspects(basic)] == []
    assert set(DIFFERENT) - {'pow'} == _row('different in last bits') - {'sqrt', 'of', 'y'}
    assert set(UNCOMPILED) == {name for name in _row('not compiled') if not name.isdigit()} - {'log', 'float'}
