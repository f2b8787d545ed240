"""The split of random scenarios by the quantity that best separates a controller's failures."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.quantities import Pose
from mobile_robot_control.simulation.scenarios import Scenario
from mobile_robot_control.tuning.monte_carlo import CONFIDENCE, Judged
from mobile_robot_control.tuning.tail_probabilities import log_hypergeometric_tail

_PARTS = 20
"""A quantity is split at each twentieth of the scenarios."""
FEW = 3
"""Up to so many failures are listed, and no split is sought: any few scenarios have something in common."""
_AT_START = Pose(0.0, 0.0, 0.0)


class Quantity(NamedTuple):
    """
    A quantity that varies between scenarios.

    Attributes
    ----------
    words, unit : str
        Name and unit in texts.
    of : callable
        Returns its value in a scenario, a number or a name.

    """

    words: str
    unit: str
    of: Callable[[Scenario], Any]


QUANTITIES: dict[str, Quantity] = {
    'curve': Quantity('curve', '', lambda one: one.curve),
    'scale': Quantity('scale', 'm', lambda one: one.scale),
    'start_distance': Quantity('start distance', 'm', lambda one: math.hypot(*(one.start or _AT_START)[:2])),
    'start_heading_error': Quantity('start heading error', 'rad',
                                    lambda one: abs(wrap_angle((one.start or _AT_START).heading))),
    'mass_factor': Quantity('mass factor', '', lambda one: one.mass),
    'friction_factor': Quantity('friction factor', '', lambda one: one.friction),
    'delay': Quantity('delay', 'velocity periods', lambda one: one.delay),
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
    text = value if isinstance(value, str) else f'{value:.3g}'
    return f'{text} {QUANTITIES[quantity].unit}'.strip()


def _parts(values: Sequence[Any]) -> Iterator[tuple[str, float | str, NDArray[np.bool_]]]:
    """Yield the parts of the scenarios by the values of a quantity: side, value, and a mask of the scenarios."""
    array, distinct = np.array(values), sorted(set(values))
    if isinstance(distinct[0], str):
        yield from (('is', value, array == value) for value in distinct)
        return
    if len(distinct) > _PARTS:
        ordered = sorted(values)
        distinct = [ordered[n * len(ordered) // _PARTS] for n in range(1, _PARTS)]
    # limits have the printed precision, so that the printed split is exact
    for limit in sorted({float(f'{limit:.3g}') for limit in distinct}):
        above = array > limit
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
    failed = np.array([not run.success for run in judged], dtype=bool)
    failures, runs = int(failed.sum()), len(judged)
    if failures <= FEW or failures == runs:
        return None
    tried, found = 0, Split('', '', '', (0, 0), (0, 0), math.inf)
    for name, quantity in QUANTITIES.items():
        for side, value, inside in _parts([quantity.of(one) for one in scenarios[:runs]]):
            drawn, there = int(inside.sum()), int((inside & failed).sum())
            if not 0 < drawn < runs:
                continue
            tried += 1
            # without a surplus of failures there is nothing to test
            if there * runs > failures * drawn:
                log_chance = log_hypergeometric_tail(there, drawn, failures, runs)
                if log_chance < found.chance:
                    found = Split(name, side, value, (there, drawn), (failures - there, runs - drawn), log_chance)
    chance = math.exp(min(0.0, found.chance + math.log(tried))) if tried else 1.0
    return found._replace(chance=chance) if chance <= 1.0 - CONFIDENCE else None
