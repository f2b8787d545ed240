"""The exact solutions that steps with motors and friction are made of, and the first zero along them."""

import math
import random
from decimal import Decimal, localcontext

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from mobile_robot_control.model.modes import Mode, Modes, mode_after
from mobile_robot_control.model.responses import fading_response, held_response
from mobile_robot_control.model.zeros import Watch, first_zero

RATES = st.floats(-9.0, 2.5).map(lambda exponent: 10.0**exponent)


@given(RATES, RATES, st.floats(0.001, 3.0))
@example(0.0, 1e-9, 3.0)
@example(0.0, 300.0, 0.4)
@example(1.0, 1.0000001, 3.0)
@example(7.0, 7.0, 0.001)
def test_the_responses_are_those_of_many_digits(rate, fading, time):
    with localcontext() as context:
        context.prec = 120
        # rates that are equal, or zero, are taken apart by too little to be seen
        a, b, t = Decimal(rate) + Decimal('1e-40'), Decimal(fading) + Decimal('2e-40'), Decimal(time)
        one, other = (1 - (-a * t).exp()) / a, (1 - (-b * t).exp()) / b
        held = (float((-a * t).exp()), float(one), float((t - one) / a))
        faded = (float(((-b * t).exp() - (-a * t).exp()) / (a - b)), float((other - one) / (a - b)))
    # an exponential of a rounded exponent is right to as many digits as the exponent is
    near = 2e-14 + 2e-16 * max(rate, fading) * time
    assert held_response(rate, time) == pytest.approx(held, rel=near, abs=1e-300)
    assert fading_response(rate, fading, time) == pytest.approx(faded, rel=near)


NOTHING = Mode(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def test_the_first_zero_by_hand():
    # x' = -2 x from 1: x = 0.3 at ln(1/0.3)/2
    falling = Modes(Mode(2.0, 1.0, 0.0, 1.0, 0.0, 0.0), NOTHING)
    watch = Watch(-0.3, 0.0, 1.0, 0.0)
    assert first_zero(watch, falling, 0.0, 5.0) == pytest.approx(0.5 * math.log(1.0 / 0.3), rel=1e-14)
    assert first_zero(watch, falling, 0.0, 0.5) == 0.5
    assert first_zero(Watch(0.1, 0.0, 1.0, 0.0), falling, 0.0, 50.0) == 50.0
    # a straight line without damping
    straight = Modes(Mode(0.0, 1.0, 0.0, 1.0, -4.0, 0.0), NOTHING)
    assert first_zero(Watch(0.0, 0.0, 1.0, 0.0), straight, 0.0, 1.0) == pytest.approx(0.25, rel=1e-14)


def test_a_zero_at_the_start_counts_unless_the_quantity_rises():
    rising, falling = (Modes(Mode(1.0, 1.0, 0.0, 0.0, push, 0.0), NOTHING) for push in (1.0, -1.0))
    watch = Watch(0.0, 0.0, 1.0, 0.0)
    assert first_zero(watch, rising, 0.0, 1.0) == 1.0
    assert first_zero(watch, falling, 0.0, 1.0) == 0.0


def test_a_short_dip_within_a_long_time_is_found():
    # two exponentials and a fading one, against two hundred samples
    draws, found = random.Random(2), 0  # noqa: S311 (no secret)
    for _ in range(300):
        modes = Modes(*(Mode(draws.choice([0.0, 1.0, 30.0]) * draws.random(), 1.0, 1.0, draws.uniform(-1.0, 1.0),
                             draws.uniform(-9.0, 9.0), draws.uniform(-9.0, 9.0)) for _ in range(2)))
        lag_rate, watch = draws.choice([2.0, 50.0]), Watch(draws.uniform(0.0, 0.5), draws.uniform(-1.0, 1.0), 1.0, 1.0)

        def value(time, modes=modes, lag_rate=lag_rate, watch=watch):
            return (watch.level + watch.fade * math.exp(-lag_rate * time)
                    + sum(mode_after(mode, lag_rate, time)[0] for mode in modes))

        if value(0.0) <= 0.0:
            continue
        zero = first_zero(watch, modes, lag_rate, 1.0)
        assert all(value(zero * n / 200.0) > 0.0 for n in range(200))
        if zero < 1.0:
            found += 1
            assert value(zero) == pytest.approx(0.0, abs=1e-12)
    assert found > 50
