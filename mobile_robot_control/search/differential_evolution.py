"""Differential evolution (Storn and Price, 1997): the best point and differences of others make new ones."""

import numpy as np

from mobile_robot_control.search.genetic import LOWEST_POINT, WORST, Begin, Points, Score, Scores

_CROSSOVER = 0.7
"""Probability that a coordinate comes from the new point."""
_LEAST_FACTOR = 0.5
"""Smallest factor of a difference; the largest is 1, and a generation has one of its own."""


def evolve(
    score: Score, genes: int, population: int, generations: int, seed: int, begin: Begin = lambda drawn: drawn,
) -> tuple[Points, Scores]:
    """
    Search the unit cube by the strategy best/1/bin; return the last generation, with its scores.

    A first generation without any score is drawn again. Arguments as of `genetic.search`, with at least three
    individuals.

    References
    ----------
    .. [1] R. Storn and K. Price, "Differential evolution: a simple and efficient heuristic for global optimization
       over continuous spaces", Journal of Global Optimization 11, 1997, pp. 341-359.

    """
    rng = np.random.default_rng(seed)
    width, rows = 1.0 - LOWEST_POINT, np.arange(population)
    while True:
        points = begin(LOWEST_POINT + width * rng.random((population, genes)))
        scores = score(points)
        generations -= 1
        if scores.min() < WORST:
            break
    for _ in range(generations):
        factor = _LEAST_FACTOR + (1.0 - _LEAST_FACTOR) * rng.random()
        # two others of each point, unlike one another
        first = rng.integers(1, population, size=population)
        second = rng.integers(1, population - 1, size=population)
        second += second >= first
        first, second = (rows + first) % population, (rows + second) % population
        trial = points[np.argmin(scores)] + factor * (points[first] - points[second])
        crossed = rng.random((population, genes)) < _CROSSOVER
        crossed[rows, rng.integers(genes, size=population)] = True
        trial = np.where(crossed, trial, points)
        # beyond the cube, anywhere within it
        trial = np.where((trial < LOWEST_POINT) | (trial > 1.0), LOWEST_POINT + width * rng.random(trial.shape), trial)
        trial_scores = score(trial)
        better = trial_scores <= scores
        points, scores = np.where(better[:, None], trial, points), np.where(better, trial_scores, scores)
    return points, scores


def search(
    score: Score, genes: int, population: int, generations: int, seed: int, begin: Begin = lambda drawn: drawn,
) -> None:
    """Search the unit cube until `score` ends the search."""
    evolve(score, genes, population, generations, seed, begin)
