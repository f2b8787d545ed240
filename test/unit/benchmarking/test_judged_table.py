"""A law ranked against a table of judged runs, without the laws of the table, and the table that is published."""

import gzip
import itertools
import json
import math
import re
import subprocess
import sys
from pathlib import Path

import benchmark_results
import numpy as np
import pytest

import mobile_robot_control as mrc
from mobile_robot_control.benchmarking import command as benchmark
from mobile_robot_control.benchmarking.judged_table import NAME, content_digits, read_judged_table, write_judged_table
from mobile_robot_control.benchmarking.ranking import Pair, better_pairs, pairs_of, quantile
from mobile_robot_control.benchmarking.run_cell import Work, driven_again
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.loop import batch
from mobile_robot_control.loop.workers import Workers, runner
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.parameters.plugins import register
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.tracks import read_track

ROOT = Path(__file__).parents[3]
STORE = ROOT / 'docs' / benchmark_results.STORE
PUBLISHED = STORE.with_name(NAME)
TRACK = """
track: {{ros__parameters: {{purpose: A curve of a hand's breadth., curves: [trifolium], scales: [0.05], laps: {laps}}}}}
/**: {{ros__parameters: {{reference_horizon: 1, velocity_rate: 50.0, position_rate: 50.0}}}}
/**/plant: {{ros__parameters: {{drive: velocity}}}}
/**/reference_cart: {{ros__parameters: {{curve: trifolium, scale: 0.05, period: 1.0}}}}
"""
SMALL = {'budgets': [25], 'scenarios': 1, 'runs': 4, 'seeds': [1, 2, 3], 'workers': 1}


@pytest.fixture(scope='module')
def small(tmp_path_factory):
    """A track so small that rollouts run plain, and what a benchmark of two laws on it has shown."""
    folder = tmp_path_factory.mktemp('small')
    track = folder / 'small.yaml'
    track.write_text(TRACK.format(laps=0.5))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(batch, 'COMPILES', False)
        found = mrc.benchmark(laws=['kanayama', 'lqr'], tracks=[track], **SMALL)
    found.report(folder / 'table')
    return track, folder / 'table' / NAME


def of_law(rows, law):
    return [row for row in rows if law in (row.get('law'), row.get('first'), row.get('second'))]


def test_a_law_that_is_driven_alone_ranks_as_beside_the_laws_of_the_table(small, tmp_path, capsys):
    track, table = small
    register(LAWS['ramsete']._replace(name='mine'))
    whole = mrc.benchmark(laws=['kanayama', 'lqr', 'mine'], tracks=[track], **SMALL)
    whole.report(tmp_path / 'whole')
    assert benchmark.main(['--tracks', str(track), '--output', str(tmp_path / 'out'), '--workers', '1',
                           '--against', str(table)]) == 0
    values = json.loads((tmp_path / 'out' / 'benchmark.json').read_text())
    assert {row['law'] for row in values['results']} == {'mine'}
    assert values['seeds'] == SMALL['seeds']
    known = ('track', 'law', 'place', 'rank', 'last_rank', 'seeds', 'success', 'rms', 'ratio', 'ratio_interval')
    assert [[row[name] for name in known] for row in values['ranks']] == [
        [row[name] for name in known] for row in whole.ranks]
    assert of_law(values['ranks'], 'mine') == of_law(whole.ranks, 'mine')
    assert values['pairs'] == whole.values['pairs']
    assert values['summary'] == whole.values['summary']
    printed = capsys.readouterr().out
    assert re.search(r'^mine ranks among 3 laws: small \d', printed, re.MULTILINE)
    # a further law can be ranked against both
    further, both = (read_judged_table(tmp_path / folder / NAME) for folder in ('out', 'whole'))
    assert further._replace(hash=both.hash) == both


def test_what_a_further_law_makes_uncertain_is_named(small, tmp_path):
    track, file = small
    table = read_judged_table(file)
    for one in table.results:
        # a probability of 0.02, which is below 0.05 / 2 and above 0.05 / 4
        apart = 0.0 if one['law'] == 'lqr' else {1: 0.0377, 2: 0.05, 3: 0.0623}[one['seed']]
        one.update(success=[1] * 4, rms=[0.01 * math.exp(apart)] * 4)
    assert better_pairs(pairs_of(table.judged('small', 25))) == {('lqr', 'kanayama')}
    file = tmp_path / NAME
    write_judged_table(file, table)
    register(LAWS['ramsete']._replace(name='mine'))
    found = mrc.benchmark(tracks=[track], against=str(file), workers=1)
    undone, = found.values['against']['undone']
    assert undone == {'track': 'small', 'budget': 25, 'better': 'lqr', 'worse': 'kanayama'}
    assert 'no more certain, among more comparisons: lqr better than kanayama on small' in repr(found)
    assert '<li>lqr better than kanayama on small</li>' in found.report(tmp_path / 'out').html


