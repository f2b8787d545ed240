"""Laws compared over seeds, each of which draws scenarios and searches anew: their means are independent."""

import itertools
import math
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from statistics import fmean
from typing import NamedTuple

import numpy as np

from mobile_robot_control.analysis.intervals import student_tails
from mobile_robot_control.elementary import log
from mobile_robot_control.loop.monte_carlo import CONFIDENCE, JudgedRuns

Runs = Mapping[str, Mapping[int, JudgedRuns]]
"""Judged runs of a track by law and seed; a law that could not be judged with a seed lacks it."""
Ranks = dict[str, tuple[int, int]]
RANKED = 'rms_position_error'
LEAST_SUCCESS = 0.5
"""Share of scenarios in which both of two laws have to succeed for their errors to be compared."""


class Pair(NamedTuple):
    """
    Two laws on a track, seed by seed.

    Attributes
    ----------
    first, second : str
        Their names.
    errors : tuple of float
        Mean of ln(RMS error of the first / that of the second) over the scenarios in which both succeed; seeds with
        less than half of the scenarios that both have driven are left out.
    successes : tuple of float
        Share of scenarios in which the first succeeds, minus that of the second.
    """

    first: str
    second: str
    errors: tuple[float, ...]
    successes: tuple[float, ...]

    def winner(self, values: Sequence[float], smaller: bool) -> str:
        """Return the law that the mean of values speaks for."""
        return self.first if (fmean(values) < 0.0) == smaller else self.second


def pairs_of(track: Runs) -> list[Pair]:
    """Return every pair of laws of a track."""
    return [_pair(*names, track) for names in itertools.combinations(track, 2)]


def _pair(first: str, second: str, track: Runs) -> Pair:
    errors, successes = [], []
    for seed, own in track[first].items():
        other = track[second].get(seed)
        if other is None:
            continue
        # a node drives the first scenarios alone
        a, b = (one.chosen(slice(min(len(own), len(other)))) for one in (own, other))
        successes.append(float(np.mean(a.success)) - float(np.mean(b.success)))
        both = a.success & b.success
        if np.count_nonzero(both) >= LEAST_SUCCESS * len(both):
            errors.append(fmean(log(x) - log(y) for x, y in zip(
                a.metrics[RANKED][both].tolist(), b.metrics[RANKED][both].tolist(), strict=True)))
    return Pair(first, second, tuple(errors), tuple(successes))


def probability(values: Sequence[float]) -> float:
    """
    Return the probability of means at least as far from 0, where that of independent values is 0, by Student's test.

    Examples
    --------
    >>> round(probability([1.0, 2.0, 3.0]), 4)
    0.0742

    """
    n = len(values)
    if n < 2 or not any(values):
        return 1.0
    mean = fmean(values)
    variance = math.fsum((value - mean) * (value - mean) for value in values) / (n - 1)
    return student_tails(abs(mean) / math.sqrt(variance / n), n - 1) if variance else 0.0


def rejected(probabilities: Sequence[float]) -> list[int]:
    """
    Return which hypotheses are rejected with 95 %, all of them together, by the method of Holm.

    Examples
    --------
    >>> rejected([0.03, 0.001, 0.2])
    [1]

    """
    order = sorted(range(len(probabilities)), key=lambda n: probabilities[n])
    return [n for _, n in itertools.takewhile(
        lambda numbered: probabilities[numbered[1]] <= (1.0 - CONFIDENCE) / (len(order) - numbered[0]),
        enumerate(order))]


def better_pairs(pairs: Sequence[Pair]) -> set[tuple[str, str]]:
    """
    Return the pairs of laws of which the first is better with 95 % over seeds, all of them together.

    A law is better that succeeds more often or, where that is not certain, whose error is smaller. Implements the
    method of Holm (Scandinavian Journal of Statistics 6, 1979) over all pairs and both criteria.
    """
    tests = [(kind, n, probability(values)) for n, pair in enumerate(pairs)
             for kind, values in enumerate((pair.successes, pair.errors))]
    decided: dict[int, tuple[str, str]] = {}
    # success, whose kind is 0, before error
    for kind, n, _ in sorted((tests[number] for number in rejected([chance for *_, chance in tests])), reverse=True):
        pair = pairs[n]
        winner = pair.winner(pair.errors, True) if kind else pair.winner(pair.successes, False)
        decided[n] = winner, pair.second if winner == pair.first else pair.first
    return set(decided.values())


