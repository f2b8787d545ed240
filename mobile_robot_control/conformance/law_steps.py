"""Checks of a law's single steps: pure, finite, safe over the bounds of its gains."""

import copy
from collections.abc import Iterable, Iterator
from random import Random
from typing import Any

from mobile_robot_control.conformance.bits import bits_of
from mobile_robot_control.conformance.checks import LeftOutError
from mobile_robot_control.conformance.gain_sampling import (
    bounded_controls,
    decoded,
    describe_point,
    gain_violations,
    searched_controls,
    searched_points,
)
from mobile_robot_control.conformance.sampling import (
    DT,
    Case,
    default_cases,
    describe,
    describe_gains,
    extreme_observations,
    failure_of,
    follow,
    taken_gains,
)
from mobile_robot_control.control.law import Law
from mobile_robot_control.control.laws import PositionControl
from mobile_robot_control.parameters.checking import ParameterError

_SEED = 20
_PURE = 250
"""Inputs on which a law is asked again and again."""


def _copied(value: Any) -> Any:
    """Return a copy of an input; the input itself where it cannot be copied, such as a solver that `prepare` keeps."""
    try:
        return copy.deepcopy(value)
    except Exception:  # a class can raise anything
        return value


def _some_cases(law: Law) -> list[Case]:
    """Return inputs on which the law does not fail."""
    cases = Random(_SEED).sample(default_cases(law), _PURE)  # noqa: S311 (no secret)
    sound = [case for case in cases if not failure_of(law, case)]
    if not sound:
        raise LeftOutError('the law fails on every input')
    return sound


def pure(law: Law) -> Iterator[str]:
    """Yield inputs with which a law gives another result later, or after others."""
    cases = _some_cases(law)
    given = [(case, _copied(taken_gains(case.control, case.dt))) for case in cases]
    order = list(range(len(given)))

    def results(those: Iterable[int]) -> dict[int, Any]:
        found = {}
        for n in those:
            case, gains = given[n]
            # copies: whether inputs are left unchanged is a check of its own
            found[n] = law.step(_copied(case.state), _copied(case.observation), _copied(gains), case.dt)
        return found

    first = results(order)
    shuffled = Random(_SEED).sample(order, len(order))  # noqa: S311 (no secret)
    for again, when in ((order, 'in the same'), (order[::-1], 'in reverse'), (shuffled, 'in another')):
        for n, after in results(again).items():
            if bits_of(after) != bits_of(first[n]):
                yield (f'returned {first[n]} first and {after} later, when asked again {when} order, '
                       f'{describe(law, cases[n])}')


def inputs_unchanged(law: Law) -> Iterator[str]:
    """Yield inputs that a law changes: state, observation, gains, or what its `prepare` has returned."""
    for case in _some_cases(law):
        inputs = {'state': case.state, 'observation': case.observation,
                  'gains' if law.prepare is None else 'prepared gains': taken_gains(case.control, case.dt)}
        given = {name: _copied(value) for name, value in inputs.items()}
        before = {name: bits_of(value) for name, value in given.items()}
        state, observation, gains = given.values()
        law.step(state, observation, gains, case.dt)
        for name, value in given.items():
            if bits_of(value) != before[name]:
                yield f'the step changes its {name}, {describe(law, case)}'


def finite(law: Law) -> Iterator[str]:
    """Yield finite inputs on which a law raises, or returns what is no state and finite command."""
    for case in default_cases(law):
        yield from filter(None, [failure_of(law, case)])


def _failures(law: Law, control: PositionControl) -> Iterator[str]:
    """Yield inputs on which a law fails with gains."""
    try:
        taken_gains(control, DT)
    except ParameterError as error:
        yield str(error)
        return
    # every eleventh has each distance, angle and velocity
    for case in follow(law, law.start, extreme_observations(law.horizon)[::11], control, DT):
        yield from filter(None, [failure_of(law, case)])


def gains_are_safe(law: Law) -> Iterator[str]:
    """Yield gains within their bounds with which a law fails; where a gain has no bound, 1e12 is one."""
    draws = Random(_SEED)  # noqa: S311 (no secret)
    for control in bounded_controls(law, draws):
        yield from (f'{text}; bound the gain by its Field or a rule' for text in _failures(law, control))
    for control in searched_controls(law, draws):
        yield from (f'{text}; narrow what the Field names as search' for text in _failures(law, control))


def repair_is_sound(law: Law) -> Iterator[str]:
    """Yield drawn gains of which a law's `repair` makes such as a node refuses."""
    if law.repair is None:
        raise LeftOutError('the law has no repair')
    points = searched_points(law, Random(_SEED))  # noqa: S311 (no secret)
    if not points:
        raise LeftOutError('no gain of the law has a range to search')
    for point in points:
        try:
            control = decoded(law, point)
        except Exception as error:  # a repair can raise anything
            yield f'repair raises {type(error).__name__}: {error}, of drawn {describe_point(law, point)}'
            return
        yield from (f'repair returns gains that break bounds or rules: {violation}, with '
                    f'{describe_gains(law, control)}' for violation in gain_violations(law, control))
