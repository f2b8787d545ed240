"""Elementary functions: within 1 ulp of the correctly rounded value, special values of C, compiled the same bits."""

import itertools
import math
import os
import subprocess
import sys
from pathlib import Path
from random import Random

import bits
import pytest

from mobile_robot_control import elementary

BITS = Path(bits.__file__)
mpmath = pytest.importorskip('mpmath')
SPECIAL = [0.0, -0.0, 1.0, -1.0, 0.5, -2.0, 3.0, 2.5, math.inf, -math.inf, math.nan, 5e-324, -5e-324, 1e-310, 1.7e308,
           -1.7e308, 1e300, 1e-300, 2.0**53, -(2.0**53 + 2.0), 709.9, -745.5]
FAR = 1e5
"""Up to which sine, cosine and tangent keep their promise."""


def _spread(draw, low, high):
    return math.copysign(math.ldexp(1.0 + draw.random(), draw.randint(low, high)), draw.choice((-1.0, 1.0)))


def _angle(draw):
    """Draw an angle; in two of five cases near a multiple of π/2, where most bits cancel."""
    near = draw.randint(-63661, 63661) * math.pi / 2.0
    return draw.choice((draw.uniform(-4.0, 4.0), draw.uniform(-FAR, FAR), _spread(draw, -60, 15),
                        math.nextafter(near, 0.0), near * (1.0 + _spread(draw, -52, -12))))


def _wide(draw):
    return draw.choice((draw.uniform(-4.0, 4.0), _spread(draw, -60, 60)))


def _power(draw):
    """Draw a base and an exponent whose power neither overflows nor vanishes."""
    base = abs(draw.choice((1.0 + _spread(draw, -40, -3), _spread(draw, -300, 300))))
    most = 700.0 / max(abs(math.log(base)), 1e-9)
    return base, draw.choice((draw.uniform(-most, most), max(-most, min(most, draw.uniform(-4.0, 4.0)))))


ONE = {
    'sin': _angle, 'cos': _angle, 'tan': _angle, 'atan': _wide,
    'asin': lambda draw: draw.choice((draw.uniform(-1.0, 1.0), 1.0 - abs(_spread(draw, -53, -2)),
                                      _spread(draw, -40, -1))),
    'exp': lambda draw: draw.choice((draw.uniform(-745.0, 709.7), _spread(draw, -60, 8))),
    'expm1': lambda draw: draw.choice((draw.uniform(-60.0, 709.7), _spread(draw, -60, 5))),
    'tanh': lambda draw: _spread(draw, -60, 5),
    'log': lambda draw: abs(draw.choice((1.0 + _spread(draw, -50, -1), _spread(draw, -1070, 1022)))),
    'log1p': lambda draw: draw.choice((-draw.random(), draw.uniform(-0.5, 3.0), abs(_spread(draw, -60, 900)))),
    # near its zeros the error is absolute
    'lgamma': lambda draw: draw.choice((0.5 * draw.randint(1, 400), draw.uniform(2.1, 30.0),
                                        abs(_spread(draw, 2, 40)))),
}
TWO = {'atan2': lambda draw: (_wide(draw), _wide(draw)), 'hypot': lambda draw: (_wide(draw), _spread(draw, -900, 900)),
       'pow': _power}
DRAWN = {**{name: lambda draw, one=one: (one(draw),) for name, one in ONE.items()}, **TWO}


def _exact(name):
    return getattr(mpmath, {'pow': 'power', 'lgamma': 'loggamma'}.get(name, name))


def _worst(name, count):
    """Return the largest deviation from the correctly rounded value [ulp], and where."""
    draw, worst = Random(name), (0.0, ())  # noqa: S311 (no secret)
    function, exact = getattr(elementary, name), _exact(name)
    with mpmath.workprec(400):
        for _ in range(count):
            at = DRAWN[name](draw)
            rounded = float(exact(*map(mpmath.mpf, at)))
            if math.isfinite(rounded):
                worst = max(worst, (abs(function(*at) - rounded) / math.ulp(rounded), at))
    return worst


@pytest.mark.parametrize('name', DRAWN)
def test_a_function_is_within_1_ulp_of_the_correctly_rounded_value(name):
    deviation, at = _worst(name, 400)
    assert deviation <= 1.0, at


@pytest.mark.soak
@pytest.mark.parametrize('name', DRAWN)
def test_it_is_for_100_000_numbers(name):
    deviation, at = _worst(name, 100_000)
    assert deviation <= 1.0, at


def _same(one, other):
    return (math.isnan(one) and math.isnan(other)) or (one == other and math.copysign(1.0, one) == math.copysign(
        1.0, other))


