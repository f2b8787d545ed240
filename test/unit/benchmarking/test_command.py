"""The command `benchmark`: its table, hash, files and exit codes, on a track so small that rollouts run plain."""

import contextlib
import csv
import itertools
import json
import os
import random
import re
import subprocess
import sys
import time

import pytest
from helpers.small_benchmark import TRACK, Stopped, generations, hash_of, read, run

import mobile_robot_control as mrc
from mobile_robot_control.benchmarking import command as benchmark
from mobile_robot_control.benchmarking import side_by_side
from mobile_robot_control.benchmarking.table import last_summary
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.parameters.declaration import ParameterError, flatten
from mobile_robot_control.system.process import Interrupt

LAW = """
from typing import Annotated, NamedTuple
from mobile_robot_control import BodyVelocity, Field, Law

class Gains(NamedTuple):
    k: Annotated[float, Field('1/s', 'larger closes the gap sooner', above=0.0, search=(0.0, 5.0))] = 1.0

def step(state, observation, gains, dt):
    e1, e2, e3 = observation.error
    v, w = observation.reference.velocity
    {failure}
    return state, BodyVelocity(v + gains.k * e1, w + e2 + gains.k * e3)

LAW = Law('{name}', step, Gains)
"""


def test_laws_are_searched_and_judged_to_the_same_hash_by_the_command_or_from_python(track, tmp_path, capsys):
    laws = ('kanayama', 'ramsete')
    assert run(track, tmp_path / 'one', '--laws', *laws) == 0
    values, rows = read(tmp_path / 'one')
    assert f'hash {values["hash"]}' in capsys.readouterr().out
    assert [(row['law'], row['track'], row['runs']) for row in rows] == [
        (row['law'], 'small', '4') for row in values['results']]
    assert {(row['law'], row['gains']) for row in rows} == set(itertools.product(laws, ('searched', 'configured')))
    for row in values['results']:
        assert set(row['values']) == ({f'position_controller.{row["law"]}.{name}' for name in (
            ('kx', 'ky', 'ktheta') if row['law'] == 'kanayama' else ('b', 'zeta'))} if row['gains'] == 'searched'
            else set())
        assert row['successes'] == 4
        assert 0.0 < row['rms'] <= row['rms_95'] <= row['worst']
        assert row['peak_wheel_torque'] is None
        assert row['step_time'] > 0.0
    # with every judged run anybody computes the same numbers
    with (tmp_path / 'one' / 'benchmark_runs.csv').open() as file:
        judged = [float(one['rms_position_error']) for one in csv.DictReader(file)
                  if (one['law'], one['gains']) == ('ramsete', 'searched')]
    assert sorted(judged)[1] == next(row['rms'] for row in values['results'] if row['law'] == 'ramsete')
    assert values['hash'] in (tmp_path / 'one' / 'benchmark.tex').read_text()
    assert (tmp_path / 'one' / 'benchmark.pdf').read_bytes().startswith(b'%PDF')
    page = (tmp_path / 'one' / 'benchmark.html').read_text()
    assert values['hash'] in page
    assert page.count('class="sortable"') == 3
    assert 'No law is called better' in page
    # elsewhere and later
    found = mrc.benchmark(laws=laws, tracks=[track], budgets=[25], scenarios=1, runs=4, workers=1)
    assert found.hash == values['hash']
    assert found.hash in repr(found)
    assert list(found.to_dataframe()['law']) == [row['law'] for row in rows]
    assert found.hash in found.report(tmp_path / 'page').html
    assert run(track, tmp_path / 'other', '--laws', *laws, '--seed', 2) == 0
    assert hash_of(tmp_path / 'other') != values['hash']


