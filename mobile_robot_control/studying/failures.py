"""The scenarios in which a controller fails in a study: split by what separates them best, and in words."""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.analysis.intervals import log_hypergeometric_tail
from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.elementary import exp, hypot, log
from mobile_robot_control.loop.monte_carlo import CONFIDENCE, Judged, JudgedRuns, Scenarios
from mobile_robot_control.loop.scenarios import Scenario

_PARTS = 20
"""A quantity is split at each twentieth of the scenarios."""
FEW = 3
"""Up to so many failures are listed, and no split is sought: any few scenarios have something in common."""
LISTED = 1000
"""Most failures that `study.json` lists."""


class Quantity(NamedTuple):
    """
    A quantity that varies between scenarios.

    Attributes
    ----------
    words, unit : str
        Name and unit in texts.
    of : callable
        Returns its values in scenarios, numbers or names.

    """

    words: str
    unit: str
    of: Callable[[Scenarios], NDArray[Any]]


QUANTITIES: dict[str, Quantity] = {
    'curve': Quantity('curve', '', lambda some: some.curve),
    'scale': Quantity('scale', 'm', lambda some: some.scale),
    'start_distance': Quantity('start distance', 'm',
                               lambda some: np.array([*map(hypot, *some.start.T[:2].tolist())])),
    'start_heading_error': Quantity('start heading error', 'rad',
                                    lambda some: np.abs([*map(wrap_angle, some.start.T[2].tolist())])),
    'mass_factor': Quantity('mass factor', '', lambda some: some.mass),
    'friction_factor': Quantity('friction factor', '', lambda some: some.friction),
    'delay': Quantity('delay', 'velocity periods', lambda some: some.delay),
}
"""By the name in `study.json`. The strength of the noise is the same in all scenarios of a study."""


class Split(NamedTuple):
    """
    A split of the scenarios into two parts, one with more failures.

    Attributes
    ----------
    quantity : str
        Of QUANTITIES.
    side : str
        Of the part with more failures: 'is', 'at most' or 'above'.
    value : float or str
        Value that defines the side.
    there, elsewhere : tuple of int
        Failures and runs in that part, and in the other.
    chance : float
        Upper bound of the probability that any of the tried splits is so uneven by chance.

    """

    quantity: str
    side: str
    value: float | str
    there: tuple[int, int]
    elsewhere: tuple[int, int]
    chance: float

    @property
    def words(self) -> str:
        """The part with more failures."""
        return f'{QUANTITIES[self.quantity].words} {self.side} {shown(self.quantity, self.value)}'


def shown(quantity: str, value: float | str) -> str:
    """Return a value of a quantity with its unit."""
    number = value if isinstance(value, str) else f'{value:.3g}'
    return f'{number} {QUANTITIES[quantity].unit}'.strip()


