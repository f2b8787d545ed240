"""A search from its seed to its best point, whichever the algorithm: limits, journal, history, progress."""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from mobile_robot_control.tuning import differential_evolution, genetic
from mobile_robot_control.tuning.chromosome import Points
from mobile_robot_control.tuning.genetic import Score, Scores
from mobile_robot_control.tuning.journal import Journal

ALGORITHMS = {'genetic': genetic.search, 'differential_evolution': differential_evolution.search}

WORST = 1e9
"""The score of what cannot be scored."""


class SearchSettings(NamedTuple):
    """
    What a search is told.

    Attributes
    ----------
    algorithm : str
        Of ALGORITHMS.
    genes, population, generations : int
        Sizes; each generation is scored as a whole.
    seed : int
        Of all chance.
    seconds : float
        Wall time after which no generation begins; 0 means no limit.

    """

    algorithm: str
    genes: int
    population: int
    generations: int
    seed: int
    seconds: float = 0.0


class Generation(NamedTuple):
    """
    How a generation scored.

    Attributes
    ----------
    number : int
        From 1 on.
    best : float
        Of all so far.
    mean : float
        Of those of this generation that could be scored; NaN where none could.
    lost : int
        How many could not.

    """

    number: int
    best: float
    mean: float
    lost: int


class Found(NamedTuple):
    """
    What a search found.

    Attributes
    ----------
    point : array of float or None
        The best one; None where no generation was scored.
    score : float
        Its score.
    history : tuple of Generation
        One a generation.

    """

    point: Points | None
    score: float
    history: tuple[Generation, ...]


class _Over(Exception):  # noqa: N818 (not an error: the end of a search)
    """No further generation."""


def run_search(
    settings: SearchSettings,
    score: Score,
    journal: Journal | None = None,
    progress: Callable[[Generation], None] = lambda _: None,
    stopped: Callable[[], bool] = lambda: False,
) -> Found:
    """
    Search the unit cube for the point with the smallest score.

    Parameters
    ----------
    settings : SearchSettings
        Algorithm, sizes, seed and limits.
    score : callable
        Scores the points of a generation.
    journal : Journal or None
        Keeps the scores.
    progress : callable
        Told of every generation.
    stopped : callable
        Asked before every generation whether to stop.

    Returns
    -------
    Found
        The best point so far and the history.

    Raises
    ------
    OSError
        If the journal cannot be written; its attribute ``found`` is what was found so far.

    """
    best: tuple[float, Points | None] = (np.inf, None)
    history: list[Generation] = []
    begun = time.monotonic()

    def next_generation(points: Points) -> Scores:
        nonlocal best
        known = journal.recall(points) if journal else None
        if known is None:
            late = 0.0 < settings.seconds <= time.monotonic() - begun
            if len(history) >= settings.generations or late or stopped():
                raise _Over
            scores = _clean(score(points))
            if journal:
                journal.add(points, scores)
        elif len(history) >= settings.generations:
            raise _Over
        else:
            scores = known
        first = int(np.argmin(scores))
        if scores[first] < best[0]:
            best = float(scores[first]), points[first].copy()
        good = scores[scores < WORST]
        mean = float(good.mean()) if len(good) else float('nan')
        history.append(Generation(len(history) + 1, best[0], mean, len(scores) - len(good)))
        progress(history[-1])
        return scores

    try:
        ALGORITHMS[settings.algorithm](next_generation, settings.genes, settings.population, settings.seed)
    except _Over:
        pass
    except OSError as error:
        error.found = Found(best[1], best[0], tuple(history))  # type: ignore[attr-defined]
        raise
    return Found(best[1], best[0], tuple(history))


def _clean(scores: Scores) -> Scores:
    """Make sure that what is not a number never wins."""
    return np.where(np.isfinite(scores), np.minimum(scores, WORST), WORST)