def test_laws_of_a_folder_rank_beside_shipped_ones_and_failing_ones_last_with_a_reason(track, tmp_path, capsys):
    folder = tmp_path / 'handed_in'
    folder.mkdir()
    for name, failure in (('mine', 'pass'), ('raises', "raise ValueError('no answer')"), ('empty', "v = float('nan')")):
        (folder / f'{name}.py').write_text(LAW.format(name=name, failure=failure))
    (folder / 'twin.py').write_text(LAW.format(name='mine', failure='pass'))
    (folder / 'broken.py').write_text('import nowhere')
    arguments = ('--laws', 'kanayama', 'raises', 'mine', 'empty', '--law', folder, '--seeds', 1, 2, 3, 4, 5)
    with pytest.raises(SystemExit, match='2'):
        run(track, tmp_path / 'out', *arguments)
    for name in ('mine', 'raises', 'empty'):
        LAWS.remove(name)
    assert run(track, tmp_path / 'out', *arguments, '--keep-going') == 0
    values, printed = read(tmp_path / 'out')[0], capsys.readouterr().out
    for name, reason in (('broken', 'cannot be imported (ModuleNotFoundError'), ('twin', "the law 'mine' is defined")):
        assert reason in values['not_loaded'][str(folder / f'{name}.py')]
        assert reason in (tmp_path / 'out' / 'benchmark.html').read_text().replace('&#x27;', "'")
        assert f'not loaded: {folder / name}.py: {reason}' in printed
    assert re.search('raises: .*fails in most runs on small .*no answer', printed)
    rows = {row['law']: row for row in values['ranks']}
    assert list(rows)[2:] == ['empty', 'raises']
    assert rows['mine']['success'] == 1.0
    assert rows['mine']['rank'] <= 2 >= rows['kanayama']['rank']
    assert (rows['raises']['rank'], rows['empty']['last_rank']) == (3, 4)
    assert 'no answer' in rows['raises']['reason']
    assert 'its command is v = nan m/s' in rows['empty']['reason']
    assert 'no answer' in (tmp_path / 'out' / 'benchmark.html').read_text()


@pytest.mark.parametrize(('works', 'asked'), [
    ('gains.k == 1.0', ['--budgets', 100]), ('False', []), ('True', ['--no-tune']),
])
def test_a_law_whose_search_drives_no_candidate_has_no_rank_and_counts_in_no_mean(
    track, tmp_path, capsys, works, asked
):
    """Its configured gains may work, which no search has tried."""
    for name in ('one', 'two'):
        (tmp_path / f'{name}.py').write_text(LAW.format(name=name, failure=f'v = v if {works} else 1e9'))
    assert run(track, tmp_path / works, '--laws', 'one', 'kanayama', 'two', *asked, *(
        word for name in ('one', 'two') for word in ('--law', tmp_path / f'{name}.py'))) == 0
    searched = works == 'True'
    values, _ = read(tmp_path / works)
    for row in values['ranks']:
        unknown = row['law'] != 'kanayama' and not searched
        assert [row[name] is None for name in ('rank', 'last_rank', 'place', 'success')] == [unknown] * 4
        assert row['reason'].startswith('not searched: no individual') is unknown
    last = last_summary(values)
    assert [one['tracks'] == 0 for one in last] == [False] + [not searched] * 2
    if not searched:
        assert [one['not_searched'] for one in last] == [[], ['small'], ['small']]
    printed, page = capsys.readouterr().out, (tmp_path / works / 'benchmark.html').read_text()
    assert ('one: not searched on small (no individual' in printed) is not searched
    assert ('>not searched<' in page) is not searched
    assert '>failed</td>' not in page


