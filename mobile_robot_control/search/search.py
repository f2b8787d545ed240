"""A search with any of the algorithms: limits, journal, history and progress."""

import math
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.search import differential_evolution, genetic, nelder_mead
from mobile_robot_control.search.genetic import WORST, Begin, Points, Score, Scores
from mobile_robot_control.search.journal import Journal

ALGORITHMS = {'nelder_mead': nelder_mead.search, 'differential_evolution': differential_evolution.search,
              'genetic': genetic.search}


class SearchSettings(NamedTuple):
    """
    Algorithm, sizes, seed and limit of a search.

    Attributes
    ----------
    algorithm : str
        Of ALGORITHMS.
    genes, population, generations : int
        Dimensions, individuals of a generation, and the number of generations.
    seed : int
        Of all random numbers.
    seconds : float
        Wall time after which no generation begins [s]; 0 means no limit.
    """

    algorithm: str
    genes: int
    population: int
    generations: int
    seed: int
    seconds: float = 0.0


class Generation(NamedTuple):
    """
    A summary of the scores of a generation.

    Attributes
    ----------
    number : int
        From 1 on.
    best : float
        Smallest score of all generations so far.
    mean : float
        Over the individuals of this generation with a score; NaN if there is none.
    lost : int
        Number of individuals without a score.
    """

    number: int
    best: float
    mean: float
    lost: int


class SearchResult(NamedTuple):
    """
    The result of a search.

    Attributes
    ----------
    point : array of float or None
        The best point; None if no generation was scored.
    score : float
        Of the best point; infinite if there is none.
    history : tuple of Generation
        In order.
    """

    point: Points | None
    score: float
    history: tuple[Generation, ...]


class _Ended(Exception):  # noqa: N818 (not an error: the end of a search)
    """Ends the algorithm: no further generation is scored."""


def run_search(
    settings: SearchSettings,
    score: Score,
    journal: Journal | None = None,
    progress: Callable[[Generation], object] = lambda _: None,
    stopped: Callable[[], bool] = lambda: False,
    begin: Begin = lambda drawn: drawn,
) -> SearchResult:
    """
    Search the unit cube for the point with the smallest score.

    Parameters
    ----------
    settings : SearchSettings
        Algorithm, sizes, seed and limit.
    score : callable
        Scores the points of a generation, shape (population, genes).
    journal : Journal or None
        Replays the scores of a resumed search, and stores the new ones.
    progress : callable
        Called with every generation.
    stopped : callable
        Called before every generation; the search ends if it returns True.
    begin : callable
        Moves the points that are drawn at the start, shape (population, genes).

    Returns
    -------
    SearchResult
        The best point and the history.

    Raises
    ------
    OSError
        If the journal cannot be written; its attribute ``result`` is the result so far.
    """
    best: tuple[float, Points | None] = (np.inf, None)
    history: list[Generation] = []
    pending: list[float] = []
    left = settings.population * settings.generations
    begun = time.monotonic()

    def score_next(points: Points) -> Scores:
        nonlocal best, left, pending
        points = points[:left]
        scores = journal.replay(points) if journal else None
        if scores is None:
            if 0.0 < settings.seconds <= time.monotonic() - begun or stopped():
                raise _Ended
            scores = _clean(score(points))
            if journal:
                journal.add(points, scores, len(pending) + len(scores) >= settings.population)
        left -= len(scores)
        first = int(np.argmin(scores))
        if scores[first] < best[0]:
            best = float(scores[first]), points[first].copy()
        pending += scores.tolist()
        if len(pending) >= settings.population:
            history.append(_generation(history, pending[:settings.population]))
            pending = pending[settings.population:]
            progress(history[-1])
        if not left:
            raise _Ended
        return scores

    try:
        ALGORITHMS[settings.algorithm](score_next, settings.genes, settings.population, settings.generations,
                                       settings.seed, begin)
    except _Ended:
        pass
    except KeyboardInterrupt:
        # of a generation that takes long: the ones before it count
        if not stopped():
            raise
    except OSError as error:
        error.result = SearchResult(best[1], best[0], tuple(history))  # type: ignore[attr-defined]
        raise
    return SearchResult(best[1], best[0], tuple(history))


def _generation(history: Sequence[Generation], scores: Sequence[float]) -> Generation:
    """Return the summary of the next generation."""
    good = [score for score in scores if score < WORST]
    return Generation(len(history) + 1, min([*scores, *(one.best for one in history[-1:])]),
                      math.fsum(good) / len(good) if good else math.nan, len(scores) - len(good))


def _clean(scores: Scores) -> Scores:
    """Return the scores with WORST in place of non-finite and larger ones."""
    return np.where(np.isfinite(scores), np.minimum(scores, WORST), WORST)


def no_result(result: SearchResult) -> str:
    """Explain why a completed search has found nothing; '' if it has."""
    if result.point is None:
        return 'the time limit is too short for one generation'
    return '' if result.score < WORST else (
        'no individual could be scored: all are unstable or diverge; give tighter --bounds or raise the rates')
