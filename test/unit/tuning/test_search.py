"""Both algorithms: they find known optima, never get worse, and do what their seed says."""

import math
from pathlib import Path

import numpy as np
import pytest

from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.tuning import genetic
from mobile_robot_control.tuning.genetic import GeneticSettings, breed, select_parents
from mobile_robot_control.tuning.journal import Journal
from mobile_robot_control.tuning.search import ALGORITHMS, WORST, SearchSettings, run_search

OPTIMUM = np.linspace(0.2, 0.8, 6)


def bowl(points):
    return ((points - OPTIMUM) ** 2).sum(axis=1)


def settings(algorithm='genetic', generations=60, seed=1, **other):
    return SearchSettings(algorithm, 6, 41, generations, seed, **other)


@pytest.mark.parametrize(('algorithm', 'near'), [('genetic', 0.01), ('differential_evolution', 1e-5)])
def test_the_optimum_of_a_known_function_is_found(algorithm, near):
    for seed in range(2):
        found = run_search(settings(algorithm, 100, seed), bowl)
        assert found.score < near
        assert found.score == bowl(found.point[None])[0]
        assert np.abs(found.point - OPTIMUM).max() < math.sqrt(near)


@pytest.mark.parametrize('algorithm', ALGORITHMS)
def test_the_best_never_worsens_and_every_generation_is_within_the_cube(algorithm):
    seen = []

    def score(points):
        assert points.shape == (41, 6)
        assert (points > 0.0).all()
        assert (points <= 1.0).all()
        seen.append(bowl(points).min())
        return bowl(points)

    found = run_search(settings(algorithm), score)
    best = [generation.best for generation in found.history]
    assert len(best) == len(seen) == 60
    assert best == np.minimum.accumulate(seen).tolist()
    assert found.history[0].mean > found.history[-1].mean


@pytest.mark.parametrize('algorithm', ALGORITHMS)
@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_never_good(algorithm, bad):
    def score(points):
        return np.where(points[:, 0] < 0.5, bad, bowl(points))

    found = run_search(settings(algorithm), score)
    assert found.point[0] >= 0.5
    assert math.isfinite(found.score)
    assert all(math.isfinite(generation.best) for generation in found.history)
    assert found.history[0].lost > 0


def test_nothing_that_can_be_scored_is_said():
    found = run_search(settings(generations=2), lambda points: np.full(len(points), math.nan))
    assert found.score == WORST
    assert math.isnan(found.history[0].mean)
    assert found.history[0].lost == 41


@pytest.mark.parametrize('algorithm', ALGORITHMS)
def test_a_seed_is_a_search(algorithm):
    one, again, other = (run_search(settings(algorithm, 10, seed), bowl) for seed in (1, 1, 2))
    assert (one.score, one.history) == (again.score, again.history)
    assert (one.point == again.point).all()
    assert one.history != other.history


def test_limits_end_a_search():
    assert len(run_search(settings(generations=3), bowl).history) == 3
    assert run_search(settings(seconds=1e-9), bowl).history == ()
    asked = iter([False, False, True])
    stopped = run_search(settings(), bowl, stopped=lambda: next(asked))
    assert len(stopped.history) == 2


def test_a_tournament_chooses_the_best_drawn():
    rng = np.random.default_rng(0)
    scores = np.arange(10.0)
    chosen = select_parents(scores, 20000, 3, rng)
    counts = np.bincount(chosen, minlength=10) / 20000
    # the best of three draws is k with probability ((10-k)^3 - (9-k)^3) / 1000
    expected = [((10 - k) ** 3 - (9 - k) ** 3) / 1000 for k in range(10)]
    assert np.abs(counts - expected).max() < 0.015


def test_children_mix_their_parents_bits():
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


def test_mutations_flip_as_many_bits_as_asked():
    rng = np.random.default_rng(0)
    population = np.zeros((500, 96), dtype=bool)
    mutated = breed(population, np.zeros(500), GeneticSettings(mutations=2.0), rng)
    assert mutated[1:].sum(axis=1).mean() == pytest.approx(2.0, abs=0.25)