def test_a_law_gets_the_horizon_that_it_declares_and_the_table_marks_it(track, tmp_path, capsys):
    """The track gives one tick; a law beyond all that a cart can tell is not searched, and does not fail."""
    for name, ticks in (('near', 0), ('far', 5), ('farthest', 1001)):
        text = LAW.format(name=name, failure=f'v = observation.horizon[{max(ticks, 1)} - 1].velocity.linear')
        (tmp_path / f'{name}.py').write_text(text.replace('Gains)', f'Gains, horizon={ticks})'))
    assert run(track, tmp_path / 'out', '--laws', 'near', 'far', 'farthest', *(
        word for name in ('near', 'far', 'farthest') for word in ('--law', tmp_path / f'{name}.py'))) == 0
    values, printed = read(tmp_path / 'out')[0], capsys.readouterr().out
    rows = {row['law']: row for row in values['ranks']}
    assert values['horizons'] == {'far': 5, 'farthest': 1001}
    assert (rows['near']['success'], rows['far']['success'], rows['farthest']['rank']) == (1.0, 1.0, None)
    assert rows['near']['rms'] != rows['far']['rms']
    assert 'far (preview of 5 ticks): unbeaten' in printed
    assert re.search(r'farthest .*: not searched on small \(no horizon of 1001 ticks: .* at most 1000\)', printed)
    assert 'fails' not in printed
    assert '>far (preview of 5 ticks)<' in (tmp_path / 'out' / 'benchmark.html').read_text()


def test_a_law_that_answers_by_chance_is_told(track, tmp_path, capsys):
    text = LAW.format(name='chance', failure='w += 1e-9 * random.random()')
    (tmp_path / 'chance.py').write_text(f'import random\n{text}')
    laws = ['--law', tmp_path / 'chance.py', '--laws', 'chance', 'kanayama']
    assert run(track, tmp_path / 'out', *laws, '--no-tune') == 0
    assert 'chance: answers the same question differently' in capsys.readouterr().out
    assert read(tmp_path / 'out')[0]['not_repeatable'] == ['chance']


def test_what_a_folder_holds_is_kept_unless_asked(track, tmp_path, capsys):
    out, words = tmp_path / 'out', ['--no-tune', '--laws', 'ramsete']
    assert run(track, out, *words) == 0
    values, _ = read(out)
    assert values['budgets'] == []
    configured = flatten(mrc.configure({}).position_controller.control.ramsete)
    assert values['results'][0]['values'] == {f'position_controller.ramsete.{name}': value
                                              for name, value in configured.items()}
    assert run(track, out, *words) == 2
    assert '--resume' in capsys.readouterr().err
    # nothing is run again, and another law is added
    before = {file: file.stat().st_mtime_ns for file in (out / 'cells').iterdir()}
    assert run(track, out, *words, 'kanayama', '--resume') == 0
    assert all(file.stat().st_mtime_ns == time_ns for file, time_ns in before.items())
    assert len(read(out)[1]) == 2


def test_cells_of_another_arithmetic_are_refused_by_name(track, tmp_path, capsys):
    out, words = tmp_path / 'out', ['--no-tune', '--laws', 'ramsete']
    assert run(track, out, *words) == 0
    cell, = (out / 'cells').iterdir()
    content = json.loads(cell.read_text())
    # one from before there was a number
    del content['arithmetic']
    cell.rename(cell.with_name('ramsete.track.1.0123456789ab.json')).write_text(json.dumps(content))
    assert run(track, out, *words, '--resume') == 2
    assert '0123456789ab.json: was computed with arithmetic 1, and this program has 2' in capsys.readouterr().err
    assert run(track, out, *words, '--overwrite') == 0


def test_an_interrupted_benchmark_goes_on_to_the_same_hash(track, tmp_path, monkeypatch, capsys):
    laws = ['--laws', 'kanayama', 'ramsete', '--budgets', '50']
    endless = Stopped(10**6)
    monkeypatch.setattr(benchmark, 'Interrupt', lambda: endless)
    assert run(track, tmp_path / 'whole', *laws) == 0
    # in the first stage of the first law, and in the last one of the second
    for count, done in ((1, False), (10**6 - endless.left - 3, True)):
        monkeypatch.setattr(benchmark, 'Interrupt', lambda count=count: Stopped(count))
        assert run(track, tmp_path / 'stopped', *laws, '--resume') == 1
        assert '--resume goes on' in capsys.readouterr().err
        assert (tmp_path / 'stopped' / 'benchmark.json').exists() is done
    # what is done is shown, and what is not
    assert [one['law'] for one in read(tmp_path / 'stopped')[0]['unfinished']] == ['ramsete']
    assert '<p>1 on small</p>' in (tmp_path / 'stopped' / 'benchmark.html').read_text()
    monkeypatch.setattr(benchmark, 'Interrupt', Interrupt)
    assert run(track, tmp_path / 'stopped', *laws, '--resume') == 0
    assert hash_of(tmp_path / 'stopped') == hash_of(tmp_path / 'whole')


