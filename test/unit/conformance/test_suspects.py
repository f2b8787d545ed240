"""Suspicious expressions are found in a law's step and in what it calls, and nowhere else."""

import math
from functools import partial

import broken_laws
import pytest

from mobile_robot_control.conformance.compiled_form import suspects


def _fourth_power(x):
    x **= 4
    return x


def _not_called(x):
    return math.fmod(x, 2.0)


def calling_step(state, observation, gains, dt):
    """The word pow( in a text is no call."""
    return state, (_fourth_power(math.cos(dt)), math.log(dt, 2.0), broken_laws.command(observation))


def bound_step(power):
    def step(state, observation, gains, dt):
        return state, power(dt)

    return step


def test_powers_and_calls_are_named_with_their_lines():
    found = suspects(calling_step)
    first, power = calling_step.__code__.co_firstlineno, _fourth_power.__code__.co_firstlineno
    assert [(one.line, one.text) for one in found] == [(first + 2, 'math.log(dt, 2.0)'), (power + 1, 'x **= 4')]
    assert {one.file for one in found} == {__file__}


def test_what_a_step_is_bound_to_is_looked_into():
    assert [one.text for one in suspects(bound_step(_fourth_power))] == ['x **= 4']


@pytest.mark.parametrize('step', [broken_laws.sound_step, len, partial(_not_called)])
def test_safe_steps_and_those_without_a_source_have_none(step):
    assert suspects(step) == []
