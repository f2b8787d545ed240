"""The simplex method of Nelder and Mead with factors that depend on the dimension, by Gao and Han (2012)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mobile_robot_control.search import differential_evolution
from mobile_robot_control.search.genetic import LOWEST_POINT, Begin, Score

_EVOLVED = 0.6
"""Share of the generations in which differential evolution chooses the place of the simplex."""
_EDGE = 0.05
"""Length of the edges of the first simplex, towards the inside of the cube."""

Point = tuple[float, ...]


class Vertex(NamedTuple):
    """A point of a simplex, and its score."""

    score: float
    point: Point


class Factors(NamedTuple):
    """Of a reflection, an expansion, a contraction and a shrinkage."""

    reflection: float
    expansion: float
    contraction: float
    shrinkage: float


def factors(genes: int) -> Factors:
    """
    Return the factors for a dimension; for two, those of Nelder and Mead.

    Implements Eq. (4.1) of [1]_.

    References
    ----------
    .. [1] F. Gao and L. Han, "Implementing the Nelder-Mead simplex algorithm with adaptive parameters", Computational
       Optimization and Applications 51, 2012, pp. 259-277.

    """
    # one gene has no other vertex to shrink towards, and the formula no shrinkage
    n = max(genes, 2)
    return Factors(1.0, 1.0 + 2.0 / n, 0.75 - 1.0 / (2.0 * n), 1.0 - 1.0 / n)


def first_simplex(best: Point) -> list[Point]:
    """Return the other vertices of a simplex at a point: one along each axis, towards the inside of the cube."""
    return [(*best[:n], x + (_EDGE if x < 0.5 else -_EDGE), *best[n + 1:]) for n, x in enumerate(best)]


def centroid(vertices: Sequence[Vertex]) -> Point:
    """Return the mean of points, added up in their order."""
    total = [0.0] * len(vertices[0].point)
    for vertex in vertices:
        total = [a + x for a, x in zip(total, vertex.point, strict=True)]
    return tuple(a / len(vertices) for a in total)


def along(start: Point, end: Point, factor: float) -> Point:
    """Return the point at a multiple of the way from one point to another, moved into the cube."""
    return tuple(min(1.0, max(LOWEST_POINT, a + factor * (b - a))) for a, b in zip(start, end, strict=True))


def improve(score: Score, best: Vertex) -> None:
    """Improve a point until `score` ends the search, which gets one point at a time, or those of a whole simplex."""
    def scored(points: Sequence[Point]) -> list[Vertex]:
        return [Vertex(*one) for one in zip(score(np.array(points)).tolist(), points, strict=True)]

    reflection, expansion, contraction, shrinkage = factors(len(best.point))
    simplex = [best, *scored(first_simplex(best.point))]
    while True:
        simplex.sort(key=lambda vertex: vertex.score)
        first, worst = simplex[0], simplex[-1]
        middle = centroid(simplex[:-1])
        reflected, = scored([along(middle, worst.point, -reflection)])
        if reflected.score < first.score:
            # farther in the same direction
            expanded, = scored([along(middle, worst.point, -reflection * expansion)])
            simplex[-1] = min(expanded, reflected, key=lambda vertex: vertex.score)
        elif reflected.score < simplex[-2].score:
            simplex[-1] = reflected
        else:
            # less far, on the better side
            outside = reflected.score < worst.score
            contracted, = scored([along(middle, worst.point, (-reflection if outside else 1.0) * contraction)])
            if contracted.score < min(reflected.score, worst.score):
                simplex[-1] = contracted
            else:
                simplex[1:] = scored([along(first.point, one.point, shrinkage) for one in simplex[1:]])


def search(
    score: Score, genes: int, population: int, generations: int, seed: int, begin: Begin = lambda drawn: drawn,
) -> None:
    """
    Search the unit cube by differential evolution, then by a simplex from its best point, until `score` ends it.

    Arguments as of `genetic.search`.
    """
    points, scores = differential_evolution.evolve(
        score, genes, population, max(1, int(_EVOLVED * generations)), seed, begin)
    first = int(np.argmin(scores))
    improve(score, Vertex(float(scores[first]), tuple(points[first].tolist())))
