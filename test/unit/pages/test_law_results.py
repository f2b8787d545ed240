"""What the position laws do, in docs/results.md: as stored, of the present laws and searches, and as measured."""

import copy
import json
from pathlib import Path

import law_results
import law_searches
import pytest
from command_output import output_of
from each import each
from law_results import (
    CURVES,
    FED,
    PART,
    STORE,
    difference_cell,
    lap_numbers,
    law_cells,
    laws_fingerprint,
    laws_markdown,
    make_results,
    measured,
    stored_gains,
)
from law_searches import NAMES, search_fingerprint, search_gains

from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.control.laws import LAWS

PAGE = Path(__file__).parents[3] / 'docs' / 'results.md'
RESULTS = json.loads(PAGE.with_name(STORE).read_text(encoding='utf-8'))
GAINS = {law: numbers['gains'] for law, numbers in RESULTS['laws'].items()}


def test_the_table_is_what_is_stored_of_the_present_laws_searches_and_gains():
    assert PART.found(PAGE.read_text(encoding='utf-8')) == laws_markdown(RESULTS)
    assert tuple(RESULTS['laws']) == NAMES == tuple(LAWS)
    assert len(NAMES) == 9
    assert RESULTS['fingerprint'] == laws_fingerprint(GAINS)
    assert stored_gains(PAGE.with_name(STORE)) == GAINS
    kept = configure({}).velocity_controller.gains
    for law, gains in GAINS.items():
        configuration = configure(gains)
        assert configuration.position_controller.control.controller_type == law
        # all have one velocity loop
        assert configuration.velocity_controller.gains == kept


@pytest.mark.parametrize('law', [pytest.param(law, marks=pytest.mark.soak) if n else law
                                 for n, law in enumerate(NAMES)])
def test_a_lap_has_the_numbers_that_are_stored(law):
    """One curve by the number of the law: both are measured by the long test."""
    curve = CURVES[NAMES.index(law) % 2]
    stored = RESULTS['laws'][law]
    assert lap_numbers(GAINS[law], curve) == pytest.approx(stored['curves'][curve], rel=1e-6)
    assert lap_numbers(GAINS[law], curve, FED) == pytest.approx(stored['fed']['curves'][curve], rel=1e-3)


def _laps(law, name):
    """A number of a law on both curves, the smaller one first."""
    return sorted(RESULTS['laws'][law]['curves'][curve][name] for curve in CURVES)


def _least(name, curve):
    """The law with the least of a number on a curve."""
    return min(NAMES, key=lambda law: RESULTS['laws'][law]['curves'][curve][name])


def _late(law):
    return RESULTS['laws'][law]['study']['metrics']['late_max_position_error']['median']


def _difference(law):
    """The mean of a law's error minus the best's [cm], and which of the two is more accurate."""
    one, = (one for one in RESULTS['comparisons'] if law in (one['first'], one['second']))
    found, = one['metrics']
    return 100.0 * found['difference'] * (1.0 if one['first'] == law else -1.0), found['better']


def _success():
    study = {law: RESULTS['laws'][law]['study'] for law in NAMES}
    assert {law for law in NAMES if study[law]['successes'] < 300} == {'fuzzy'}
    low, _ = study['lqr']['success_interval']
    return ('From 300 random starts within 1 m success is reported, not promised: each law but the fuzzy one succeeded '
            f'in all 300, and the 95 % interval begins at {100.0 * low:.2f} %.')


def _fuzzy():
    nearest, farthest = _laps('fuzzy', 'settled_rms_position_error')
    others = max(_laps(law, 'settled_rms_position_error')[1] for law in NAMES if law != 'fuzzy')
    assert nearest > 4.0 * others
    split = RESULTS['laws']['fuzzy']['study']['split']
    assert (split['words'], split['elsewhere'][0]) == ('scale above 0.5 m', 0)
    assert split['there'][0] == 300 - RESULTS['laws']['fuzzy']['study']['successes']
    return (f'The fuzzy law has no feed-forward and follows {100.0 * nearest:.0f} to {100.0 * farthest:.0f} cm away, '
            f'where the others stay within {100.0 * others:.1f} cm; little is left of the 10 cm that success allows, '
            'and {} of {} runs on curves of 1 m fail, none on those of 0.5 m.'.format(*split['there']))


def _alike():
    assert RESULTS['best'] == 'backstepping'
    apart = {law for law in NAMES if law != 'backstepping' and _difference(law)[1] is None}
    assert apart == {'kanayama', 'periodic', 'fuzzy'}
    return ('In the study `kanayama` and `periodic` cannot be told apart from `backstepping`, the best, by their RMS '
            'errors; neither can `fuzzy`, in the scenarios that are left.')


