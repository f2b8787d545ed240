"""`--fail-if-worse`: which rows are told, and how often by chance, with the luck of the published searches."""

import functools
import itertools
import math
import re
from pathlib import Path

import numpy as np
import pytest
from helpers.small_benchmark import TRACK, run

from mobile_robot_control.benchmarking import command as benchmark
from mobile_robot_control.benchmarking.judged_table import NAME, read_judged_table, write_judged_table
from mobile_robot_control.benchmarking.worse_rows import (
    Change,
    Row,
    above,
    change_of,
    rows_of,
    verdict,
    worse_changes,
)
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.loop.monte_carlo import JudgedRuns
from mobile_robot_control.parameters.plugins import register

PUBLISHED = Path(__file__).parents[3] / 'docs' / NAME
ROW = Row('mine', 'small', 'own', 0)
HALF = 5
"""Seeds of a draw, of ten."""


@pytest.fixture(scope='module')
def ten_seeds():
    """The judged runs of laws on the published tracks with ten seeds, by row."""
    return {row: [*runs.values()] for row, runs in rows_of(read_judged_table(PUBLISHED)).items()
            if row.gains == 'searched' and len(runs) == 2 * HALF and None not in runs.values()}


@pytest.fixture(scope='module')
def luck(ten_seeds):
    """Return what changes in a row when the searches and scenarios of some seeds follow those of others."""
    @functools.cache
    def of_seeds(row, now, before):
        return change_of(row, True, {1: ten_seeds[row][now]}, {1: ten_seeds[row][before]})

    def changed(row, rng, factor=1.0):
        drawn = rng.permutation(2 * HALF)
        parts = [of_seeds(row, int(a), int(b)) for a, b in zip(drawn[:HALF], drawn[HALF:], strict=True)]
        return Change(row, True, tuple(error + math.log(factor) for one in parts for error in one.errors),
                      tuple(share for one in parts for share in one.shares), 100 * HALF)

    return changed


@pytest.mark.parametrize('margin', [0.0, 0.1])
def test_at_most_5_of_100_tables_of_the_same_laws_are_worse_by_luck(ten_seeds, luck, margin):
    """In 200 draws of five seeds against the five others, of all rows together."""
    rng, draws = np.random.default_rng(1), 200
    alarms = [worse_changes([luck(row, rng) for row in ten_seeds], margin) for _ in range(draws)]
    assert len(ten_seeds) >= 20
    assert len([one for one in alarms if one]) <= 0.05 * draws


@pytest.mark.parametrize(('factor', 'rate'), [(1.2, 0.3), (1.3, 0.6), (1.5, 0.85)])
def test_a_law_that_is_worse_by_a_fifth_is_caught_in_three_of_ten_draws(ten_seeds, luck, factor, rate):
    """Alone, with five seeds against five others: scenarios are others, too."""
    rng = np.random.default_rng(2)
    caught = [bool(worse_changes([luck(row, rng, factor)], 0.1)) for row in ten_seeds for _ in range(10)]
    assert np.mean(caught) >= rate


def test_a_law_that_is_worse_by_a_fifth_with_the_same_seeds_is_caught_on_each_track():
    table = read_judged_table(PUBLISHED)
    worse = table._replace(results=[
        {**one, 'rms': [error and 1.2 * error for error in one['rms']]} if one['law'] == 'lqr' else one
        for one in table.results])
    found = verdict(worse, table, 0.1)
    rows = [row for row in rows_of(table) if row.law == 'lqr']
    assert sorted(text.partition(':')[0] for text in found.worse) == sorted(map(str, rows))
    assert 'RMS error 1.200 times that of the table (95 % interval 1.200 to 1.200, ' in found.worse[0]
    assert found.worse[0].endswith(' seeds), and 1.1 are allowed')
    assert found.compared == len(rows_of(table))
    assert verdict(worse, table, 0.25).worse == verdict(table, worse, 0.1).worse == []


@pytest.mark.parametrize(('runs', 'rate'), [(20, 0.55), (100, 0.9)])
def test_gains_that_are_not_searched_are_caught_by_their_scenarios(ten_seeds, runs, rate):
    """Two laws differ as much from scenario to scenario; a margin that is just kept is seldom said to be exceeded."""
    rng, caught, kept = np.random.default_rng(3), [], []
    laws, tracks = ('kanayama', 'ramsete', 'lqr'), {row.track for row in ten_seeds}
    for track, pair in itertools.product(sorted(tracks), itertools.combinations(laws, 2)):
        a, b = (ten_seeds[Row(law, track, 'searched', 500)][0] for law in pair)
        errors = np.array(change_of(ROW, False, {1: a}, {1: b}).errors)
        for ratio, found in ((1.2, caught), (1.1, kept)):
            shifted = errors - errors.mean() + math.log(ratio)
            found += [above(rng.choice(shifted, runs).tolist(), math.log(1.1)) <= 0.05 for _ in range(40)]
    assert np.mean(caught) >= rate
    # four standard errors of a share over 720
    assert np.mean(kept) <= 0.05 + 4.0 * math.sqrt(0.05 * 0.95 / len(kept))


def runs(*errors):
    known = np.array([error is not None for error in errors])
    return JudgedRuns(known, {'rms_position_error': np.array([error or np.inf for error in errors])},
                      np.full(len(errors), ''))


@pytest.mark.parametrize(('is_searched', 'failing', 'is_told'), [
    # ten of ten scenarios, three of ten, and one in each of two seeds
    (False, 10, True), (False, 3, False), (True, 1, False), (True, 10, True)])