def _damaged(*_):
    raise ParameterError(['a journal is damaged'])


@pytest.mark.parametrize(('arguments', 'told'), [
    (['--robot', 'kobuki'], 'each track names its robot'),
    (['--velocity-laws', 'adaptive'], "--velocity-laws: the robot of the track 'small' takes velocity commands"),
    (['--tracks', 'rectangel'], "did you mean 'rectangle'?"),
    (['--laws', 'lqrr'], 'lqrr'),
    (['--verify'], 'holds no benchmark'),
    (['--tracks', 'none.yaml'], "none.yaml: has no section 'track'"),
    (['--tracks', 'within.yaml'], 'purpose is missing'),
    (['--tracks', 'wihtin.yaml'], "did you mean 'within'?"),
    (['--tracks', 'curves.yaml'], 'track: curves = [] draws from nothing; name one or more'),
    (['--tracks', 'scales.yaml'], 'track: scales = [] draws from nothing; name one or more'),
])
def test_what_cannot_be_compared_is_refused_by_name(track, tmp_path, capsys, monkeypatch, arguments, told):
    monkeypatch.chdir(tmp_path)
    for name, text in (('none', ''), ('within', 'track: {ros__parameters: {within: 1.0}}\n'),
                       *((name, f'track: {{ros__parameters: {{purpose: x, {name}: []}}}}\n')
                         for name in ('curves', 'scales')),
                       ('wihtin', 'track: {ros__parameters: {purpose: x, wihtin: 1.0}}\n')):
        (tmp_path / f'{name}.yaml').write_text(f'{text}/**: {{ros__parameters: {{velocity_rate: 100.0}}}}')
    with pytest.raises(SystemExit) if '--laws' in arguments else contextlib.nullcontext():
        assert run(track, tmp_path / 'out', *arguments) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(('said', 'told'), [
    ('{initial_pose: 5}', 'initial_pose = 5'), ('{initial_pose: [a, b, c]}', 'initial_pose = ['),
    ('{initial_pose: [1.0]}', 'initial_pose = ['), ('{initial_pose: {x: 1.0}}', 'initial_pose.x = 1.0'),
    ('{gains: {b: [1.0, 2.0]}}', 'ramsete.b = [1.0, 2.0]'), ('{gains: {b: much}}', "ramsete.b = 'much'"),
    ('{gains: {b: true}}', 'ramsete.b = True'), ('{gains: {b: -1.0}}', 'ramsete.b = -1.0'), ('{gains: {k: 1.0}}', 'k'),
    ('{gains: 5.0}', 'ramsete.gains = 5.0'), ('{metrics: {iae: [1.0]}}', 'iae = [1.0]'),
    ('{metrics: {iae: small}}', "iae = 'small'"), ('{metrics: {iae: .nan}}', 'iae = nan'),
    ('{metrics: 5.0}', 'metrics = 5.0'), ('{metrics: {ieae: 1.0}}', "did you mean 'iae'?"),
    ('{metrics: {peak_wheel_torque: 1.0}}', "no metric 'peak_wheel_torque'"),
])
def test_what_no_publication_can_report_is_refused_before_anything_runs(track, tmp_path, capsys, said, told):
    track.write_text(f'{TRACK}\npublished: {{ros__parameters: {{ramsete: {said}}}}}')
    assert run(track, tmp_path / 'out', '--laws', 'ramsete', '--no-tune') == 2
    printed = capsys.readouterr().err
    assert f'{track}: published: ' in printed
    assert told in printed
    assert not (tmp_path / 'out').exists()


