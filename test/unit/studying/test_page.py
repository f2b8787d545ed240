"""The page of a study: which runs are replayed, in a real browser the map, a replay and the distributions."""

import json
import math
import re

import pytest
from helpers.measuring import configuration
from helpers.processes import wait_until

from mobile_robot_control.analysis.promises import promise
from mobile_robot_control.loop.monte_carlo import Judged, ScenarioDistribution, draw_scenarios, judge
from mobile_robot_control.loop.scenarios import scenario_trial
from mobile_robot_control.loop.trial import make_rollout, steps_of
from mobile_robot_control.model.noise import Noise
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.runs.rollout import trial_rollout
from mobile_robot_control.settings.provenance import provenance
from mobile_robot_control.studying.engine import StudiedController
from mobile_robot_control.studying.page import (
    FAILURES,
    MEDIANS,
    Criteria,
    StudiedRuns,
    chosen_runs,
    study_data,
    write_study_page,
)
from mobile_robot_control.studying.study import replayed_runs

SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="4" height="3"/>'
PARAMETERS = configuration(100.0, 50.0, reference_cart={'period': 1.0})
DRAWN = draw_scenarios(ScenarioDistribution(('lemniscate',), (0.1,), within=0.3, noise=Noise((0.01, 0.01, 0.0))), 8, 1)

NEAR = Criteria('near the cart')


def outcome(trial):
    """The measured outcome of a trial in plain Python."""
    curve, placement = CURVES[trial.curve], trial.placement
    roll = make_rollout(steps_of(trial), lambda _, n: (reference_at(curve, n * 20_000_000 / 1e9, placement),),
                        trial.form)
    return roll(trial.state, trial.loop, None, trial.steps, trial.ratio, trial.late)


@pytest.fixture(scope='module')
def runs():
    trials = [scenario_trial(PARAMETERS, scenario, 2.0, 1.5) for scenario in DRAWN]
    judged = [judge(trial, outcome(trial))._replace(success=n != 2) for n, trial in enumerate(trials)]
    studied = StudiedController(DRAWN, judged, promise(PARAMETERS, DRAWN), PARAMETERS)
    replayed = replayed_runs(studied, 2.0, chosen_runs([studied.judged]))
    return StudiedRuns(studied.scenarios, studied.judged, studied.promise, replayed)


def test_a_replayed_run_is_the_one_that_was_judged():
    trial = scenario_trial(PARAMETERS, DRAWN[5], 2.0, 1.5)
    samples, found = list(trial_rollout(trial, PARAMETERS)), outcome(trial)
    assert found.totals.max_position == max(
        math.hypot(sample.truth.error.longitudinal, sample.truth.error.lateral) for sample in samples[:-1])
    assert samples[-1].truth.pose == found.final_pose


def test_failures_and_medians_are_replayed():
    judged = [Judged(n % 4 != 0, {'late_max_position_error': float(n)}) for n in range(101)]
    chosen = chosen_runs([judged])
    assert chosen[:FAILURES] == list(range(0, 4 * FAILURES, 4))
    assert sorted(chosen[FAILURES:]) == [49, 50, 51]
    assert len(chosen) == FAILURES + MEDIANS
    assert chosen_runs([judged[1:3]]) == [0, 1]
    # of several controllers the same runs: where any one fails, and where all succeed
    others = [Judged(n != 1, {'late_max_position_error': 0.0}) for n in range(60)]
    assert chosen_runs([judged, others])[:3] == [0, 1, 4]
    assert not {0, 1, 4} & set(chosen_runs([judged, others])[FAILURES:])


def test_the_numbers_of_a_study_can_be_written_where_a_run_diverged(runs):
    metrics = dict.fromkeys(runs.judged[0].metrics, math.inf) | {'energy': math.nan}
    data = study_data({'law': runs._replace(judged=[Judged(False, metrics), *runs.judged[1:5]])}, NEAR)
    (found,) = data['controllers']
    assert found['count'] == 5
    assert found['distributions']['energy']['of'] == 5
    assert len(found['distributions']['energy']['values']) == 4
    assert json.dumps(data, allow_nan=False)


