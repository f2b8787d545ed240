"""What laws and robots do, on the pages: as stored, of the present files and searches, and as the commands measure."""

import copy
import json
import math
from pathlib import Path
from types import SimpleNamespace

import benchmark_results
import claims_table
import path_results
import pytest
import robot_results
import velocity_law_results
from benchmark_results import STORE, SUMMARY, TABLE, table_lines
from chapter_figures import claims
from chapter_figures.runs import LAP, Runs, StepTick
from helpers.harness import CONFIG

from mobile_robot_control.loop.closed_loop import PositionTick, Sample
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError, WheelTorque, WheelVelocity
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.settings.configure import shipped_robots

ROOT = Path(__file__).parents[2]
RESULTS, README, ROBOTS = ((ROOT / page).read_text(encoding='utf-8')
                           for page in ('docs/results.md', 'README.md', 'docs/robots.md'))
VALUES, PATHS = (json.loads((ROOT / 'docs' / store).read_text(encoding='utf-8'))
                 for store in (STORE, 'path_results.json'))


def test_the_results_of_the_benchmark_are_those_stored_for_the_present_tracks():
    for part, text, lines in ((TABLE, RESULTS, table_lines), (SUMMARY, README, benchmark_results.summary_table)):
        assert part.found(text) == part.marked(VALUES['hash'], lines(VALUES))
    assert VALUES['fingerprint'] == benchmark_results.fingerprint(VALUES['laws'], list(VALUES['tracks']))
    assert len(VALUES['ranks']) == len(VALUES['laws']) * len(VALUES['tracks'])


def test_the_results_on_paths_are_those_stored_for_the_present_paths_and_searches():
    part = path_results.PART
    assert PATHS['fingerprint'] == path_results.paths_fingerprint()
    assert part.found(RESULTS) == part.marked(PATHS['fingerprint'], path_results.path_lines(PATHS))


def test_the_results_of_the_velocity_laws_are_those_stored_for_the_present_tracks():
    values = json.loads((ROOT / 'docs' / velocity_law_results.STORE).read_text(encoding='utf-8'))
    part, digits = velocity_law_results.TABLE, velocity_law_results.fingerprint(velocity_law_results.asked())
    assert values['fingerprint'] == digits
    assert part.found(RESULTS) == part.marked(digits, velocity_law_results.table_lines(values['rows']))


def test_a_sentence_names_the_laws_that_no_other_is_known_to_beat():
    ranks = benchmark_results.Ranks(VALUES)
    for track in ('on_curve', 'thrown_off'):
        told, = (text for text in benchmark_results.sentences(VALUES) if f'(`{track}`)' in text)
        named = told.partition('known to beat ')[2].partition(':')[0]
        assert [name.strip(' `') for name in named.replace(' and ', ',').split(',')] == ranks.firsts(track)


def test_a_law_that_was_not_searched_or_fails_says_so_and_half_success_makes_no_first():
    changed = copy.deepcopy(VALUES)
    rows = {row['law']: row for row in benchmark_results.Ranks(changed).tracks['rectangle']}
    rows['lqr'].update(rank=None, last_rank=None, success=None, rms=None)
    rows['kanayama'].update(success=0.25)
    line, = (line for line in table_lines(changed) if line.startswith('| rectangle |'))
    assert ' not searched |' in line
    assert ', 75 % fail |' in line
    assert '**' not in benchmark_results._cell(rows['kanayama'])


def test_the_published_table_has_ten_seeds_on_six_tracks_and_five_on_the_others():
    """Each law was driven with each of them."""
    for row in VALUES['ranks']:
        assert row['seeds'] == (10 if row['track'] in benchmark_results.SIX else 5)
    left = {(one['track'], one['seed']) for one in VALUES['unfinished'] if not one['feedforward']}
    assert left == {(track, seed) for track in VALUES['tracks'] if track not in benchmark_results.SIX
                    for seed in range(6, 11)}


def _failing():
    return [law for law, numbers in PATHS['laws'].items()
            if not (numbers['plain']['rms_position_error'] < 0.03 and numbers['plain']['saturated'] < 0.05)]


def test_at_least_seven_laws_follow_within_3_cm_and_hardly_saturate():
    assert len(_failing()) <= 2


def test_the_page_names_the_laws_that_do_not_follow_within_3_cm_or_saturate():
    behind = RESULTS[RESULTS.index('<!-- end of paths -->'):]
    assert all(f'`{law}` does not' in behind for law in _failing())


def test_a_stored_number_is_measured_again(monkeypatch):
    monkeypatch.chdir(ROOT)
    numbers = PATHS['laws']['kanayama']
    found = path_results.driven(numbers['gains'], 0.5, fed=True)
    assert found['rms_position_error'] == numbers['fed']['0.5']['rms_position_error']


