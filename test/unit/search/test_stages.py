"""A search in stages: it leaves bounds that it has reached, other seeds confirm it, and it can be resumed anywhere."""

import math

import numpy as np
import pytest

from mobile_robot_control.search.journal import Journal
from mobile_robot_control.search.search import SearchResult, SearchSettings
from mobile_robot_control.search.space import numbers_at, search_genes
from mobile_robot_control.search.stages import Staged, StagePlan, search_in_stages

# p of 0 to 5 and q of 0 to 2
GENES = search_genes('backstepping')[:2]
BEST = 30.0, 0.5
SETTINGS = SearchSettings('nelder_mead', 2, 10, 12, 1)


class Objective:
    """Scores numbers by a function of two, in place of rollouts."""

    def __init__(self, genes, of=lambda p, q: 1.0 + (p - BEST[0]) ** 2 + (q - BEST[1]) ** 2):
        self._genes, self._of = genes, of

    def __call__(self, points):
        return np.array([self._of(*numbers_at(self._genes, point)) for point in points])

    @staticmethod
    def begin(points):
        return points


def test_bounds_are_doubled_until_no_gain_ends_at_one_and_other_seeds_confirm_the_result():
    numbers, shown = [], []
    found = search_in_stages(SETTINGS, StagePlan(7, 2), GENES, lambda genes: numbers.append(genes[0].high) or Objective(
        genes), progress=shown.append)
    assert numbers == [5.0, 10.0, 20.0, 40.0, 40.0, 40.0]
    assert found.is_complete
    assert found.result.score == pytest.approx(1.0)
    assert numbers_at(found.genes, found.result.point) == pytest.approx(BEST, abs=1e-3)
    assert (found.agreeing, len(found.repeated), found.edges) == (2, 2, [])
    assert found.confirmation.startswith('converged: 2 searches with other seeds end within ')
    assert list(found.result.history) == shown
    assert [one.number for one in shown] == list(range(1, 6 * 12 + 1))
    assert [one.best for one in shown] == sorted((one.best for one in shown), reverse=True)


def test_a_gain_at_an_edge_after_seven_doublings_is_told_with_the_effect_of_the_last():
    found = search_in_stages(SETTINGS, StagePlan(7, 0), GENES,
                             lambda genes: Objective(genes, lambda p, q: 1.0 + 1.0 / p))
    assert found.genes[0].high == 5.0 * 2**7
    # from 1 + 1 / 320 to 1 + 1 / 640
    edge, *others = found.edges
    assert edge == ('position_controller.backstepping.p is at the upper edge of its search, 0 to 640; the last '
                    'doubling lowered the objective by 0.16 %')
    assert not any('.p ' in other for other in others)


def test_bounds_asked_for_stay_and_a_search_begins_from_the_gains_that_it_is_given():
    begun = []

    def objective(genes):
        inner = Objective(genes)
        return type('Seen', (), {'begin': staticmethod(lambda points: points), '__call__': lambda _, points: (
            begun.append(numbers_at(genes, points[0])) or inner(points))})()

    found = search_in_stages(SETTINGS, StagePlan(7, 1, frozenset({GENES[0].name}), (4.0, 1.5)), GENES, objective)
    assert found.genes[0] == GENES[0]
    assert begun[0] == pytest.approx((4.0, 1.5))
    assert 'upper edge of its search, 0 to 5' in found.edges[0]


def test_a_search_is_converged_if_other_seeds_end_within_2_percent():
    one = Staged(SearchResult(np.array([0.5, 0.5]), 2.0, ()), GENES, True, None, (2.0, 2.05))
    assert one.agreeing == 1
    assert one.confirmation == ('not converged: of 2 searches with other seeds, 1 end within 2 % of that, the worst '
                                '2.5 % above it; more --generations may find better gains')
    assert one._replace(repeated=(2.03, 2.01)).confirmation == (
        'converged: 2 searches with other seeds end within 1.5 % of that')


def test_interrupted_in_any_stage_and_resumed_it_equals_an_undisturbed_search(tmp_path):
    def run(name, calls=math.inf):
        asked = []
        journal = Journal(tmp_path / name, {'seed': 1}, True)
        found = search_in_stages(SETTINGS, StagePlan(7, 2), GENES, Objective, journal,
                                 stopped=lambda: asked.append(1) or len(asked) > calls)
        journal.close()
        return found, len(asked)

    whole, calls = run('whole')
    assert whole.is_complete
    for _ in range(calls // 41):
        cut, _ = run('cut', 41)
        assert not cut.is_complete
    resumed, _ = run('cut')
    assert resumed.result.point.tolist() == whole.result.point.tolist()
    assert resumed._replace(result=None) == whole._replace(result=None)
    assert resumed.result.history == whole.result.history
    assert (tmp_path / 'cut').read_bytes() == (tmp_path / 'whole').read_bytes()
