"""The chapter's genetic algorithm, on arrays of bits: it knows no robot."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.tuning import chromosome
from mobile_robot_control.tuning.chromosome import Bits, Points

Scores = NDArray[np.float64]
Score = Callable[[Points], Scores]
"""Scores a generation; the smaller, the better. It ends the search by raising."""


class GeneticSettings(NamedTuple):
    """
    What the chapter names and does not say.

    Attributes
    ----------
    tournament : int
        How many individuals compete to be a parent.
    crossover : float
        Probability that two parents mix; else the child is its first parent.
    mutations : float
        Expected number of bits that flip in a child.
    elite : int
        How many of the best live on as they are.

    """

    tournament: int = 3
    crossover: float = 0.9
    mutations: float = 1.5
    elite: int = 1


def select_parents(scores: Scores, count: int, tournament: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """
    Choose parents, each the best of some drawn at random.

    Parameters
    ----------
    scores : array of float, shape (individuals,)
        The smaller, the better.
    count : int
        How many parents.
    tournament : int
        How many compete.
    rng : Generator
        Source of chance.

    Returns
    -------
    array of int, shape (count,)
        Their places in the population.

    """
    drawn = rng.integers(len(scores), size=(count, tournament))
    return np.asarray(drawn[np.arange(count), np.argmin(scores[drawn], axis=1)])


def breed(population: Bits, scores: Scores, settings: GeneticSettings, rng: np.random.Generator) -> Bits:
    """
    Make the next generation: tournament selection, uniform crossover, bit mutation, elitism.

    Implements the algorithm that section 3.1 of the chapter names.

    Parameters
    ----------
    population : array of bool, shape (individuals, bits)
        The present one.
    scores : array of float, shape (individuals,)
        Its scores; the smaller, the better.
    settings : GeneticSettings
        Of the algorithm.
    rng : Generator
        Source of chance.

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


def search(score: Score, genes: int, population: int, seed: int, settings: GeneticSettings | None = None) -> None:
    """
    Search the unit cube until the scoring ends it.

    Parameters
    ----------
    score : callable
        Scores the points of a generation, shape (population, genes); ends the search by raising.
    genes, population : int
        Dimensions, and individuals of a generation.
    seed : int
        The same seed, the same search.
    settings : GeneticSettings or None
        Of the algorithm; the default ones if None.

    """
    rng = np.random.default_rng(seed)
    bits = chromosome.random(population, genes, rng)
    while True:
        bits = breed(bits, score(chromosome.points(bits)), settings or GeneticSettings(), rng)
