"""The reason why a law does not compile is one line."""

import math
import os

import pytest
from each import each_row

from mobile_robot_control.simulation.batch import reason_of


def _remainder(x):
    return math.fmod(x, 2.0)


def _outer(x):
    return _remainder(x) + 1.0


def test_the_reason_is_that_of_the_innermost_function():
    numba = pytest.importorskip('numba')
    from numba.extending import register_jitable
    register_jitable(_remainder)
    with pytest.raises(numba.core.errors.NumbaError) as refusal:
        numba.njit(_outer)(1.0)
    line = _remainder.__code__.co_firstlineno + 1
    assert reason_of(refusal.value) == (
        f"Unknown attribute 'fmod' of type Module(<module 'math'>), at {os.path.realpath(__file__)}, line {line}")


@each_row(('text', 'reason'), [
    ('', 'ValueError'), ('no report at all', 'no report at all'),
    ('Failed in nopython mode pipeline (step: frontend)\n\n  Use of unsupported code\n', 'Use of unsupported code'),
])
def test_what_names_no_line_is_told_without(text, reason):
    assert reason_of(ValueError(text)) == reason
