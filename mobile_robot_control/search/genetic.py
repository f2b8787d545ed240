"""The chapter's genetic algorithm on binary chromosomes: each gene is an integer of twelve bits."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

BITS = 12
"""Bits of a gene, as in section 3.1 of the chapter."""

LOWEST_POINT = 1.0 / 2**BITS
"""The lowest point of a gene: not zero, because most gains must not be zero."""

Bits = NDArray[np.bool_]
Points = NDArray[np.float64]

_WEIGHTS = np.ldexp(1.0, -np.arange(1, BITS + 1))


def points(bits: Bits) -> Points:
    """
    Return the points of the unit cube that chromosomes encode.

    Parameters
    ----------
    bits : array of bool, shape (individuals, genes × 12)
        The most significant bit of each gene comes first.

    Returns
    -------
    array of float, shape (individuals, genes)
        In [1/4096, 1], each gene's 4096 values evenly spaced.

    Examples
    --------
    >>> points(np.array([[True] + 11 * [False], 12 * [True]])).ravel().tolist()
    [0.500244140625, 1.0]

    """
    genes: Any = bits.reshape(len(bits), -1, BITS)
    return np.asarray(genes @ _WEIGHTS + LOWEST_POINT)


def bits_of(points: Points) -> Bits:
    """Return the chromosomes of points in [1/4096, 1], each gene rounded to one of its values."""
    integers = np.rint((points - LOWEST_POINT) * 2**BITS).astype(np.int64)
    return np.asarray((integers[..., None] >> np.arange(BITS)[::-1]) & 1, bool).reshape(len(points), -1)


def random(individuals: int, genes: int, rng: np.random.Generator) -> Bits:
    """Draw uniformly distributed chromosomes, shape (individuals, genes × 12)."""
    return rng.random((individuals, genes * BITS)) < 0.5


WORST = 1e9
"""The score of an individual without a finite score."""
Scores = NDArray[np.float64]
Score = Callable[[Points], Scores]
"""Scores points, smaller is better; ends the search by raising."""
Begin = Callable[[Points], Points]
"""Moves the points that are drawn at the start, shape (population, genes)."""


class GeneticSettings(NamedTuple):
    """
    Rates of the operators; the chapter gives no numbers for them.

    Attributes
    ----------
    tournament : int
        Number of individuals that compete to be a parent.
    crossover : float
        Probability that two parents are mixed; otherwise the child is a copy of the first.
    mutations : float
        Expected number of bits that flip in a child.
    elite : int
        Number of the best individuals that are kept unchanged.
    """

    tournament: int = 3
    crossover: float = 0.9
    mutations: float = 1.5
    elite: int = 1


def select_parents(scores: Scores, count: int, tournament: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return the indices of `count` parents, each with the smallest score among `tournament` drawn at random."""
    drawn = rng.integers(len(scores), size=(count, tournament))
    return np.asarray(drawn[np.arange(count), np.argmin(scores[drawn], axis=1)])


def breed(population: Bits, scores: Scores, settings: GeneticSettings, rng: np.random.Generator) -> Bits:
    """
    Make the next generation: tournament selection, uniform crossover, bit mutation, elitism.

    Implements the algorithm named in section 3.1 of the chapter.

    Parameters
    ----------
    population : array of bool, shape (individuals, bits)
        The present generation.
    scores : array of float, shape (individuals,)
        Its scores; smaller is better.
    settings : GeneticSettings
        Rates of the operators.
    rng : Generator
        Source of all random numbers.

    Returns
    -------
    array of bool, shape (individuals, bits)
        The elite first, in order of their scores.
    """
    individuals, bits = population.shape
    elite = population[np.argsort(scores, kind='stable')[:settings.elite]]
    count = individuals - len(elite)
    mothers, fathers = (population[select_parents(scores, count, settings.tournament, rng)] for _ in range(2))
    mixes = rng.random((count, 1)) < settings.crossover
    children = np.where(mixes & (rng.random((count, bits)) < 0.5), fathers, mothers)
    children ^= rng.random((count, bits)) < settings.mutations / bits
    return np.concatenate([elite, children])


def search(
    score: Score, genes: int, population: int, generations: int, seed: int, begin: Begin = lambda drawn: drawn,
    settings: GeneticSettings | None = None,
) -> None:
    """
    Search the unit cube until `score` ends the search.

    Parameters
    ----------
    score : callable
        Scores the points of a generation, shape (population, genes); ends the search by raising.
    genes, population, generations : int
        Dimensions, individuals of a generation, and generations.
    seed : int
        Of all random numbers: the same seed gives the same search.
    begin : callable
        Moves the points that are drawn at the start, shape (population, genes).
    settings : GeneticSettings or None
        Rates of the operators; the defaults if None.
    """
    rng = np.random.default_rng(seed)
    bits = bits_of(begin(points(random(population, genes, rng))))
    for _ in range(generations):
        bits = breed(bits, score(points(bits)), settings or GeneticSettings(), rng)