def test_a_published_number_that_a_run_does_not_have_is_a_dash(track, tmp_path, capsys):
    track.write_text(f'{TRACK}\npublished: {{ros__parameters: {{ramsete: {{metrics: {{energy: 1.0, iae: 1}}}}}}}}')
    assert run(track, tmp_path / 'out', '--laws', 'ramsete', '--no-tune') == 0
    assert 'energy – (1 published), iae 0.' in capsys.readouterr().out


@pytest.mark.parametrize('damage', [
    b'', b'null', b'5', b'"results"', b'{}', b'[1]', b'\xff\xfe\x00', b'9' * 5000, b'[' * 100_000, b'{"a":' * 100_000,
    lambda whole: whole[:len(whole) // 2], lambda whole: whole.replace(b'true', b'false', 1),
    lambda whole: json.dumps(json.loads(whole)['cell']).encode(), lambda whole: whole.decode().encode('utf-16') + b'x',
    'fifo', 'folder', 'endless',
], ids=lambda damage: str(damage)[:20])
def test_a_damaged_cell_is_told_by_name_before_anything_runs(track, tmp_path, capsys, monkeypatch, damage):
    out = tmp_path / 'out'
    words = ['--no-tune', '--laws', 'ramsete', 'kanayama', '--runs', 2]
    assert run(track, out, *words, '--overwrite') == 0
    cell, *_ = sorted((out / 'cells').iterdir())
    whole = cell.read_bytes()
    cell.unlink()
    if isinstance(damage, str):
        {'fifo': os.mkfifo, 'folder': os.mkdir, 'endless': lambda file: file.symlink_to('/dev/zero')}[damage](cell)
    else:
        cell.write_bytes(damage(whole) if callable(damage) else damage)
    for more in ('--resume', '--verify'):
        with monkeypatch.context() as patch:
            patch.setattr(side_by_side, 'run_cell', _damaged)
            assert run(track, out, *words, more) == 2
        assert f'{cell}: ' in (printed := capsys.readouterr().err)
        assert 'remove it, and --resume' in printed
    if damage == 'folder':
        cell.rmdir()
    else:
        cell.unlink()
    assert run(track, out, *words, '--resume') == 0


@pytest.mark.soak
@pytest.mark.timeout(1800)
@pytest.mark.parametrize('where', [['--workers', '1'], ['--workers', '2'], 'dask'])
def test_killed_at_ten_random_moments_it_ends_with_the_same_hash(tmp_path, request, where):
    command = [sys.executable, '-m', 'mobile_robot_control.benchmarking.command', '--laws', 'kanayama', 'periodic',
               '--tracks',
               'published', 'on_curve', '--budgets', '500', '--runs', '10', '--scenarios', '4', '--output']
    if where == 'dask':
        from distributed import LocalCluster  # an extra

        cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
        request.addfinalizer(cluster.close)
        where = ['--scheduler', cluster.scheduler_address]
    whole, killed = tmp_path / 'whole', tmp_path / 'killed'
    command, resumed = [*command, str(whole)], [*command, str(killed), *where, '--resume']
    subprocess.run(command, check=True, capture_output=True)
    rng, kills = random.Random(1), 0  # noqa: S311 (of moments)
    for _ in range(10):
        started = subprocess.Popen(resumed, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        # of 80 generations: however fast the machine is, ten kills leave some
        enough = generations(killed) + rng.randint(0, 5)
        while started.poll() is None and generations(killed) <= enough:
            time.sleep(0.05)
        time.sleep(rng.uniform(0.0, 0.2))
        kills += started.poll() is None
        started.kill()
        started.wait()
    assert kills >= 5
    subprocess.run(resumed, check=True, capture_output=True)
    assert hash_of(killed) == hash_of(whole)