def test_the_elite_lives_on_as_it_is():
    rng = np.random.default_rng(0)
    population = rng.random((30, 96)) < 0.5
    scores = rng.random(30)
    bred = breed(population, scores, GeneticSettings(elite=2), rng)
    assert (bred[:2] == population[np.argsort(scores)[:2]]).all()


def test_the_search_knows_no_robot():
    source = Path(genetic.__file__).read_text(encoding='utf-8')
    imported = [line for line in source.splitlines() if line.startswith(('import', 'from'))]
    assert not [line for line in imported if 'mobile_robot_control' in line and 'tuning' not in line]


PURPOSE = {'seed': 1, 'genes': ['p', 'q']}


class TestJournal:
    def begin(self, file, resume=False, purpose=None):
        return Journal(file, purpose or PURPOSE, resume)

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
    def test_resumed_it_ends_as_undisturbed(self, tmp_path, algorithm):
        whole, _ = self.run(tmp_path / 'whole', 12, algorithm=algorithm)
        _, first = self.run(tmp_path / 'parts', 5, algorithm=algorithm)
        parts, second = self.run(tmp_path / 'parts', 12, resume=True, algorithm=algorithm)
        assert (first, second) == (5, 7)
        assert (parts.score, parts.history) == (whole.score, whole.history)
        assert (tmp_path / 'parts').read_bytes() == (tmp_path / 'whole').read_bytes()

    def test_cut_anywhere_it_ends_as_undisturbed(self, tmp_path):
        whole, _ = self.run(tmp_path / 'whole', 4)
        content = (tmp_path / 'whole').read_bytes()
        for end in range(0, len(content), 97):
            (tmp_path / 'cut').write_bytes(content[:end])
            resumed, _ = self.run(tmp_path / 'cut', 4, resume=True)
            assert resumed.history == whole.history
            assert (tmp_path / 'cut').read_bytes() == content

    def test_a_damaged_one_is_refused_with_its_line(self, tmp_path):
        self.run(tmp_path / 'file', 4)
        content = bytearray((tmp_path / 'file').read_bytes())
        content[content.index(b'\n') + 60] ^= 1
        (tmp_path / 'file').write_bytes(content)
        with pytest.raises(ParameterError, match='line 2 of 5 is damaged'):
            self.begin(tmp_path / 'file', resume=True)
        assert (tmp_path / 'file').read_bytes() == content

    def test_that_of_another_search_is_refused(self, tmp_path):
        self.run(tmp_path / 'file', 2)
        with pytest.raises(ParameterError, match='seed = 1, and now it is 2'):
            self.begin(tmp_path / 'file', resume=True, purpose={**PURPOSE, 'seed': 2})
        journal = self.begin(tmp_path / 'file', resume=True)
        with pytest.raises(ParameterError, match='generation 1 is not the one'):
            run_search(settings(seed=7), bowl, journal)
        journal.close()

    def test_the_same_holds_inside_of_scipy(self, tmp_path):
        self.run(tmp_path / 'file', 2, algorithm='differential_evolution')
        journal = self.begin(tmp_path / 'file', resume=True)
        with pytest.raises(ParameterError, match='generation 1 is not the one'):
            run_search(settings('differential_evolution', seed=7), bowl, journal)
        journal.close()

    def test_without_resuming_it_begins_anew(self, tmp_path):
        self.run(tmp_path / 'file', 4)
        _, scored = self.run(tmp_path / 'file', 4)
        assert scored == 4

    def test_a_full_disk_keeps_what_was_found(self, tmp_path, monkeypatch):
        self.run(tmp_path / 'whole', 3)
        journal = self.begin(tmp_path / 'file')
        written, out = [], journal._out

        class Full:
            """A disk with room for three lines and a half."""

            def write(self, line):
                written.append(line)
                return out.write(line if len(written) <= 3 else line[:len(line) // 2])

            def __getattr__(self, name):
                return getattr(out, name)

        journal._out = Full()
        with pytest.raises(OSError, match='No space left') as full:
            run_search(settings(generations=9), bowl, journal)
        journal.close()
        assert len(full.value.found.history) == 3
        assert full.value.found.point is not None
        assert (tmp_path / 'file').read_bytes() == (tmp_path / 'whole').read_bytes()