def rank_ranges(names: Iterable[str], better: Iterable[tuple[str, str]]) -> Ranks:
    """
    Return the first and the last rank that each law may have.

    The first one is one more than the number of those that are better for certain, the last one leaves room for those
    that are worse for certain: the confidence sets of ranks of Mogstad et al., Review of Economic Studies 91, 2024.
    Where two cannot be told apart, their ranges have a rank in common.

    Examples
    --------
    >>> rank_ranges(['a', 'b', 'c'], [('a', 'c')])
    {'a': (1, 2), 'b': (1, 3), 'c': (2, 3)}

    """
    wins, ranked = set(better), list(names)
    ranks = {name: (1 + sum(pair[1] == name for pair in wins), len(ranked) - sum(pair[0] == name for pair in wins))
             for name in ranked}
    for a, b in itertools.permutations(ranked, 2):
        # where 'better' goes in a circle: it is no order, since it has two criteria
        if not {(a, b), (b, a)} & wins and ranks[b][1] < ranks[a][0]:
            ranks[b] = (ranks[b][0], ranks[a][0])
    return ranks


def ratios(laws: Iterable[str], pairs: Iterable[Pair]) -> dict[str, float]:
    """
    Return the mean ln ratio of each law's error to that of the best law of a track.

    The best one has the smallest errors in most comparisons; a law that no seed compares with it is left out.
    """
    means = {(pair.first, pair.second): fmean(pair.errors) for pair in pairs if pair.errors}
    means |= {(b, a): -mean for (a, b), mean in means.items()}
    wins = {law: sum(mean < 0.0 for (first, _), mean in means.items() if first == law) for law in laws}
    best = max(wins, key=lambda law: wins[law], default='')
    of_best = {law: means[law, best] for law in wins if (law, best) in means}
    return of_best | {best: 0.0} if of_best else {}


Certain = Mapping[str, Collection[tuple[str, str]]]
"""By track the pairs of laws of which the first is known to be better."""


def majority_places(laws: Collection[str], certain: Certain) -> dict[str, int]:
    """
    Return the place of each law over all tracks by pairwise majority.

    A law beats another one if it is known to be better on more tracks than it is known to be worse. Its place is one
    more than the number of laws that beat more, or are beaten by fewer: Copeland's method, which needs no weights.

    Examples
    --------
    >>> majority_places(['a', 'b', 'c'], {'one': [('a', 'b'), ('a', 'c')], 'two': [('b', 'a'), ('a', 'b')]})
    {'a': 1, 'b': 2, 'c': 2}

    """
    margins = Counter(pair for pairs in certain.values() for pair in pairs)
    scores = {law: sum((margins[law, other] > margins[other, law]) - (margins[law, other] < margins[other, law])
                       for other in laws) for law in laws}
    return {law: 1 + sum(score > scores[law] for score in scores.values()) for law in laws}


def place_ranges(laws: Collection[str], certain: Certain, groups: Mapping[str, str]) -> Ranks:
    """Return the first and the last place of each law when any track, or any group of tracks, is left out."""
    left_out = [{track} for track in certain] + [
        {track for track in certain if groups[track] == group} for group in dict.fromkeys(groups.values())]
    placings = [majority_places(laws, certain), *(
        majority_places(laws, {track: pairs for track, pairs in certain.items() if track not in one})
        for one in left_out if len(one) < len(certain))]
    return {law: (min(one[law] for one in placings), max(one[law] for one in placings)) for law in laws}


def quantile(values: Sequence[float], fraction: float) -> float | None:
    """Return the value at rank ⌈fraction N⌉ of the ascending ones, as in a study; None where it is infinite."""
    ordered = sorted(values)
    value = ordered[math.ceil(fraction * len(ordered)) - 1] if ordered else math.inf
    return value if math.isfinite(value) else None
