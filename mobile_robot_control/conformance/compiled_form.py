"""The check of a law's compiled form against the plain one."""

import warnings
from collections.abc import Callable, Iterator
from itertools import islice
from random import Random
from typing import Any

from mobile_robot_control.conformance.bits import bits_of, numbers
from mobile_robot_control.conformance.checks import ConformanceWarning, LeftOutError
from mobile_robot_control.conformance.gain_sampling import searched_controls
from mobile_robot_control.conformance.sampling import (
    DT,
    Case,
    default_cases,
    default_control,
    describe,
    extreme_observations,
    failure_of,
    follow,
    near_observations,
    taken_gains,
)
from mobile_robot_control.conformance.suspects import suspects
from mobile_robot_control.control.law import Law
from mobile_robot_control.control.laws import BUILT_IN
from mobile_robot_control.simulation import batch
from mobile_robot_control.simulation.compiler_messages import reason_of

TOLERANCE = 1e-12
"""Of a law of one's own: of the larger of a number and 1, in SI units. Built-in laws are equal to the last bit."""
_SEED = 40
_NEAR = 5000


def _cases(law: Law) -> list[Case]:
    """Return inputs with default gains and with those that a search may draw."""
    draws = Random(_SEED)  # noqa: S311 (no secret)
    cases = default_cases(law)
    for control in islice(searched_controls(law, draws), 24):
        cases += follow(law, law.start, extreme_observations(law.horizon)[::11], control, DT)
    # last bits differ for few inputs: of a square for one in thousands
    control = default_control(law)
    return cases + [Case(law.start, observation, control, DT)
                    for observation in near_observations(draws, _NEAR, law.horizon)]


def _compiled(law: Law, case: Case) -> Any:
    """Return the compiled step, compiled for a case; raise LeftOutError where that cannot be done."""
    if not batch.COMPILES:
        raise LeftOutError('numba is not installed')
    plain: Callable[..., Any] = law.step
    try:
        step = batch.compiled_step(plain)
        step(case.state, case.observation, taken_gains(case.control, case.dt), case.dt, 0)
    except Exception as error:  # an object that is no function raises other errors than those of numba
        reason = reason_of(error)
        text = f"the law '{law.name}' runs plain, some hundred times slower: numba cannot compile it ({reason})"
        _warn(law, text)
        raise LeftOutError(f'numba cannot compile it: {reason}') from error
    return step


def _warn(law: Law, text: str) -> None:
    """Warn of what lies in the source of a law: at the first suspicious expression, or at the law's step."""
    found = suspects(law.step)
    code = getattr(law.step, '__code__', None)
    file, line = (found[0].file, found[0].line) if found else (
        getattr(code, 'co_filename', law.name), getattr(code, 'co_firstlineno', 1))
    warnings.warn_explicit(text, ConformanceWarning, file, line)


def _lines(law: Law) -> str:
    """Return the expressions that are known to round otherwise when compiled, with file and line."""
    found = '; '.join(map(str, suspects(law.step)))
    return f'see {found}' if found else 'no expression is known to round otherwise; a division by zero does not raise'


def _share(plain: Any, compiled: Any) -> float:
    """Return the largest difference of two results, in units of the tolerance."""
    ours, theirs = numbers(plain), numbers(compiled)
    if len(ours) != len(theirs):
        return float('inf')
    largest = 0.0
    for one, other in zip(ours, theirs, strict=True):
        difference = abs(one - other)
        if bits_of(one) != bits_of(other):
            # not a number, or infinite, on one side alone
            largest = max(largest, difference / (TOLERANCE * max(1.0, abs(one)))
                          if difference < float('inf') else float('inf'))
    return largest


def compiled_equals_plain(law: Law) -> Iterator[str]:
    """Yield inputs on which a law's compiled form differs; warn of differences in last bits."""
    cases = [case for case in _cases(law) if not failure_of(law, case)]
    if not cases:
        raise LeftOutError('the law fails on every input')
    compiled = _compiled(law, cases[0])
    shipped = any(law is each for each in BUILT_IN)
    rounded: tuple[Case, Any, Any] | None = None
    for case in cases:
        gains = taken_gains(case.control, case.dt)
        plain = law.step(case.state, case.observation, gains, case.dt)
        result = compiled(case.state, case.observation, gains, case.dt, 1)
        share = _share(plain, result)
        if share > (0.0 if shipped else 1.0):
            yield f'returns {plain} plain and {result} compiled, {describe(law, case)}; {_lines(law)}'
        elif share > 0.0 and rounded is None:
            rounded = case, plain, result
    if rounded is not None:
        case, plain, result = rounded
        text = (f"the law '{law.name}' returns {plain} plain and {result} compiled, equal within {TOLERANCE:g} only, "
                f'{describe(law, case)}; {_lines(law)}')
        _warn(law, text)
