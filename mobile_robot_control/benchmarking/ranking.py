"""Ranks of controllers in the same scenarios, as far as their paired differences tell them apart."""

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence

from mobile_robot_control.loop.monte_carlo import Judged
from mobile_robot_control.studying.comparison import compare

Ranks = dict[str, tuple[int, int]]
RANKED = 'rms_position_error'
_COMPARED_FROM = 0.5
"""Share of scenarios in which a controller succeeds at least whose errors are compared."""


def shared_scenarios(controllers: Mapping[str, Sequence[Judged]]) -> list[int]:
    """Return the scenarios in which all controllers succeed, but those that fail in more than half of them."""
    compared = [runs for runs in controllers.values() if sum(run.success for run in runs) >= _COMPARED_FROM * len(runs)]
    return [n for n, runs in enumerate(zip(*compared, strict=True)) if all(run.success for run in runs)]


def better_pairs(controllers: Mapping[str, Sequence[Judged]]) -> set[tuple[str, str]]:
    """
    Return the pairs of controllers of which the first is better, for certain.

    It is better where it succeeds more often, or, where that does not tell them apart, where its RMS error is smaller
    in the mean over the scenarios in which both succeed. The intervals of all pairs, of success and of error, hold
    together with 95 %.
    """
    pairs = list(itertools.combinations(controllers, 2))
    found = set()
    for first, second in pairs:
        # of success and of error: two families
        one = compare((first, second), (controllers[first], controllers[second]), (RANKED,), 2 * len(pairs))
        winner = one.more_successful or one.better(one.differences[0])
        if winner:
            found.add((winner, second if winner == first else first))
    return found


def rank_ranges(names: Iterable[str], better: Iterable[tuple[str, str]]) -> Ranks:
    """
    Return the first and the last rank that each controller may have.

    The first one is one more than the number of those that are better for certain, the last one leaves room for those
    that are worse for certain: the confidence sets of ranks of Mogstad et al., Review of Economic Studies 91, 2024.
    Where two cannot be told apart, their ranges have a rank in common.

    Examples
    --------
    >>> rank_ranges(['a', 'b', 'c'], [('a', 'c')])
    {'a': (1, 2), 'b': (1, 3), 'c': (2, 3)}

    """
    known, ranked = set(better), list(names)
    ranks = {name: (1 + sum(pair[1] == name for pair in known), len(ranked) - sum(pair[0] == name for pair in known))
             for name in ranked}
    for a, b in itertools.permutations(ranked, 2):
        # where 'better' goes in a circle: it is no order, since it has two criteria
        if not {(a, b), (b, a)} & known and ranks[b][1] < ranks[a][0]:
            ranks[b] = (ranks[b][0], ranks[a][0])
    return ranks


def ranked(controllers: Mapping[str, Sequence[Judged]]) -> Ranks:
    """Return the ranks of controllers; those without any run, which could not be judged, share the last ones."""
    judged = {name: runs for name, runs in controllers.items() if runs}
    ranks = rank_ranges(judged, better_pairs(judged))
    return ranks | {name: (len(judged) + 1, len(controllers)) for name in controllers if name not in judged}


def quantile(values: Sequence[float], fraction: float) -> float | None:
    """Return the value at rank ⌈fraction N⌉ of the ascending ones, as in a study; None where it is infinite."""
    ordered = sorted(values)
    value = ordered[math.ceil(fraction * len(ordered)) - 1] if ordered else math.inf
    return value if math.isfinite(value) else None
