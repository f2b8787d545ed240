"""Both algorithms: they find known optima, the best score never rises, and the seed determines the search."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.tuning.genetic import GeneticSettings, breed, select_parents
from mobile_robot_control.tuning.journal import Journal
from mobile_robot_control.tuning.search import ALGORITHMS, WORST, SearchSettings, run_search

OPTIMUM = np.linspace(0.2, 0.8, 6)


def bowl(points):
    return ((points - OPTIMUM) ** 2).sum(axis=1)


def settings(algorithm='genetic', generations=60, seed=1, **other):
    return SearchSettings(algorithm, 6, 41, generations, seed, **other)


@pytest.mark.parametrize(('algorithm', 'near'), [('genetic', 0.01), ('differential_evolution', 1e-5)])
def test_the_search_finds_the_optimum_of_a_quadratic(algorithm, near):
    for seed in range(2):
        found = run_search(settings(algorithm, 100, seed), bowl)
        assert found.score < near
        assert found.score == bowl(found.point[None])[0]
        assert np.abs(found.point - OPTIMUM).max() < math.sqrt(near)


@pytest.mark.parametrize('algorithm', ALGORITHMS)
def test_the_best_score_never_rises_and_every_point_is_in_the_unit_cube(algorithm):
    smallest = []

    def score(points):
        assert points.shape == (41, 6)
        assert (points > 0.0).all()
        assert (points <= 1.0).all()
        smallest.append(bowl(points).min())
        return bowl(points)

    found = run_search(settings(algorithm), score)
    best = [generation.best for generation in found.history]
    assert len(best) == len(smallest) == 60
    assert best == np.minimum.accumulate(smallest).tolist()
    assert found.history[0].mean > found.history[-1].mean


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
def test_same_seed_gives_the_same_search(algorithm):
    one, again, other = (run_search(settings(algorithm, 10, seed), bowl) for seed in (1, 1, 2))
    assert (one.score, one.history) == (again.score, again.history)
    assert (one.point == again.point).all()
    assert one.history != other.history


def test_generations_seconds_and_stopped_end_a_search():
    assert len(run_search(settings(generations=3), bowl).history) == 3
    assert run_search(settings(seconds=1e-9), bowl).history == ()
    answers = iter([False, False, True])
    stopped = run_search(settings(), bowl, stopped=lambda: next(answers))
    assert len(stopped.history) == 2


def test_a_tournament_selects_the_best_of_those_drawn():
    rng = np.random.default_rng(0)
    scores = np.arange(10.0)
    chosen = select_parents(scores, 20000, 3, rng)
    counts = np.bincount(chosen, minlength=10) / 20000
    # the best of three draws is k with probability ((10-k)^3 - (9-k)^3) / 1000
    expected = [((10 - k) ** 3 - (9 - k) ** 3) / 1000 for k in range(10)]
    assert np.abs(counts - expected).max() < 0.015


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


def test_mutation_flips_the_expected_number_of_bits():
    rng = np.random.default_rng(0)
    population = np.zeros((500, 96), dtype=bool)
    mutated = breed(population, np.zeros(500), GeneticSettings(mutations=2.0), rng)
    assert mutated[1:].sum(axis=1).mean() == pytest.approx(2.0, abs=0.25)


def test_the_elite_is_kept_unchanged():
    rng = np.random.default_rng(0)
    population = rng.random((30, 96)) < 0.5
    scores = rng.random(30)
    bred = breed(population, scores, GeneticSettings(elite=2), rng)
    assert (bred[:2] == population[np.argsort(scores)[:2]]).all()


SETTINGS = {'seed': 1, 'genes': ['p', 'q']}


class TestJournal:
    def begin(self, file, resume=False, settings=None):
        return Journal(file, settings or SETTINGS, resume)

    def run(self, file, generations, resume=False, algorithm='genetic'):
        scored = []

        def score(points):
            scored.append(len(points))
            return bowl(points)

        journal = self.begin(file, resume)
        try:
            return run_search(settings(algorithm, generations), score, journal), len(scored)
        finally:
            journal.close()

    @pytest.mark.parametrize('algorithm', ALGORITHMS)
    def test_a_resumed_search_equals_an_undisturbed_one(self, tmp_path, algorithm):
        whole, _ = self.run(tmp_path / 'whole', 12, algorithm=algorithm)
        _, first = self.run(tmp_path / 'parts', 5, algorithm=algorithm)
        parts, second = self.run(tmp_path / 'parts', 12, resume=True, algorithm=algorithm)
        assert (first, second) == (5, 7)
        assert (parts.score, parts.history) == (whole.score, whole.history)
        assert (tmp_path / 'parts').read_bytes() == (tmp_path / 'whole').read_bytes()

    def test_a_search_resumed_from_a_journal_cut_anywhere_equals_an_undisturbed_one(self, tmp_path):
        whole, _ = self.run(tmp_path / 'whole', 4)
        content = (tmp_path / 'whole').read_bytes()
        for end in range(0, len(content), 97):
            (tmp_path / 'cut').write_bytes(content[:end])
            resumed, _ = self.run(tmp_path / 'cut', 4, resume=True)
            assert resumed.history == whole.history
            assert (tmp_path / 'cut').read_bytes() == content

    def test_a_damaged_journal_is_refused_with_the_line_number(self, tmp_path):
        self.run(tmp_path / 'file', 4)
        content = bytearray((tmp_path / 'file').read_bytes())
        content[content.index(b'\n') + 60] ^= 1
        (tmp_path / 'file').write_bytes(content)
        with pytest.raises(ParameterError, match='line 2 of 5 is damaged'):
            self.begin(tmp_path / 'file', resume=True)
        assert (tmp_path / 'file').read_bytes() == content


    def test_the_journal_of_another_search_is_refused_and_without_resume_begins_anew(self, tmp_path):
        for algorithm in ALGORITHMS:
            file = tmp_path / algorithm
            self.run(file, 2, algorithm=algorithm)
            with pytest.raises(ParameterError, match='seed = 1, and now it is 2'):
                self.begin(file, resume=True, settings={**SETTINGS, 'seed': 2})
            journal = self.begin(file, resume=True)
            with pytest.raises(ParameterError, match='generation 1 is not the one'):
                run_search(settings(algorithm, seed=7), bowl, journal)
            journal.close()
            assert self.run(file, 2, algorithm=algorithm)[1] == 2

    def test_a_full_disk_keeps_the_result_so_far(self, tmp_path, monkeypatch):
        self.run(tmp_path / 'whole', 3)
        open_file, written = Path.open, []

        class Full:
            """A file on a disk with room for three and a half more lines."""

            def __init__(self, file):
                self.file = file

            def write(self, line):
                written.append(line)
                return self.file.write(line if len(written) <= 3 else line[:len(line) // 2])

            def __getattr__(self, name):
                return getattr(self.file, name)

        def open_full(path, mode='r', *arguments, **options):
            file = open_file(path, mode, *arguments, **options)
            return Full(file) if mode == 'ab' else file

        monkeypatch.setattr(Path, 'open', open_full)
        journal = self.begin(tmp_path / 'file')
        with pytest.raises(OSError, match='No space left') as full:
            run_search(settings(generations=9), bowl, journal)
        journal.close()
        assert len(full.value.found.history) == 3
        assert full.value.found.point is not None
        assert (tmp_path / 'file').read_bytes() == (tmp_path / 'whole').read_bytes()
