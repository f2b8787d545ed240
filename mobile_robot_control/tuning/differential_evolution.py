"""SciPy's differential evolution over the unit cube, generation by generation as the genetic algorithm."""

import numpy as np

from mobile_robot_control.tuning.chromosome import LOWEST_POINT, Points
from mobile_robot_control.tuning.genetic import Score, Scores

_ENDLESS = 10**9


def search(score: Score, genes: int, population: int, seed: int) -> None:
    """Search the unit cube, with the arguments of `genetic.search`."""
    # slow to import, and not needed for the genetic algorithm
    from scipy.optimize import differential_evolution  # noqa: PLC0415

    def columns(points: Points) -> Scores:
        return score(np.ascontiguousarray(points.T))

    rng = np.random.default_rng(seed)
    start = LOWEST_POINT + (1.0 - LOWEST_POINT) * rng.random((population, genes))
    try:
        differential_evolution(
            columns, [(LOWEST_POINT, 1.0)] * genes, init=start, rng=rng, maxiter=_ENDLESS, tol=0.0, polish=False,
            updating='deferred', vectorized=True,
        )
    except RuntimeError as error:
        # SciPy wraps a ValueError that `score` raises
        raise error.__cause__ or error from None