def test_what_cannot_be_compared_with_a_table_is_refused_with_the_remedy(small, tmp_path):
    track, file = small
    other = tmp_path / 'other' / 'small.yaml'
    other.parent.mkdir()
    other.write_text(TRACK.format(laps=0.25))
    content = json.loads(gzip.decompress(file.read_bytes()))

    def damaged(**changes):
        name = tmp_path / f'{next(count)}.json.gz'
        name.write_bytes(gzip.compress(json.dumps({**content, **changes}).encode()))
        return name

    count = itertools.count()
    cut = tmp_path / 'cut.json.gz'
    cut.write_bytes(file.read_bytes()[:-20])
    asked = {'against': str(file), 'laws': ['ramsete'], 'tracks': [track]}
    for changes, told in (
        ({'tracks': [other]}, "the track 'small' is another one than that of the table"),
        ({'tracks': ['on_curve']}, "the table has no track 'on_curve'"),
        ({'laws': ['lqr']}, "the table has a law 'lqr' already; rename yours"),
        ({'laws': []}, 'load yours with --law FILE'),
        ({'budgets': [50], 'seeds': [7]}, '--budgets is that of the table'),
        ({'tune': False}, '--tune is that of the table'),
        ({'against': str(damaged(arithmetic=1))}, 'was computed with arithmetic 1, and this program has 2'),
        ({'against': str(damaged(results=[{**content['results'][0], 'rms': [0.1]}]))}, 'has not 4 runs'),
        ({'against': str(damaged(results=[{**content['results'][0], 'seed': 9}]))}, 'that the table lacks'),
        ({'against': str(damaged(tracks=[]))}, 'is no table of judged runs'),
        ({'against': str(damaged(scenarios=0))}, 'scenarios = 0 is not allowed'),
        ({'against': str(damaged(results=[{**content['results'][0], 'rms': [10 ** 400] * 4}]))}, 'int too large'),
        ({'against': str(cut)}, 'is no table of judged runs'),
        ({'against': str(track)}, 'is no table of judged runs'),
        ({'against': str(tmp_path / 'nowhere')}, f'nowhere: No such file or directory; name the {NAME}'),
    ):
        with pytest.raises(ParameterError) as refused:
            mrc.benchmark(**{**asked, **changes})
        assert told in str(refused.value)


@pytest.fixture(scope='module')
def published():
    return read_judged_table(PUBLISHED), json.loads(STORE.read_text())


def test_the_published_table_is_that_of_the_published_rows_tracks_and_pairs(published):
    table, values = published
    rows = benchmark_results.rows_of(STORE)
    assert PUBLISHED.stat().st_size <= 1_500_000
    assert (table.hash, table.laws, [*table.tracks]) == (values['hash'], tuple(values['laws']), [*values['tracks']])
    for name, track in table.tracks.items():
        assert track['content'] == content_digits(read_track(name), ParameterSources())
    for row, one in zip(rows, table.results, strict=True):
        assert [row[name] for name in ('track', 'law', 'gains', 'seed', 'budget')] == [
            str(one[name]) for name in ('track', 'law', 'gains', 'seed', 'budget')]
        errors = [rms for rms, success in zip(one['rms'], one['success'], strict=True) if success]
        assert (int(row['successes']), row['rms']) == (len(errors), str(quantile(errors, 0.5) or ''))
    pairs = pairs_of(table.judged('published', 500))
    assert [[pair.first, pair.second, [*pair.errors], [*pair.successes]] for pair in pairs] == [
        [row[name] for name in ('first', 'second', 'errors', 'successes')] for row in values['pairs']
        if row['track'] == 'published']


def test_the_published_gains_give_the_published_runs_to_the_last_bit(published):
    table, _ = published
    rows = [row for row in benchmark_results.rows_of(STORE)
            if (row['track'], row['seed'], row['gains']) == ('robot_create3', '2', 'searched')][:2]
    for row, (cell, result) in zip(rows, benchmark_results.cells_of(rows), strict=True):
        with runner(Workers(workers=1)) as run:
            found = driven_again(cell._replace(runs=2), result, Work(run, STORE, lambda _: None, lambda: False))
        known, = (one for one in table.results if all(
            str(one[name]) == row[name] for name in ('track', 'law', 'gains', 'seed')))
        assert (found.judged.success, found.judged.metrics['rms_position_error']) == ([True] * 2, known['rms'][:2])


def test_the_published_ranks_follow_from_the_published_runs_by_the_script_of_the_page(published):
    page = PUBLISHED.with_name('benchmark.md').read_text(encoding='utf-8')
    script = re.search(r'^```python\n(.*?)^```$', page, re.DOTALL | re.MULTILINE)[1]
    printed = subprocess.run([sys.executable, '-'], input=script, cwd=ROOT, capture_output=True, text=True, check=True)
    assert sorted(printed.stdout.splitlines()) == sorted(
        f'{row["track"]} {row["law"]} {row["rank"]} {row["last_rank"]}' for row in published[1]['ranks'])


@pytest.mark.parametrize(('law', 'track'), [('kanayama', 'noise'), ('sliding_mode', 'thrown_off')])
def test_a_copy_of_a_law_is_certain_against_it_in_at_most_5_of_100_resamplings_of_seeds(published, law, track):
    """Law and copy get the luck of seeds that are drawn apart, with repetition; the other laws that of the law."""
    judged = published[0].judged(track, 500)
    errors, shares = ({name: [mean(one) for one in own.values()] for name, own in judged.items()} for mean in (
        lambda one: float(np.log(one.metrics['rms_position_error'][one.success]).mean()),
        lambda one: float(one.success.mean())))
    rng, draws, certain = np.random.default_rng(1), 200, 0
    for _ in range(draws):
        seeds, apart = rng.integers(0, len(errors[law]), (2, len(errors[law])))
        columns = {name: ([errors[name][n] for n in seeds], [shares[name][n] for n in seeds]) for name in errors}
        columns['copy'] = [errors[law][n] for n in apart], [shares[law][n] for n in apart]
        better = better_pairs([Pair(a, b, *(tuple(x - y for x, y in zip(*both, strict=True))
                                            for both in zip(columns[a], columns[b], strict=True)))
                               for a, b in itertools.combinations(columns, 2)])
        certain += any({*pair} == {law, 'copy'} for pair in better)
    assert certain <= 0.05 * draws
