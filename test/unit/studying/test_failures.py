"""Where a controller fails: a known reason is found, chance is not taken for one, and failures are listed."""

import json
import math

import pytest

from mobile_robot_control.loop.monte_carlo import Judged, ScenarioDistribution, Scenarios, draw_scenarios
from mobile_robot_control.loop.scenarios import Scenario
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.quantities import Pose
from mobile_robot_control.studying.failures import QUANTITIES, best_split, failure_texts, failure_values

DISTRIBUTION = ScenarioDistribution(('trifolium', 'lemniscate'), (0.5, 1.0), longest_delay=2)
SCENARIOS = draw_scenarios(DISTRIBUTION, 300, 1)


def distance(scenario):
    return math.hypot(scenario.start.x, scenario.start.y)


def runs_of(fails, outcome='completed'):
    return [Judged(not fails(scenario), {}, outcome if fails(scenario) else 'completed') for scenario in SCENARIOS]


@pytest.mark.parametrize(('fails', 'quantity', 'side', 'value'), [
    (lambda one: distance(one) > 0.9, 'start_distance', 'above', 0.9),
    (lambda one: abs(one.start.heading) < 0.5, 'start_heading_error', 'at most', 0.5),
    (lambda one: one.mass > 1.1, 'mass_factor', 'above', 1.1),
    (lambda one: one.friction < 0.85, 'friction_factor', 'at most', 0.85),
    (lambda one: one.delay == 2, 'delay', 'above', 1.0),
    (lambda one: one.scale == 0.5, 'scale', 'at most', 0.5),
    (lambda one: one.curve == 'lemniscate', 'curve', 'is', 'lemniscate'),
])
def test_a_known_reason_of_failures_is_found(fails, quantity, side, value):
    found = best_split(SCENARIOS, runs_of(fails))
    assert (found.quantity, found.side) == (quantity, side)
    assert found.value == value or found.value == pytest.approx(value, rel=0.1)
    assert found.chance < 1e-9
    (there, drawn), (rest, others) = found.there, found.elsewhere
    assert drawn + others == 300
    assert there / drawn > 0.6
    assert rest / others < 0.1


def test_a_split_has_the_numbers_of_the_value_that_is_printed():
    judged = runs_of(lambda one: distance(one) > 0.9)
    found = best_split(SCENARIOS, judged)
    printed = float(found.words.split()[3])
    beyond = [run for scenario, run in zip(SCENARIOS, judged, strict=True) if distance(scenario) > printed]
    assert found.there == (sum(not run.success for run in beyond), len(beyond))
    failures = sum(not run.success for run in judged)
    assert list(failure_texts(SCENARIOS, judged))[:2] == [
        f'{failures} of 300 fail: too far from the reference over the last quarter',
        f'{found.there[0]} of them with start distance above {printed:g} m: {found.there[0]} of {len(beyond)} fail '
        f'there, {found.elsewhere[0]} of {300 - len(beyond)} elsewhere']


def test_chance_is_rarely_taken_for_a_reason():
    """The seeds of the noise tell nothing about anything else."""
    seeds = [scenario.noise.seed for scenario in SCENARIOS]
    found = [best_split(SCENARIOS, runs_of(lambda one, k=k: one.noise.seed in seeds[k:k + 12]))
             for k in range(0, 288, 8)]
    assert sum(split is not None for split in found) <= 2


def test_without_a_reason_the_ranges_are_named():
    seeds = {scenario.noise.seed for scenario in SCENARIOS[100:112]}
    judged = runs_of(lambda one: one.noise.seed in seeds)
    values = failure_values(SCENARIOS, judged)
    assert values['split'] is None
    distances = [distance(scenario) for scenario in SCENARIOS]
    for kind, drawn in (('successes', distances[:100] + distances[112:]), ('failures', distances[100:112])):
        low, high = values['ranges'][kind]['start_distance']
        assert (low, high) == (min(drawn), max(drawn))
    _, line = failure_texts(SCENARIOS, judged)
    assert line.startswith('no single quantity tells them from the others: they have curve lemniscate, trifolium; ')
    assert f'; start distance {low:.3g} to {high:.3g} m; ' in line


def test_a_heading_error_is_at_most_half_a_turn():
    turned = SCENARIOS[0]._replace(start=Pose(0.0, 0.0, 1.5 * math.pi))
    assert QUANTITIES['start_heading_error'].of(Scenarios.of([turned])) == pytest.approx(0.5 * math.pi)
    assert QUANTITIES['start_distance'].of(Scenarios.of([turned._replace(start=None)])) == 0.0


def test_few_failures_are_listed_and_many_are_counted_by_kind():
    scenarios = [Scenario('circle', 1.0, Pose(0.3, 0.4, -1.5), 1.1, 0.9, Noise(seed=7), 2), SCENARIOS[0]]
    judged = [Judged(False, {}, 'diverged'), Judged(True, {})]
    assert list(failure_texts(scenarios, judged)) == [
        '1 of 2 fails: diverged', 'run 1: curve circle, scale 1 m, start distance 0.5 m, start heading error 1.5 rad, '
        'mass factor 1.1, friction factor 0.9, delay 2 velocity periods']
    values = json.loads(json.dumps(failure_values(scenarios, judged)))
    assert values['scenarios'] == [{
        'run': 1, 'outcome': 'diverged', 'curve': 'circle', 'scale': 1.0, 'start_distance': 0.5,
        'start_heading_error': 1.5, 'mass_factor': 1.1, 'friction_factor': 0.9, 'delay': 2, 'noise_seed': 7}]
    judged = [*runs_of(lambda _: False)[:290], *[Judged(False, {}, 'diverged')] * 6,
              *[Judged(False, {}, 'law_failed')] * 3, Judged(False, {})]
    assert next(failure_texts(SCENARIOS, judged)) == (
        '10 of 300 fail: 1 too far from the reference over the last quarter, 6 diverged, '
        '3 with a position law that failed')
    assert failure_values(SCENARIOS, judged)['outcomes'] == {'completed': 1, 'diverged': 6, 'law_failed': 3}
    assert next(failure_texts(SCENARIOS, [*judged[:291], *judged[299:]])) == (
        '2 of 292 fail: 1 too far from the reference over the last quarter, 1 diverged')


def test_where_none_or_all_fail_or_all_are_alike_nothing_is_split():
    judged = runs_of(lambda _: False)
    assert list(failure_texts(SCENARIOS, judged)) == []
    values = failure_values(SCENARIOS, judged)
    assert (values['count'], values['outcomes'], values['split'], values['scenarios']) == (0, {}, None, [])
    assert (values['ranges']['failures']['delay'], values['ranges']['successes']['delay']) == ([], [0, 2])
    judged = runs_of(lambda _: True)
    assert best_split(SCENARIOS, judged) is None
    assert list(failure_texts(SCENARIOS, judged))[1].startswith('curve lemniscate, trifolium; scale 0.5 to 1 m; ')
    assert best_split([SCENARIOS[0]] * 20, [Judged(k > 8, {}) for k in range(20)]) is None
    # an interrupt leaves runs out at the end
    found = best_split(SCENARIOS, runs_of(lambda one: distance(one) > 0.9)[:100])
    assert found.there[1] + found.elsewhere[1] == 100
