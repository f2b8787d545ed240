"""The page of a search in a real browser: convergence, before and after, what holds; also of one that diverged."""

import math

import pytest
from helpers.measuring import configuration

from mobile_robot_control.analysis.promises import promise
from mobile_robot_control.loop.scenarios import configured_scenario
from mobile_robot_control.runs.metrics import summary
from mobile_robot_control.runs.rollout import recorded
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.run_figures import RUN_FIGURES
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.search.page import convergence, write_search_page
from mobile_robot_control.search.search import Generation
from mobile_robot_control.settings.provenance import provenance

HISTORY = [Generation(1, 8.0, 20.0, 3), Generation(2, 6.5, math.nan, 41), Generation(3, 4.2, 9.0, 0)]
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="4" height="3"/>'


def run(name, law):
    parameters = configuration(position_controller={'controller_type': law})
    measured, samples = recorded(parameters, 0.5)
    return Run(name, collect(samples), (), summary(measured), parameters)


@pytest.fixture(scope='module')
def holds():
    parameters = configuration()
    return promise(parameters, [configured_scenario(parameters)])


def test_the_page_of_a_search_has_convergence_both_loops_and_what_holds(browser, holds, tmp_path):
    file = tmp_path / 'found.html'
    write_search_page(file, 'fuzzy: objective <4.2>', HISTORY, [run('before', 'backstepping'), run('after', 'fuzzy')],
                      holds, 'objective', SVG, provenance('tune fuzzy', None))
    browser.show(file, 360, 'dark')
    assert (browser.errors(), browser.violations(), browser.requests()) == ([], [], [file.as_uri()])
    assert convergence(HISTORY) == {'number': [1, 2, 3], 'best': [8.0, 6.5, 4.2], 'mean': [20.0, None, 9.0],
                                    'lost': [3, 41, 0]}
    assert browser.evaluate('mrc.search.data[2]') == [8.0, 6.5, 4.2]
    assert browser.evaluate('document.querySelector("#search .legend").textContent') == (
        'generation 3: best 4.2, mean 9, 0 not scored')
    assert browser.evaluate('document.querySelectorAll(".live.charted").length') == len(RUN_FIGURES)
    assert browser.evaluate('document.documentElement.scrollWidth') <= 360
    text = browser.evaluate('document.body.innerText')
    for part in ('fuzzy: objective <4.2>', 'position loop', 'Not modelled', 'latency of odometry', 'before', 'after'):
        assert part in text
    assert browser.evaluate(
        '[...document.querySelectorAll(".contents a")].every(one => document.querySelector(one.hash))')
    # on paper the picture is there, and no place without charts
    browser.media('print', 'light')
    assert browser.evaluate('''[...document.querySelectorAll("figure")].filter(one => one.getClientRects().length)
      .map(one => one.id)''') == ['search']


def test_a_search_of_one_generation_whose_loop_did_not_move_before_has_a_page(browser, holds, tmp_path):
    file = tmp_path / 'found.html'
    write_search_page(file, 'fuzzy', [Generation(1, 4.2, math.nan, 8)], [run('after', 'fuzzy')], holds, 'objective',
                      SVG, provenance('tune fuzzy', None))
    browser.show(file, 1280)
    assert browser.errors() == []
    assert 'mean not known' in browser.evaluate('document.querySelector("#search .legend").textContent')


def test_the_page_of_a_search_begins_with_what_it_has_changed(holds, tmp_path):
    file, moved = tmp_path / 'found.html', run('run', 'fuzzy')
    for after, answer in (
            (4.2, 'The search lowered the objective of the configured run by 47.5 %, from 8 to 4.2.'),
            (8.0, 'The search found no better gains than those configured, which stay, with the same objective, 8.'),
            (9.0, 'The search did not lower the objective of the configured run: 8 before, 9 after.')):
        runs = [moved._replace(name=name, metrics={'objective': value})
                for name, value in (('before', 8.0), ('after', after))]
        write_search_page(file, 'fuzzy', HISTORY, runs, holds._replace(spread=(0.009, 0.01, 0.012)), 'objective', SVG,
                          provenance('tune fuzzy', None))
        spread = 'RMS error of the configured run over 3 seeds: 1.00 cm, from 0.90 to 1.20 cm.'
        assert f'<p class="answer">{answer} {spread}</p>' in file.read_text(encoding='utf-8')