def test_the_tables_of_robots_and_claims_are_of_the_present_files():
    tables, robots = robot_results.PART.found(ROBOTS), shipped_robots()
    assert f'generated from {robot_results.results_fingerprint(robots)} -->' in tables
    rows = [line.split('|')[1].strip() for line in tables.splitlines() if line.startswith('| ')]
    assert rows == ['robot', *robots] * 2
    for robot, file in robots.items():
        assert f'`mrc {robot_results.lap_command(robot, file)}`' in tables
        assert f'`mrc {robot_results.study_command(robot)} --output DIR`' in tables
    table = claims_table.PART.found(RESULTS)
    assert f'generated from {claims_table.fingerprint(CONFIG)} -->' in table
    rows = [line.split('|') for line in table.splitlines() if line.startswith('|')][2:]
    assert [(row[1].strip(), row[2].strip()) for row in rows] == [(claim.where, claim.words) for claim in claims.CLAIMS]
    assert all(row[4].strip().startswith(('yes', 'no')) for row in rows)


@pytest.mark.soak
@pytest.mark.timeout(1200)
def test_the_tables_equal_the_measurement():
    assert robot_results.PART.found(ROBOTS) == robot_results.results_markdown(shipped_robots())
    assert claims_table.PART.found(RESULTS) == claims_table.claims_markdown(CONFIG)


def test_a_row_has_lengths_in_centimetres_and_calls_what_is_absent_so():
    lap = {'duration': 48.0, 'rms_position_error': 0.01234, 'max_position_error': 0.05}
    study = {'runs': 300, 'successes': 299, 'success_interval': [0.98134, 0.9994],
             'metrics': {'late_max_position_error': {'median': 0.02, '95_percent': None}},
             'margins': {'velocity_loop': None, 'position_loop': {'gain': None, 'delay': 0.2514}}}
    assert robot_results.result_cells('one', lap, {'rms_position_error': 0.00123}, study) == [
        'one', '48 s', '1.23 cm', '5.00 cm', '0.12 cm', '299 of 300', '98.13 to 99.94 %', '2.00 cm', '–', '–',
        'more than 20, 251 ms']
    study['margins']['velocity_loop'] = {'gain': 3.999, 'delay': None}
    assert robot_results.result_cells('one', lap, lap, study)[9] == '4.00, more than 20 periods'


def _series(error, command=0.5, laps=3):
    """A coarse run whose errors are given by lap."""
    samples = []
    for n in range(laps * 16):
        time = n * LAP / 16.0
        size = error(int(time // LAP))
        tick = PositionTick(time, Pose(0.0, 0.0, 0.0), BodyVelocity(0.0, 0.0),
                            Reference(Pose(0.0, 0.0, 0.0), BodyVelocity(0.0, 0.0)), TrackingError(size, 0.0, size))
        samples.append(Sample(time, tick, BodyVelocity(command, command), 0.0, 0.0, WheelVelocity(0.0, 0.0),
                              WheelTorque(0.0, 0.0), WheelTorque(0.0, 0.0)))
    return collect(samples)


class _Runs(Runs):
    """Runs with given metrics, errors by lap, largest commands, and a given steady-state error of the velocity loop."""

    def __init__(self, ordinary, other, error=lambda lap: 0.1**lap, left=0.0, commands=(1.0, 0.1)):
        def measured(run):
            mild = run in (claims.HYBRID_LEMNISCATE, claims.FUZZY_TRIFOLIUM, claims.FUZZY_BESIDE)
            peak = other if mild else ordinary
            return SimpleNamespace(series=_series(error, commands[mild]), metrics={
                'peak_wheel_torque': {'right': peak, 'left': peak}, 'peak_wheel_power': {'right': peak, 'left': peak},
                'rms_position_error': 0.01 * peak, 'max_position_error': 0.02 * peak,
            })

        self.measured = measured
        self._left = left

    def velocity_steps(self, steps, duration):
        command = steps[0][1]
        yield StepTick(duration, command, BodyVelocity(command.linear - self._left, command.angular))


def _verdicts(runs):
    return {claim.words.split(' (')[0]: verdict.holds for claim, verdict in claims.judged(runs)}


def test_all_claims_hold_for_runs_as_the_chapter_describes_them():
    assert all(_verdicts(_Runs(ordinary=60.0, other=1.8)).values())


@pytest.mark.parametrize(('runs', 'broken'), [
    (_Runs(ordinary=40.0, other=1.0), 'ordinary backstepping: both torques exceed 50 N m'),
    (_Runs(ordinary=60.0, other=10.0), 'hybrid backstepping: much less torque'),
    (_Runs(ordinary=60.0, other=10.0), 'hybrid backstepping: much less power'),
    (_Runs(ordinary=600.0, other=2.1), 'fuzzy: torques not above 2 N m'),
    (_Runs(ordinary=60.0, other=2.1), 'fuzzy: torques 30 to 40 times less than ordinary backstepping'),
    (_Runs(ordinary=60.0, other=9.0), 'fuzzy: satisfactory tracking'),
    (_Runs(60.0, 1.8, error=lambda lap: 0.9**lap), 'hybrid backstepping: the errors converge'),
    (_Runs(60.0, 1.8, error=lambda lap: 0.9**lap), 'ordinary backstepping: the errors converge'),
    (_Runs(60.0, 1.8, left=0.001), 'the PI controller leaves no steady-state velocity error'),
    (_Runs(60.0, 1.8, left=math.nan), 'the PI controller leaves no steady-state velocity error'),
    (_Runs(60.0, 1.8, commands=(1.0, 0.9)), 'fuzzy: much smaller velocity commands than ordinary backstepping'),
])
def test_a_claim_that_does_not_hold_is_reported_so(runs, broken):
    assert not _verdicts(runs)[broken]