def _parts(values: NDArray[Any]) -> Iterator[tuple[str, float | str, NDArray[np.bool_]]]:
    """Yield the parts of the scenarios by the values of a quantity: side, value, and a mask of the scenarios."""
    distinct = np.unique(values).tolist()
    if isinstance(distinct[0], str):
        yield from (('is', value, values == value) for value in distinct)
        return
    if len(distinct) > _PARTS:
        ordered = np.sort(values)
        distinct = [float(ordered[n * len(ordered) // _PARTS]) for n in range(1, _PARTS)]
    # limits have the printed precision, so that the printed split is exact
    for limit in sorted({float(f'{limit:.3g}') for limit in distinct}):
        above = values > limit
        yield 'above', limit, above
        yield 'at most', limit, ~above


def best_split(scenarios: Sequence[Scenario], judged: Sequence[Judged]) -> Split | None:
    """
    Return the split of the scenarios by one quantity that is least likely by chance.

    Each is judged by Fisher's exact test, corrected for the number of splits tried (Bonferroni).

    Parameters
    ----------
    scenarios : sequence of Scenario
        Of the runs.
    judged : sequence of Judged
        The runs, in the same order.

    Returns
    -------
    Split or None
        None if even that one may be chance, and if few or all runs failed.
    """
    driven, failed = Scenarios.of(scenarios)[:len(judged)], ~JudgedRuns.of(judged).success
    failures, runs = int(failed.sum()), len(judged)
    if failures <= FEW or failures == runs:
        return None
    tried, best = 0, Split('', '', '', (0, 0), (0, 0), math.inf)
    for name, quantity in QUANTITIES.items():
        for side, value, inside in _parts(quantity.of(driven)):
            drawn, there = int(inside.sum()), int((inside & failed).sum())
            if not 0 < drawn < runs:
                continue
            tried += 1
            # without a surplus of failures there is nothing to test
            if there * runs > failures * drawn:
                log_chance = log_hypergeometric_tail(there, drawn, failures, runs)
                if log_chance < best.chance:
                    best = Split(name, side, value, (there, drawn), (failures - there, runs - drawn), log_chance)
    chance = exp(min(0.0, best.chance + log(tried))) if tried else 1.0
    return best._replace(chance=chance) if chance <= 1.0 - CONFIDENCE else None


_ENDS = {'completed': 'too far from the reference over the last quarter', 'diverged': 'diverged',
         'law_failed': 'with a position law that failed'}


def _failed(scenarios: Sequence[Scenario], judged: Sequence[Judged]) -> tuple[list[int], Scenarios, JudgedRuns]:
    """Return the failures: their numbers, from 1, their scenarios, and the runs."""
    runs = JudgedRuns.of(judged)
    failed = np.flatnonzero(~runs.success)
    return (failed + 1).tolist(), Scenarios.of(scenarios).chosen(failed), runs.chosen(failed)


def _words(scenarios: Scenarios) -> list[str]:
    """Describe the conditions of each of some runs."""
    columns = [[f'{quantity.words} {shown(name, value)}' for value in quantity.of(scenarios).tolist()]
               for name, quantity in QUANTITIES.items()]
    return [*map(', '.join, zip(*columns, strict=True))]


def scenario_text(scenario: Scenario) -> str:
    """Describe the conditions of a run."""
    return _words(Scenarios.of([scenario]))[0]


def failure_texts(scenarios: Sequence[Scenario], judged: Sequence[Judged]) -> Iterator[str]:
    """Yield sentences on the failures of a controller; none if there are none."""
    failed, where, runs = _failed(scenarios, judged)
    if not failed:
        return
    ends = Counter(runs.outcome.tolist())
    how = ', '.join(f'{count} {_ENDS[outcome]}' if len(ends) > 1 else _ENDS[outcome]
                    for outcome, count in sorted(ends.items()))
    yield f'{len(failed)} of {len(judged)} {"fails" if len(failed) == 1 else "fail"}: {how}'
    if len(failed) <= FEW:
        yield from map('run {}: {}'.format, failed, _words(where))
        return
    split = best_split(scenarios, judged)
    if split:
        (there, drawn), (rest, others) = split.there, split.elsewhere
        yield f'{there} of them with {split.words}: {there} of {drawn} fail there, {rest} of {others} elsewhere'
        return
    ranges = '; '.join(f'{QUANTITIES[name].words} {_range_text(name, values)}'
                       for name, values in _ranges(scenarios, judged, success=False).items())
    yield f'no single quantity tells them from the others: they have {ranges}' if len(failed) < len(judged) else ranges


def _range_text(name: str, values: Sequence[Any]) -> str:
    """Describe the range of a quantity over at least one value."""
    low, high = values[0], values[-1]
    if isinstance(low, str):
        return ', '.join(values)
    return f'{low:.3g} to {shown(name, high)}' if low < high else shown(name, high)


def _ranges(scenarios: Sequence[Scenario], judged: Sequence[Judged], success: bool) -> dict[str, list[Any]]:
    """Return the range of each quantity among failures or successes; for names all values, and [] without any run."""
    chosen = Scenarios.of(scenarios).chosen(np.flatnonzero(JudgedRuns.of(judged).success == success))

    def of(quantity: Quantity) -> list[Any]:
        values = np.unique(quantity.of(chosen)).tolist()
        return values if not values or isinstance(values[0], str) else [values[0], values[-1]]

    return {name: of(quantity) for name, quantity in QUANTITIES.items()}


def failure_values(scenarios: Sequence[Scenario], judged: Sequence[Judged]) -> dict[str, Any]:
    """Return the failures of a controller, as in `study.json`."""
    (failed, where, runs), split = _failed(scenarios, judged), best_split(scenarios, judged)
    listed = where[:LISTED]
    columns = {'run': failed[:LISTED], 'outcome': runs.outcome[:LISTED].tolist(),
               **{name: quantity.of(listed).tolist() for name, quantity in QUANTITIES.items()},
               'noise_seed': listed.seed.tolist()}
    return {
        'count': len(failed),
        'outcomes': dict(sorted(Counter(runs.outcome.tolist()).items())),
        'split': split._asdict() | {'words': split.words} if split else None,
        'ranges': {'failures': _ranges(scenarios, judged, success=False),
                   'successes': _ranges(scenarios, judged, success=True)},
        'scenarios': [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)],
    }
