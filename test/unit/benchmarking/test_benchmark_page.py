"""The page of a benchmark in a real browser: it sorts, shows every law, and fits phone and desktop."""

from mobile_robot_control.benchmarking.page import answer, write_benchmark_page

NUMBERS = {'rms': 0.01, 'rms_95': 0.02, 'worst': 0.2, 'settling_time': 1.0, 'peak_wheel_torque': 3.0, 'energy': 20.0,
           'torque_variation': 40.0, 'command_variation': 4.0, 'fed_rms': 0.005, 'step_time': 1e-6}
ROW = {'track': 'noise', 'seed': 1, 'budget': 500, 'runs': 10, 'successes': 10, 'success_interval': [0.72, 1.0],
       'shared': 9, 'reason': '', 'score': 4.0, 'fed_successes': 10, 'gains': {'position_controller.lqr.q1': 1.5}}
VALUES = {
    'hash': 'abcd', 'laws': ['lqr', 'fuzzy', 'rare', 'unknown', 'broken'], 'seeds': [1], 'budgets': [500],
    'scenarios': 8, 'runs': 10,
    'tracks': {'noise': {'purpose': 'Sensors are noisy & loud.', 'source': 'A book', 'published': [
        {'law': 'lqr', 'gains': {'q1': 2.0}, 'published': {'iae': 0.1}, 'ours': {'iae': 0.1}}]}},
    'results': [
        ROW | NUMBERS | {'law': 'lqr', 'rank': 1, 'last_rank': 1},
        ROW | NUMBERS | {'law': 'fuzzy', 'rank': 2, 'last_rank': 2, 'rms': 0.2, 'successes': 9},
        ROW | dict.fromkeys(NUMBERS) | {'law': 'rare', 'rank': 1, 'last_rank': 3, 'successes': 2,
                                        'success_interval': [0.06, 0.5]},
        ROW | dict.fromkeys(NUMBERS) | {'law': 'unknown', 'rank': None, 'last_rank': None, 'successes': 0, 'runs': 0,
                                        'reason': 'not searched: no individual', 'success_interval': None},
        ROW | dict.fromkeys(NUMBERS) | {'law': 'broken', 'rank': 3, 'last_rank': 3, 'successes': 0, 'runs': 0,
                                        'reason': 'at t = 0 s: <b>no answer</b>', 'success_interval': None}],
}
DRAWN = {'time': [0.0, 1.0, 2.0], 'x': [0.0, 1.0, 1.0], 'y': [0.0, 0.0, 1.0], 'reference_x': [0.0, 1.0, 1.0],
         'reference_y': [0.0, 0.1, 1.0], 'error': [0.0, 0.1, 0.0]}
LAWS = '[...document.querySelectorAll("#numbers tbody tr")].map(row => row.cells[0].textContent)'
PRESS = '[...document.querySelectorAll("#numbers th button")].find(one => one.textContent.startsWith("RMS")).click()'


def test_it_sorts_fits_answers_in_a_sentence_and_shows_a_reason_as_text(browser, tmp_path):
    file = tmp_path / 'benchmark.html'
    write_benchmark_page(file, VALUES, {'noise': {'lqr': DRAWN, 'fuzzy': DRAWN, 'broken': None}},
                         {'command_line': 'benchmark', 'versions': {}})
    for width, scheme in ((1280, 'light'), (390, 'dark')):
        browser.show(file, width, scheme)
        assert browser.evaluate('document.documentElement.scrollWidth <= innerWidth')
        assert browser.violations() == []
        assert browser.evaluate('document.querySelectorAll(".multiples figure").length') == 2
    assert browser.evaluate(LAWS) == ['lqr', 'fuzzy', 'rare', 'unknown', 'broken']
    assert browser.evaluate('[...document.querySelectorAll(".best")].map(one => one.textContent)') == ['1']
    # what is not known stays last
    rest = ['rare', 'unknown', 'broken']
    for order in (['lqr', 'fuzzy', *rest], ['fuzzy', 'lqr', *rest]):
        browser.evaluate(PRESS)
        assert browser.evaluate(LAWS) == order
    assert browser.errors() == []
    text = file.read_text()
    assert answer(VALUES) == ('lqr has the best mean rank, 1.0, of 5 laws; on 1 of 1 tracks no law is better for '
                              'certain.')
    assert answer(VALUES) in text
    assert '<b>no answer</b>' not in text
    assert '&lt;b&gt;no answer' in text