def _sliding():
    assert all(_least('rms_position_error', curve) == 'sliding_mode' for curve in CURVES)
    difference, better = _difference('sliding_mode')
    assert better == 'backstepping'
    low, high = _laps('sliding_mode', 'rms_position_error')
    return ('From rest on the path `sliding_mode` has the least RMS error of all on both curves, '
            f'{100.0 * low:.2f} and {100.0 * high:.2f} cm; over the runs of the study that error is {difference:.1f} '
            'cm larger than that of the best.')


def _hybrid():
    largest = _laps('hybrid_backstepping', 'peak_wheel_torque')[1]
    others = [torque for law in NAMES if law not in ('hybrid_backstepping', 'fuzzy')
              for torque in _laps(law, 'peak_wheel_torque')]
    assert largest < 0.75 * min(others)
    assert all(_least('settled_rms_position_error', curve) == 'hybrid_backstepping' for curve in CURVES)
    assert min(NAMES, key=_late) == 'hybrid_backstepping'
    difference, _ = _difference('hybrid_backstepping')
    assert difference == max(_difference(law)[0] for law in NAMES if law != 'backstepping')
    return (f'In these laps `hybrid_backstepping` needs at most {largest:.2f} N m where all but the fuzzy law need '
            f'{min(others):.2f} to {max(others):.2f} N m, and settles nearest of all; so it does in the study, where '
            f'its RMS error is {difference:.0f} cm larger than that of the best, more than that of any other.')


@each([_success, _fuzzy, _alike, _sliding, _hybrid], lambda claim: claim.__name__)
def test_a_sentence_of_the_page_holds_for_the_numbers(claim):
    assert claim() in ' '.join(PAGE.read_text(encoding='utf-8').split())


@pytest.mark.soak
@pytest.mark.timeout(3600)
def test_the_table_equals_what_is_searched_and_measured_again(tmp_path):
    gains = {law: search_gains(law, tmp_path) for law in NAMES}
    assert gains == GAINS
    assert laws_markdown(measured(gains)) == laws_markdown(RESULTS)


def test_another_search_or_gain_changes_the_fingerprints(monkeypatch, tmp_path):
    before, searches = laws_fingerprint(GAINS), search_fingerprint()
    changed = copy.deepcopy(GAINS)
    changed['lqr']['position_controller']['lqr.q1'] += 1e-9
    assert laws_fingerprint(changed) != before
    monkeypatch.setattr(law_searches, 'SEARCH', law_searches.SEARCH.replace('--seed 1', '--seed 2'))
    assert search_fingerprint() != searches
    # what is stored is of other searches now, and nothing is known where nothing is stored
    assert stored_gains(PAGE.with_name(STORE)) == {}
    assert stored_gains(tmp_path / STORE) == {}


def test_what_is_not_known_is_called_so():
    changed = copy.deepcopy(RESULTS)
    changed['laws']['lqr']['curves']['trifolium']['rms_position_error'] = None
    changed['laws']['lqr']['study']['metrics']['late_max_position_error']['95_percent'] = None
    assert law_cells('lqr', changed)[2] == law_cells('lqr', changed)[-2] == '–'
    pair = {'first': 'fuzzy', 'second': 'lqr', 'metrics': [
        {'difference': None, 'difference_interval': None, 'better': None, 'left_out': 0}]}
    assert difference_cell('lqr', {'best': 'fuzzy', 'comparisons': [pair]}) == 'not compared'


def test_a_command_that_fails_is_named_with_what_it_printed():
    with pytest.raises(RuntimeError, match=r'simulate --robot nothing: exit code 2: .*there is no robot of this name'):
        output_of('simulate --robot nothing', '--duration', '1')


def test_stored_gains_are_measured_and_not_searched_again(monkeypatch, tmp_path):
    page = tmp_path / 'page.md'
    page.write_text(f'before\n{PART.marked("old", ["OLD"])}\nafter\n')
    page.with_name(STORE).write_text(json.dumps(RESULTS))
    monkeypatch.setattr(law_results, 'search_gains', None)
    monkeypatch.setattr(law_results, 'measured', lambda gains: RESULTS | {'fingerprint': 'new', 'given': gains})
    make_results([page])
    assert json.loads(page.with_name(STORE).read_text())['given'] == GAINS
    assert 'generated from new -->' in page.read_text()
    assert 'OLD' not in page.read_text()
