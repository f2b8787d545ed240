"""A search in stages: bounds are widened where the best gains end at them, and other seeds confirm the result."""

import math
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.search.genetic import LOWEST_POINT, WORST, Points
from mobile_robot_control.search.journal import Journal
from mobile_robot_control.search.objective import Objective
from mobile_robot_control.search.search import Generation, SearchResult, SearchSettings, run_search
from mobile_robot_control.search.space import Gene, at_the_edge, numbers_at, point_of, widened

AGREE = 0.02
"""Largest share by which the objectives of two searches that agree differ."""
WIDENINGS, REPEATS = 7, 2
"""Searches in wider bounds, at most, and searches with other seeds in the last ones."""


class StagePlan(NamedTuple):
    """
    Searches after the first one.

    Attributes
    ----------
    widenings : int
        Largest number of searches in wider bounds, each from the best gains before.
    repeats : int
        Number of searches with other seeds, in the last bounds.
    fixed : set of str
        Genes whose bounds stay.
    start : tuple of float
        Gains from which the first search begins, beside those drawn; none if empty.
    """

    widenings: int = 0
    repeats: int = 0
    fixed: frozenset[str] = frozenset()
    start: tuple[float, ...] = ()

    @property
    def searches(self) -> int:
        """The largest number of searches."""
        return 1 + self.widenings + self.repeats


class Staged(NamedTuple):
    """
    The result of a search in stages.

    Attributes
    ----------
    result : SearchResult
        The best point of all searches, and their history.
    genes : tuple of Gene
        With the last bounds, in which the point lies.
    is_complete : bool
        Whether all searches were done.
    gained : float or None
        Share by which the last widening lowered the objective.
    repeated : tuple of float
        Best scores of the searches with other seeds.
    """

    result: SearchResult
    genes: tuple[Gene, ...]
    is_complete: bool = False
    gained: float | None = None
    repeated: tuple[float, ...] = ()

    @property
    def agreeing(self) -> int:
        """The number of searches with other seeds that end within 2 % of the best one."""
        return len([score for score in self.repeated if score <= (1.0 + AGREE) * self.result.score])

    @property
    def confirmation(self) -> str:
        """How the searches with other seeds ended, as a sentence; '' if there were none."""
        if not self.repeated:
            return ''
        count, above = len(self.repeated), 100.0 * (max(self.repeated) / self.result.score - 1.0)
        if self.agreeing == count:
            return f'converged: {count} searches with other seeds end within {max(above, 0.01):.2g} % of that'
        return (f'not converged: of {count} searches with other seeds, {self.agreeing} end within {100 * AGREE:g} % of '
                f'that, the worst {above:.3g} % above it; more --generations may find better gains')

    @property
    def edges(self) -> list[str]:
        """Gains at an edge of the last bounds, as texts."""
        if self.result.point is None:
            return []
        told = '' if self.gained is None else (
            f'; the last doubling lowered the objective by {100.0 * self.gained:.2g} %')
        return [f'{edge}{told}' for edge in at_the_edge(self.genes, self.result.point.tolist())]


def search_in_stages(
    settings: SearchSettings, plan: StagePlan, genes: tuple[Gene, ...],
    objective_of: Callable[[tuple[Gene, ...]], Objective], journal: Journal | None = None,
    progress: Callable[[Generation], object] = lambda _: None, stopped: Callable[[], bool] = lambda: False,
) -> Staged:
    """
    Search, in wider bounds where the best gains end at an edge, then with other seeds in the last bounds.

    Parameters
    ----------
    settings : SearchSettings
        Of each search; the first one has their seed.
    plan : StagePlan
        The searches after the first one.
    genes : tuple of Gene
        With the first bounds.
    objective_of : callable
        Returns the objective of genes.
    journal, progress, stopped
        As of `run_search`.

    Raises
    ------
    OSError
        If the journal cannot be written; its attribute ``result`` is the result so far.
    """
    stages = _Stages(settings, plan, objective_of, journal, progress, stopped)
    best, gained = Staged(SearchResult(None, math.inf, ()), genes), None
    start = plan.start
    for stage in range(1 + plan.widenings):
        before = best.result.score
        best, is_complete = stages.search(best, start)
        if not is_complete or best.result.point is None or not best.result.score < WORST:
            return best._replace(is_complete=is_complete)
        gained = 1.0 - best.result.score / before if stage and before > 0.0 else None
        point = best.result.point.tolist()
        start = numbers_at(best.genes, point)
        wider = widened(best.genes, point, plan.fixed)
        best = best._replace(gained=gained)
        if stage == plan.widenings or wider == best.genes:
            break
        best = best._replace(genes=wider, result=best.result._replace(point=np.array(point_of(wider, start))))
    for _ in range(plan.repeats):
        best, is_complete = stages.search(best, (), is_repeat=True)
        if not is_complete:
            return best
    return best._replace(is_complete=True)


class _Stages:
    """The searches so far: their number gives the seed of the next one, and their time what is left."""

    def __init__(
        self, settings: SearchSettings, plan: StagePlan, objective_of: Callable[[tuple[Gene, ...]], Objective],
        journal: Journal | None, progress: Callable[[Generation], object], stopped: Callable[[], bool],
    ) -> None:
        self._settings, self._plan, self._objective_of = settings, plan, objective_of
        self._journal, self._progress, self._stopped = journal, progress, stopped
        self._number, self._begun = 0, time.monotonic()

    def search(self, best: Staged, start: Sequence[float], is_repeat: bool = False) -> tuple[Staged, bool]:
        """Search within the bounds of the best result; return the better one, and whether all was searched."""
        settings, objective, before = self._settings, self._objective_of(best.genes), best.result.history
        seed = int(np.random.SeedSequence((settings.seed, self._number)).generate_state(1)[0])
        if settings.seconds > 0.0:
            # none begins after the end
            settings = settings._replace(seconds=max(settings.seconds + self._begun - time.monotonic(), 1e-9))
        if self._number:
            settings = settings._replace(seed=seed)
        self._number += 1

        def begin(points: Points) -> Points:
            begun = objective.begin(points)
            if start:
                begun[0] = np.clip(point_of(best.genes, start), LOWEST_POINT, 1.0)
            return begun

        try:
            latest = run_search(settings, objective, self._journal,
                                lambda one: self._progress(_after(before, one)), self._stopped, begin)
        except OSError as error:
            error.result = best._replace(result=_better(best.result, error.result))  # type: ignore[attr-defined]
            raise
        is_complete = len(latest.history) == settings.generations
        repeated = (*best.repeated, latest.score) if is_repeat and is_complete else best.repeated
        return best._replace(result=_better(best.result, latest), repeated=repeated), is_complete


def _after(before: Sequence[Generation], latest: Generation) -> Generation:
    """Return a generation as one after those of earlier searches."""
    best = min([latest.best, *(last.best for last in before[-1:])])
    return latest._replace(number=len(before) + latest.number, best=best)


def _better(best: SearchResult, other: SearchResult) -> SearchResult:
    """Return the better point of two searches in the same bounds, with the history of both."""
    history = (*best.history, *(_after(best.history, one) for one in other.history))
    chosen = other if other.score < best.score else best
    return SearchResult(chosen.point, chosen.score, history)
