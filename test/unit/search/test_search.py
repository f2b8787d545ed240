"""All algorithms: they find known optima, the best score never rises, and the seed determines the search."""

import itertools
import math

import numpy as np
import pytest

from mobile_robot_control.search import nelder_mead
from mobile_robot_control.search.genetic import GeneticSettings, breed, select_parents
from mobile_robot_control.search.search import ALGORITHMS, WORST, SearchSettings, run_search

OPTIMUM = np.linspace(0.2, 0.8, 6)


def bowl(points):
    return ((points - OPTIMUM) ** 2).sum(axis=1)


def settings(algorithm='genetic', generations=60, seed=1, **other):
    return SearchSettings(algorithm, 6, 41, generations, seed, **other)


@pytest.mark.parametrize(('algorithm', 'near'), [
    ('genetic', 0.01), ('differential_evolution', 1e-5), ('nelder_mead', 1e-12)])
def test_the_search_finds_the_optimum_of_a_quadratic_and_the_best_score_never_rises(algorithm, near):
    scored = []

    def score(points):
        assert points.shape[1] == 6
        assert (points > 0.0).all()
        assert (points <= 1.0).all()
        scored.extend(bowl(points).tolist())
        return bowl(points)

    one, other = (run_search(settings(algorithm, 100, seed), score) for seed in (1, 2))
    for found, own in ((one, scored[:4100]), (other, scored[4100:])):
        assert found.score == bowl(found.point[None])[0] < near
        assert np.abs(found.point - OPTIMUM).max() < math.sqrt(near)
        assert [generation.best for generation in found.history] == np.minimum.accumulate(own)[40::41].tolist()
        assert found.history[0].mean > found.history[-1].mean
    again = run_search(settings(algorithm, 100, 1), bowl)
    assert (one.score, one.history, one.point.tolist()) == (again.score, again.history, again.point.tolist())
    assert one.history != other.history


@pytest.mark.parametrize('algorithm', ALGORITHMS)
def test_a_score_that_is_not_finite_is_never_the_best(algorithm):
    bad = itertools.cycle((math.nan, math.inf, -math.inf))
    found = run_search(settings(algorithm), lambda points: np.where(points[:, 0] < 0.5, next(bad), bowl(points)))
    assert found.point[0] >= 0.5
    assert all(math.isfinite(best) for best in (found.score, *(generation.best for generation in found.history)))
    assert found.history[0].lost > 0
    found = run_search(settings(algorithm, 2), lambda points: np.full(len(points), math.nan))
    assert (found.score, found.history[0].lost) == (WORST, 41)
    assert math.isnan(found.history[0].mean)


@pytest.mark.parametrize('algorithm', ALGORITHMS)
def test_a_search_begins_with_the_points_that_it_is_given(algorithm):
    begun = []
    run_search(settings(algorithm, 1), lambda points: begun.append(points.copy()) or bowl(points),
               begin=lambda drawn: np.where(drawn > 0.5, 0.25, drawn))
    assert begun[0].max() <= 0.5
    assert np.count_nonzero(begun[0] == 0.25) > 50


def test_differential_evolution_draws_again_until_a_point_has_a_score():
    # one draw of 300 has one
    found = run_search(settings('differential_evolution', 60), lambda points: np.where(
        points[:, 0] < 0.003, bowl(points), math.nan))
    lost = [generation.lost for generation in found.history]
    assert lost[0] == 41
    assert min(lost) < 41
    assert found.score < WORST


def test_a_simplex_moves_by_hand_computed_steps():
    assert nelder_mead.factors(2) == nelder_mead.factors(1) == (1.0, 2.0, 0.5, 0.5)
    assert nelder_mead.factors(8) == (1.0, 1.25, 0.6875, 0.875)

    def asked(score, count):
        """Return the first points that a search from (0.5, 0.5) asks for."""
        points = []

        def scored(some):
            points.extend(map(tuple, np.round(some, 12).tolist()))
            if len(points) >= count:
                raise StopIteration
            return score(some)

        with pytest.raises(StopIteration):
            nelder_mead.improve(scored, nelder_mead.Vertex(0.0, (0.5, 0.5)))
        return points

    # the first simplex; twice a reflection with an expansion, and a reflection
    assert asked(lambda points: points[:, 0] + 2.0 * points[:, 1] - 1.5, 7) == [
        (0.45, 0.5), (0.5, 0.45), (0.45, 0.45), (0.425, 0.425), (0.475, 0.375), (0.4875, 0.3125), (0.4125, 0.2875)]
    # nothing is better: a reflection, a contraction inside, a shrinkage
    assert asked(lambda points: np.ones(len(points)), 6) == [
        (0.45, 0.5), (0.5, 0.45), (0.45, 0.55), (0.4875, 0.475), (0.475, 0.5), (0.5, 0.475)]


def test_a_simplex_stays_in_the_cube_and_finds_a_corner():
    found = run_search(settings('nelder_mead', 40), lambda points: -points.min(axis=1))
    assert found.score == pytest.approx(-1.0, abs=1e-3)
    assert found.point.max() <= 1.0


def test_generations_seconds_and_stopped_end_a_search():
    assert len(run_search(settings(generations=3), bowl).history) == 3
    assert run_search(settings(seconds=1e-9), bowl).history == ()
    answers = iter([False, False, True])
    assert len(run_search(settings(), bowl, stopped=lambda: next(answers)).history) == 2


def test_a_tournament_selects_the_best_of_those_drawn():
    chosen = select_parents(np.arange(10.0), 20000, 3, np.random.default_rng(0))
    # the best of three draws is k with probability ((10-k)^3 - (9-k)^3) / 1000
    expected = [((10 - k) ** 3 - (9 - k) ** 3) / 1000 for k in range(10)]
    assert np.abs(np.bincount(chosen, minlength=10) / 20000 - expected).max() < 0.015


def test_crossover_takes_each_bit_from_either_parent():
    rng = np.random.default_rng(0)
    population = np.array([[True] * 400, [False] * 400] * 50)
    mixed = breed(population, np.zeros(100), GeneticSettings(crossover=1.0, mutations=0.0), rng)
    share = mixed[1:].mean(axis=1)
    between = share[(share > 0.0) & (share < 1.0)]
    # half of all pairs differ, and each takes each bit from either with equal probability
    assert 25 < len(between) < 75
    assert abs(between.mean() - 0.5) < 0.03
    cloned = breed(population, np.zeros(100), GeneticSettings(crossover=0.0, mutations=0.0), rng)
    assert set(cloned.mean(axis=1)) <= {0.0, 1.0}


def test_mutation_flips_the_expected_number_of_bits_and_the_elite_is_kept_unchanged():
    rng = np.random.default_rng(0)
    mutated = breed(np.zeros((500, 96), dtype=bool), np.zeros(500), GeneticSettings(mutations=2.0), rng)
    assert mutated[1:].sum(axis=1).mean() == pytest.approx(2.0, abs=0.25)
    population, scores = rng.random((30, 96)) < 0.5, rng.random(30)
    bred = breed(population, scores, GeneticSettings(elite=2), rng)
    assert (bred[:2] == population[np.argsort(scores)[:2]]).all()