@pytest.mark.parametrize('name', DRAWN)
def test_special_values_are_those_of_math_and_what_raises_there_is_not_finite_here(name):
    cases = [*itertools.product(SPECIAL, SPECIAL)] if name in TWO else [(x,) for x in SPECIAL]
    for at in cases:
        found = getattr(elementary, name)(*at)
        if (name in ('sin', 'cos', 'tan') and abs(at[0]) > FAR) or (name == 'lgamma' and not at[0] > 0.0):
            continue
        try:
            known = getattr(math, name)(*at)
        except (ValueError, OverflowError):
            assert not math.isfinite(found), at
            continue
        # lgamma of Python is some ulp off
        near = 16.0 if name == 'lgamma' else 2.0
        assert _same(found, known) or abs(found - known) <= near * math.ulp(known), at


def test_an_angle_of_any_size_has_a_sine_and_a_cosine_and_one_that_is_not_finite_has_none():
    for angle in (1e6, 1.0000001e6, -3e9, 1e15, 2e15, 1e300):
        sine, cosine = elementary.sin_cos(angle)
        assert sine * sine + cosine * cosine == pytest.approx(1.0)
    assert all(map(math.isnan, (*elementary.sin_cos(math.inf), *elementary.sin_cos(math.nan))))


def test_far_angles_and_the_zeros_of_lgamma_have_an_absolute_error():
    draw = Random(2)  # noqa: S311 (no secret)
    with mpmath.workprec(400):
        for _ in range(500):
            angle = 10.0 ** draw.uniform(5.0, 15.0)
            error = abs(float(mpmath.sin(mpmath.mpf(angle)) - elementary.sin(angle)))
            assert error <= (1.2e-16 if angle <= 1e6 else 2e-16 * angle), angle
            near = draw.choice((1.0, 2.0)) + draw.choice((-0.1, 0.1)) * 10.0 ** draw.uniform(-12.0, 0.0)
            assert abs(float(mpmath.loggamma(mpmath.mpf(near)) - elementary.lgamma(near))) <= 1e-17, near
    assert (elementary.sin(2e15), elementary.cos(2e15)) == (0.0, 1.0)


def test_compiled_they_have_the_same_bits():
    pytest.importorskip('numba')
    np = pytest.importorskip('numpy')
    from mobile_robot_control.loop.batch import compiled

    draw = Random(1)  # noqa: S311 (no secret)
    first = np.array([*SPECIAL, *(_wide(draw) for _ in range(1500)), *(_angle(draw) for _ in range(500))])
    second = np.array([*SPECIAL, *(_wide(draw) for _ in range(2000))])
    for name in DRAWN:
        function = getattr(elementary, name)
        plain, made = np.empty(first.size), np.empty(first.size)
        compiled(_bound(function, name in TWO))(first, second, made)
        for n, (x, y) in enumerate(zip(first.tolist(), second.tolist(), strict=True)):
            plain[n] = function(x, y) if name in TWO else function(x)
        assert np.array_equal(plain, made, equal_nan=True), name
        assert np.array_equal(np.signbit(plain[~np.isnan(plain)]), np.signbit(made[~np.isnan(made)])), name


def _bound(function, of_two):
    """Return a loop over arrays that calls a function of one or two numbers."""
    if of_two:
        def each(x, y, out):
            for n in range(x.size):
                out[n] = function(x[n], y[n])
    else:
        def each(x, y, out):
            for n in range(x.size):
                out[n] = function(x[n])
    return each


def test_normal_numbers_have_mean_0_and_deviation_1():
    draw = Random(2)  # noqa: S311 (no secret)
    values = [elementary.normal(1.0 - draw.random(), draw.random()) for _ in range(4000)]
    assert sum(values) / 4000.0 == pytest.approx(0.0, abs=0.05)
    assert sum(value * value for value in values) / 4000.0 == pytest.approx(1.0, abs=0.07)


def run(*words, **environment):
    return subprocess.run([sys.executable, BITS, *words], check=False, capture_output=True, text=True,
                          env={**os.environ, **environment})


@pytest.mark.parametrize('environment', [{}, bits.WITHOUT_FMA], ids=['here', 'without FMA'])
def test_a_drawn_sample_has_the_bits_of_the_repository(environment, tmp_path):
    # a rollout takes ten seconds to compile
    words = ['functions', 'paths', 'outcome outside_powered, motors'] if environment else ['--plain']
    done = run('--drawn', *words, **environment, **({'NUMBA_CACHE_DIR': str(tmp_path)} if environment else {}))
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.usefixtures('registered')
def test_another_checksum_is_told(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(bits, 'STORED', tmp_path / 'bits.txt')
    (tmp_path / 'bits.txt').write_text('00000000 elementary.exp\n')
    assert bits.compare(['--drawn', '--plain', 'functions']) == 1
    assert 'nothing in bits.txt' in capsys.readouterr().out


@pytest.mark.soak
@pytest.mark.timeout(7200)
def test_all_of_them_are_equal_everywhere():
    done = run('--everywhere')
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
