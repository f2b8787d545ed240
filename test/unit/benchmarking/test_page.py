"""The page of a benchmark in a real browser: it sorts, shows every law, and fits phone and desktop."""

from mobile_robot_control.benchmarking.cell_result import DrivenPath
from mobile_robot_control.benchmarking.page import answer, write_benchmark_page
from mobile_robot_control.benchmarking.picture import ratios_figure, save_picture

NUMBERS = {'rms': 0.01, 'rms_95': 0.02, 'worst': 0.2, 'settling_time': 1.0, 'peak_wheel_torque': 3.0, 'energy': 20.0,
           'torque_variation': 40.0, 'command_variation': 4.0, 'step_time': 1e-6, 'score': 0.01, 'agreeing': 2,
           'rms_searched': 0.01, 'eq29': 4.0}
ROW = {'track': 'noise', 'gains': 'searched', 'seed': 1, 'budget': 500, 'runs': 10, 'successes': 10,
       'success_interval': [0.72, 1.0], 'reason': '', 'at_edge': [], 'values': {'position_controller.lqr.q1': 1.5}}
FAILED = ROW | dict.fromkeys(NUMBERS) | {'successes': None, 'runs': 0, 'success_interval': None, 'values': {}}
RANK = {'track': 'noise', 'budget': 500, 'seeds': 5, 'success': 1.0, 'rms': 0.01, 'converged': 4, 'at_edge': 1,
        'configured_rms': 0.05, 'configured_success': 1.0, 'feedforward_rms': None, 'feedforward_success': None,
        'reason': ''}
SUMMARY = {'budget': 500, 'place': 1, 'first_place': 1, 'last_place': 2, 'tracks': 1, 'unbeaten': 1, 'comparisons': 3,
           'wins': 2, 'losses': 0, 'largest_ratio': 1.0, 'largest_on': 'noise', 'least_success': 1.0,
           'least_on': 'noise', 'failed': [], 'not_searched': []}
UNKNOWN = {'largest_ratio': None, 'largest_on': None, 'unbeaten': 0, 'wins': 0, 'losses': 1}
VALUES = {
    'hash': 'abcd', 'laws': ['lqr', 'fuzzy', 'rare', 'unknown', 'broken'], 'seeds': [1, 2, 3, 4, 5], 'budgets': [500],
    'scenarios': 8, 'runs': 10, 'restarts': 2,
    'unfinished': [{'law': 'fuzzy', 'track': 'noise', 'seed': 5, 'feedforward': True}],
    'tracks': {'noise': {'purpose': 'Sensors are noisy & loud.', 'source': 'A book', 'group': 'all', 'published': [
        {'law': 'lqr', 'gains': {'q1': 2.0}, 'published': {'iae': 0.1}, 'ours': {'iae': 0.1}}]}},
    'summary': [SUMMARY | {'law': 'lqr'},
                SUMMARY | {'law': 'fuzzy', 'place': 2, 'largest_ratio': 20.0, 'unbeaten': 0, 'wins': 0, 'losses': 1},
                SUMMARY | UNKNOWN | {'law': 'rare', 'place': 3, 'failed': ['noise'], 'least_success': 0.2},
                SUMMARY | UNKNOWN | {'law': 'broken', 'place': 4, 'failed': ['noise'], 'least_success': 0.0},
                SUMMARY | UNKNOWN | {'law': 'unknown', 'place': None, 'first_place': None, 'last_place': None,
                                     'tracks': 0, 'comparisons': 0, 'losses': 0, 'least_success': None,
                                     'least_on': None, 'not_searched': ['noise']}],
    'ranks': [RANK | {'law': 'lqr', 'rank': 1, 'last_rank': 1, 'ratio': 1.0, 'ratio_interval': None, 'rms': 0.01},
              RANK | {'law': 'fuzzy', 'rank': 2, 'last_rank': 3, 'ratio': 20.0, 'ratio_interval': [15.0, 26.0],
                      'rms': 0.2},
              RANK | {'law': 'rare', 'rank': 2, 'last_rank': 3, 'ratio': None, 'ratio_interval': None, 'success': 0.2,
                      'rms': 0.05},
              RANK | {'law': 'broken', 'rank': 4, 'last_rank': 4, 'ratio': None, 'ratio_interval': None,
                      'success': 0.0, 'rms': None},
              RANK | {'law': 'unknown', 'rank': None, 'last_rank': None, 'ratio': None, 'ratio_interval': None,
                      'success': None, 'rms': None}],
    'results': [
        ROW | NUMBERS | {'law': 'lqr'},
        ROW | NUMBERS | {'law': 'fuzzy', 'rms': 0.2, 'successes': 9, 'at_edge': ['b[1] is at the upper edge']},
        ROW | dict.fromkeys(NUMBERS) | {'law': 'rare', 'successes': 2, 'success_interval': [0.06, 0.5]},
        FAILED | {'law': 'unknown', 'reason': 'not searched: no individual'},
        FAILED | {'law': 'broken', 'reason': 'at t = 0 s: <b>no answer</b>'}],
}
PATH = DrivenPath([0.0, 1.0, 2.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.1, 1.0], [0.0, 0.1, 0.0])
LAWS = '[...document.querySelectorAll("#tracks tbody tr")].map(row => row.cells[0].textContent)'
PRESS = '[...document.querySelectorAll("#tracks th button")].find(one => one.textContent.startsWith("RMS")).click()'


def test_it_sorts_fits_answers_in_a_sentence_and_shows_a_reason_as_text(browser, tmp_path):
    file = tmp_path / 'benchmark.html'
    svg = save_picture(ratios_figure(VALUES), tmp_path / 'benchmark.pdf')
    write_benchmark_page(file, VALUES, {'noise': {'lqr': PATH, 'fuzzy': PATH, 'broken': None}}, svg,
                         {'command_line': 'benchmark', 'versions': {}})
    for width, scheme in ((1280, 'light'), (390, 'dark')):
        browser.show(file, width, scheme)
        assert browser.evaluate('document.documentElement.scrollWidth <= innerWidth')
        assert browser.violations() == []
        assert browser.evaluate('document.querySelectorAll(".multiples figure").length') == 2
    assert browser.evaluate(LAWS) == ['lqr', 'fuzzy', 'rare', 'broken', 'unknown']
    assert browser.evaluate('[...document.querySelectorAll(".best")].map(one => one.textContent)') == ['1']
    # what is not known stays last
    rest = ['broken', 'unknown']
    for order in (['lqr', 'rare', 'fuzzy', *rest], ['fuzzy', 'rare', 'lqr', *rest]):
        browser.evaluate(PRESS)
        assert browser.evaluate(LAWS) == order
    assert browser.errors() == []
    text = file.read_text()
    assert answer(VALUES) == ('No law is known to beat lqr on 1 of 1 tracks; of 3 comparisons it is better in 2 and '
                              'worse in 0.')
    assert answer(VALUES) in text
    assert 'Not finished: 1 cells;' in text
    assert '<p>1 on noise with feedforward</p>' in text
    assert '<b>no answer</b>' not in text
    assert '&lt;b&gt;no answer' in text