@pytest.fixture(scope='module')
def written(runs, tmp_path_factory):
    file = tmp_path_factory.mktemp('study') / 'study.html'
    others = runs._replace(judged=runs.judged[:4])
    made = provenance('study <x>', dict.fromkeys(('<b>law</b>', 'other'), configuration()))
    write_study_page(file, {'<b>law</b>': runs, 'other': others}, NEAR, SVG, made, interrupted=True)
    return file


def test_the_page_of_a_study_fits_and_asks_for_nothing(browser, written):
    browser.show(written, 360, 'dark')
    assert (browser.errors(), browser.violations(), browser.requests()) == ([], [], [written.as_uri()])
    assert browser.evaluate('document.documentElement.scrollWidth') <= 360
    assert browser.evaluate('document.querySelectorAll(".starts canvas").length') == 2
    assert browser.evaluate('document.querySelectorAll("#distributions .uplot").length') == 7
    text = browser.evaluate('document.body.innerText')
    for part in ('<b>law</b>: 87.50 % of 8 runs succeed', 'near the cart', 'was interrupted', 'Not modelled',
                 '1 of 8 fails', 'run 3: curve', 'compared in the same',
                 'replays, with the distance of the start and position error'):
        assert part in text
    # the replays differ by what their names say
    replays = browser.evaluate('[...document.querySelector(".starts").querySelectorAll("button")].map('
                               'one => one.textContent)')
    assert len(replays) == 1 + MEDIANS
    assert all(re.fullmatch(r'(median|failure) \d+: \S+ m, \S+ m?m', name) for name in replays)
    browser.media('print', 'light')
    assert browser.evaluate('''[...document.querySelectorAll("figure")].filter(one => one.getClientRects().length)
      .map(one => one.id)''') == ['starts']


def test_the_pointer_names_a_run_and_a_click_replays_a_failure(browser, written):
    browser.show(written, 1280)
    evaluate = browser.evaluate
    x, y = evaluate('''(() => { const canvas = document.querySelector(".starts canvas");
      canvas.scrollIntoView({block: "center"});
      const box = canvas.getBoundingClientRect(), every = mrc.study.data.controllers;
      const reach = 1.12 * Math.max(...every.flatMap(one => [...one.columns.x, ...one.columns.y].map(Math.abs)));
      const place = (value) => box.width / 2 * (1 + value / reach);
      return [box.left + place(every[0].columns.x[2]), box.top + place(-every[0].columns.y[2])]; })()''')
    browser.call('Input.dispatchMouseEvent', type='mouseMoved', x=x, y=y)
    note = 'document.querySelector(".starts p").textContent'
    wait_until(lambda: 'run 3: failure' in evaluate(note), 30.0, 0.02)
    for kind in ('mousePressed', 'mouseReleased'):
        browser.call('Input.dispatchMouseEvent', type=kind, x=x, y=y, button='left', clickCount=1)
    wait_until(lambda: evaluate('mrc.clock && mrc.clock.time > 0.05'), 20.0, 0.02)
    assert evaluate('document.querySelector("#replay h3").textContent') == '<b>law</b>, run 3, failure'
    # and by its button another one, in place of the first
    evaluate('document.querySelectorAll(".starts .legend button")[1].click()')
    assert evaluate('document.querySelectorAll("#replay canvas").length') == 1
    assert browser.errors() == []


def test_the_table_is_sorted_by_its_heads(browser, written, runs):
    browser.show(written, 1280)
    evaluate = browser.evaluate
    rows = '[...document.querySelectorAll("#run-table tbody tr")].map(row => row.children[0].textContent)'
    assert evaluate(rows) == [str(n) for n in range(1, 9)]
    order = sorted(range(8), key=lambda n: runs.judged[n].metrics['late_max_position_error'])
    for expected, direction in ((order, 'ascending'), (order[::-1], 'descending')):
        evaluate('document.querySelectorAll("#run-table th button")[5].click()')
        assert evaluate(rows) == [str(n + 1) for n in expected]
        assert evaluate('document.querySelectorAll("#run-table th")[5].ariaSort') == direction
    evaluate('document.querySelectorAll("#run-table td button")[1].click()')
    assert evaluate('document.querySelector("#run-table .command").textContent') == (
        f'study <x> --only {order[-2] + 1}')
    evaluate('((choice) => { choice.value = "1"; choice.dispatchEvent(new Event("change")); })'
             '(document.querySelector("#run-table select"))')
    assert len(evaluate(rows)) == 4
    assert browser.errors() == []