def test_more_failures_are_told_where_luck_would_not_give_them(is_searched, failing, is_told):
    seeds = range(2 if is_searched and failing == 1 else 5 if is_searched else 1)
    now = {seed: runs(*[None] * failing, *[0.1] * (20 - failing)) for seed in seeds}
    before = {seed: runs(*[0.1] * 20) for seed in seeds}
    change = change_of(ROW, is_searched, now, before)
    assert worse_changes([change], 0.1) == [(change, False)] * is_told
    assert worse_changes([change_of(ROW, is_searched, before, now)], 0.1) == []


def test_rows_that_are_the_same_to_the_last_bit_leave_the_others_their_certainty():
    same = change_of(ROW, False, {1: runs(0.1, 0.2)}, {1: runs(0.1, 0.2)})
    worse = Change(ROW, False, (0.3, 0.35, 0.4), ((1.0, 1.0),) * 3, 3)
    assert same.is_none
    assert worse_changes([same] * 100 + [worse], 0.1) == [(worse, True)]
    assert worse_changes([worse._replace(errors=(0.01, 0.0, 0.0))] * 100 + [worse], 0.1) == []


def again(track, folder, table, *more):
    return run(track, folder, '--no-tune', '--runs', 20, '--overwrite', '--fail-if-worse', table, *more)


def test_a_benchmark_fails_where_a_law_is_worse_than_in_a_table(track, tmp_path, capsys, monkeypatch):
    register(LAWS['ramsete']._replace(name='mine'))
    track.write_text(TRACK.replace('laps: 0.5', 'laps: 1.0, within: 0.005, turned: 0.5'))
    assert run(track, tmp_path / 'table', '--no-tune', '--laws', 'mine', 'lqr', '--runs', 20) == 0
    table = tmp_path / 'table' / NAME
    # pages take time
    monkeypatch.setattr(benchmark, 'write_benchmark', lambda *_: tmp_path)
    assert again(track, tmp_path / 'out', table, '--laws', 'mine', 'lqr', 'kanayama') == 0
    told = capsys.readouterr().err
    assert f'benchmark: not in {table}, and not compared: kanayama on small (configured)' in told
    assert f'no row is worse than in {table} by more than 10 %, for certain; compared: 2' in told
    LAWS.remove('mine')
    register(LAWS['lqr']._replace(name='mine'))
    assert again(track, tmp_path / 'out', table, '--laws', 'mine', 'lqr', '--margin', 0.01) == 1
    told = capsys.readouterr().err
    assert 'benchmark: worse: mine on small (configured): RMS error ' in told
    assert 'worse: lqr' not in told
    assert f'1 of 2 rows are worse than in {table}: look at paths' in told
    assert f'{tmp_path / "out"}/{NAME} as the new table' in told


def test_what_a_table_cannot_judge_is_refused_before_anything_runs(track, tmp_path, capsys):
    table = read_judged_table(PUBLISHED)
    other = tmp_path / 'other.gz'
    write_judged_table(other, table._replace(
        tracks={**table.tracks, 'noise': {**table.tracks['noise'], 'content': '0'}}))
    of_two = ['--seeds', '1', '2']
    for file, name, asked, told in (
        (PUBLISHED, track, of_two, f'{PUBLISHED}: no row of this benchmark can be compared with it; it has '),
        (PUBLISHED, 'noise', [], 'of which a law that is searched needs two or more'),
        (PUBLISHED, 'noise', [*of_two, '--no-tune'], ', gains searched, --budgets '),
        (PUBLISHED, 'noise', [*of_two, '--restarts', '5'], 'the table had restarts = 2, and those of this benchmark'),
        (other, 'noise', of_two, "the track 'noise' is another one than that of the table"),
        (track, 'noise', of_two, 'is no table of judged runs'),
    ):
        assert benchmark.main(['--laws', 'lqr', '--tracks', str(name), *asked, '--fail-if-worse', str(file),
                               '--output', str(tmp_path / 'out')]) == 2
        assert told in capsys.readouterr().err
        assert not (tmp_path / 'out').exists()


def test_a_law_that_cannot_be_searched_any_more_is_worse_without_a_test():
    table = read_judged_table(PUBLISHED)
    lost = table._replace(results=[{**one, 'success': None, 'rms': None} if (
        one['law'], one['track'], one['gains'], one['seed']) == ('lqr', 'noise', 'searched', 3) else one
        for one in table.results])
    assert verdict(lost, table, 0.1).worse == [
        'lqr on noise (searched, budget 500): was driven before, and is not searched now with seed 3']


def test_a_node_that_is_worse_is_caught_by_the_scenarios_of_all_its_seeds():
    table = read_judged_table(PUBLISHED)

    def with_node(factor, count):
        rows = [{**one, 'law': 'mine', 'gains': 'own', 'success': one['success'][:count],
                 'rms': [factor * error for error in one['rms'][:count]]} for one in table.results
                if (one['law'], one['track'], one['gains']) == ('lqr', 'noise', 'searched')]
        return table._replace(results=[*table.results, *rows])

    before, now = with_node(1.0, 4), with_node(1.2, 2)
    row, = verdict(now, before, 0.1).worse
    seeds = len(table.tracks['noise']['seeds'])
    assert re.match(rf'mine on noise \(own\): RMS error 1\.200 .*, {2 * seeds} scenarios\), and 1\.1 are', row)
    assert verdict(before, now, 0.1).worse == []
