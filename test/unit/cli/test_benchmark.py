"""The command `benchmark`: its table, hash, files and exit codes, on a track so small that rollouts run plain."""

import contextlib
import csv
import json
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time

import pytest

from mobile_robot_control.api import benchmark_files
from mobile_robot_control.cli import benchmark
from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.configuration.sources import ParameterSources
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.parameters.declaration import flatten
from mobile_robot_control.plugins import register
from mobile_robot_control.simulation import batch
from mobile_robot_control.system.interrupt import Interrupt
from mobile_robot_control.tuning import benchmark_run
from mobile_robot_control.tuning.benchmark import Benchmark, BenchmarkRequest

TRACK = """
track: {ros__parameters: {purpose: A curve of a hand's breadth., curves: [trifolium], scales: [0.05],
    laps: 0.5}}
/**: {ros__parameters: {reference_horizon: 1, velocity_rate: 50.0, position_rate: 50.0}}
/**/plant: {ros__parameters: {drive: velocity}}
/**/reference_cart: {ros__parameters: {curve: trifolium, scale: 0.05, period: 1.0}}
"""
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
SMALL = ['--budgets', '25', '--scenarios', '1', '--runs', '4', '--workers', '1']


@pytest.fixture(autouse=True)
def plain(monkeypatch, registered):
    monkeypatch.setattr(batch, 'COMPILES', False)


@pytest.fixture
def track(tmp_path):
    file = tmp_path / 'small.yaml'
    file.write_text(TRACK)
    return file


def run(track, folder, *arguments):
    return benchmark.main(['--tracks', str(track), '--output', str(folder), *SMALL, *map(str, arguments)])


def read(folder):
    with (folder / 'benchmark.csv').open() as file:
        return json.loads((folder / 'benchmark.json').read_text()), list(csv.DictReader(file))


def law_file(folder, name, failure='pass'):
    file = folder / f'{name}.py'
    file.write_text(LAW.format(name=name, failure=failure))
    return file


class _Stopped(Interrupt):
    """Asks to stop after so many generations."""

    def __init__(self, generations):
        self._left = generations
        super().__init__()

    @property
    def requested(self):
        self._left -= 1
        return self._left < 0

    @requested.setter
    def requested(self, value):
        pass


class _Bar(contextlib.nullcontext):
    """Adds up its updates."""

    def __init__(self, shown):
        super().__init__(self)
        self._shown = shown

    def update(self, count):
        self._shown[1] += count


def test_laws_are_searched_and_judged_and_the_same_seed_gives_the_same_hash(track, tmp_path, capsys):
    assert run(track, tmp_path / 'one', '--laws', 'kanayama', 'ramsete') == 0
    values, rows = read(tmp_path / 'one')
    assert f'hash {values["hash"]}' in capsys.readouterr().out
    assert [(row['law'], row['track'], row['runs']) for row in rows] == [
        (row['law'], 'small', '4') for row in values['results']]
    assert {row['law'] for row in rows} == {'kanayama', 'ramsete'}
    for row in values['results']:
        assert set(row['gains']) == {f'position_controller.{row["law"]}.{name}' for name in (
            ('kx', 'ky', 'ktheta') if row['law'] == 'kanayama' else ('b', 'zeta'))}
        assert row['successes'] == row['shared'] == 4
        assert 0.0 < row['rms'] <= row['rms_95'] <= row['worst']
        assert row['peak_wheel_torque'] is None
        assert row['step_time'] > 0.0
    page = (tmp_path / 'one' / 'benchmark.html').read_text()
    assert values['hash'] in page
    assert page.count('class="sortable"') == 2
    # elsewhere, later, with another name of the folder
    assert run(track, tmp_path / 'two', '--laws', 'kanayama', 'ramsete') == 0
    assert read(tmp_path / 'two')[0]['hash'] == values['hash']
    assert run(track, tmp_path / 'three', '--laws', 'kanayama', 'ramsete', '--seed', 2) == 0
    assert read(tmp_path / 'three')[0]['hash'] != values['hash']


def test_a_law_of_a_file_ranks_beside_the_shipped_ones_and_those_that_fail_come_last_with_their_reason(
    track, tmp_path, capsys
):
    assert run(track, tmp_path / 'out', '--laws', 'kanayama', 'raises', 'mine', 'empty', *(
        word for file in (law_file(tmp_path, 'mine'), law_file(tmp_path, 'raises', "raise ValueError('no answer')"),
                          law_file(tmp_path, 'empty', "v = float('nan')")) for word in ('--law', file)),
        # so long that a search in which all fail ends before
        '--budgets', 100) == 0
    values, _ = read(tmp_path / 'out')
    rows = {row['law']: row for row in values['results'] if row['budget'] == 100}
    assert list(rows)[2:] == ['raises', 'empty']
    assert rows['mine']['successes'] == 4
    assert rows['mine']['rank'] <= 2 >= rows['kanayama']['rank']
    assert (rows['raises']['rank'], rows['empty']['last_rank']) == (3, 4)
    assert 'no answer' in rows['raises']['reason']
    assert 'not finite' in rows['empty']['reason']
    assert 'no answer' in (tmp_path / 'out' / 'benchmark.html').read_text()


def test_what_a_folder_holds_is_kept_unless_asked(track, tmp_path, capsys):
    assert run(track, tmp_path / 'out', '--laws', 'ramsete', '--no-tune') == 0
    values, _ = read(tmp_path / 'out')
    assert values['budgets'] == []
    configured = flatten(configure({}).position_controller.control.ramsete)
    assert values['results'][0]['gains'] == {f'position_controller.ramsete.{name}': value
                                             for name, value in configured.items()}
    assert run(track, tmp_path / 'out', '--laws', 'ramsete', '--no-tune') == 2
    assert '--resume' in capsys.readouterr().err
    # nothing is run again, and another law is added
    before = {file: file.stat().st_mtime_ns for file in (tmp_path / 'out' / 'cells').iterdir()}
    assert run(track, tmp_path / 'out', '--laws', 'ramsete', 'kanayama', '--no-tune', '--resume') == 0
    assert all(file.stat().st_mtime_ns == time_ns for file, time_ns in before.items())
    assert len(read(tmp_path / 'out')[1]) == 2


def test_a_longer_search_begins_with_the_shorter_one(track, tmp_path):
    folders = {budgets: tmp_path / '_'.join(budgets) for budgets in (('25',), ('50',), ('25', '50'))}
    for budgets, folder in folders.items():
        assert run(track, folder, '--laws', 'ramsete', '--budgets', *budgets) == 0
    found = {budgets: {row['budget']: row['gains'] for row in read(folder)[0]['results']}
             for budgets, folder in folders.items()}
    # the first option is 25 in each
    assert found[('25', '50')][50] == found[('50',)][50]
    assert found[('25', '50')][25] == found[('25',)][25]


def test_training_and_judging_have_no_scenario_in_common_and_are_those_of_every_law(track):
    cells = Benchmark(BenchmarkRequest(ParameterSources(), ('kanayama', 'lqr'), (str(track), 'noise', 'delay'))).cells
    for first, second in zip(cells[:3], cells[3:], strict=True):
        training, judging = (first.drawn(use, first.configuration(), 50) for use in ('training', 'judging'))
        assert not set(training) & set(judging)
        assert judging == second.drawn('judging', second.configuration(), 50)
        assert training == second.drawn('training', second.configuration(), 50)
    assert {one.delay for one in cells[2].drawn('judging', cells[2].configuration(), 50)} == {1, 2}


def test_an_interrupted_benchmark_goes_on_to_the_same_hash(track, tmp_path, monkeypatch, capsys):
    laws = ['--laws', 'kanayama', 'ramsete', '--budgets', '50']
    assert run(track, tmp_path / 'whole', *laws) == 0
    whole = read(tmp_path / 'whole')[0]['hash']
    for generations in (1, 3):
        monkeypatch.setattr(benchmark_files, 'Interrupt', lambda generations=generations: _Stopped(generations))
        assert run(track, tmp_path / 'stopped', *laws, '--resume') == 1
        assert '--resume goes on' in capsys.readouterr().err
        assert not (tmp_path / 'stopped' / 'benchmark.json').exists()
    monkeypatch.undo()
    monkeypatch.setattr(batch, 'COMPILES', False)
    assert run(track, tmp_path / 'stopped', *laws, '--resume') == 0
    assert read(tmp_path / 'stopped')[0]['hash'] == whole


def test_two_processes_give_the_hash_of_one_also_where_a_law_came_by_hand_and_after_an_interrupt(
    track, tmp_path, monkeypatch, capsys
):
    register(LAWS['kanayama']._replace(name='by_hand'))
    laws = ['--laws', 'kanayama', 'by_hand', 'ramsete']
    assert run(track, tmp_path / 'one', *laws) == 0
    ends = []
    monkeypatch.setattr(benchmark_files, 'tqdm', lambda total, **_: ends.append([total, 0]) or _Bar(ends[-1]))
    monkeypatch.setattr(benchmark_files, 'Interrupt', lambda: _Stopped(0))
    assert run(track, tmp_path / 'two', *laws, '--workers', 2) == 1
    assert 'after 0 of 3 cells' in capsys.readouterr().err
    monkeypatch.setattr(benchmark_files, 'Interrupt', Interrupt)
    assert run(track, tmp_path / 'two', *laws, '--workers', 2, '--resume') == 0
    assert ends[-1][0] == ends[-1][1]
    assert multiprocessing.active_children() == []
    assert read(tmp_path / 'two')[0]['hash'] == read(tmp_path / 'one')[0]['hash']


@pytest.mark.parametrize(('end', 'told'), [
    (lambda *_: (_ for _ in ()).throw(ParameterError(['a journal is damaged'])), 'a journal is damaged'),
    (lambda *_: os.kill(os.getpid(), signal.SIGKILL), 'fewer --workers'),
])
def test_an_error_in_a_process_and_its_death_are_told(track, tmp_path, monkeypatch, capsys, end, told):
    monkeypatch.setattr(benchmark_run, 'run_cell', end)
    assert run(track, tmp_path / 'out', '--laws', 'kanayama', 'ramsete', '--workers', 2) == 2
    assert told in capsys.readouterr().err


def test_processes_end_with_a_parent_that_is_killed(track, tmp_path):
    """They would go on with the journals of the next benchmark."""
    code = ('import os, sys, time; from mobile_robot_control.cli import benchmark; '
            'from mobile_robot_control.tuning import benchmark_run; '
            'benchmark_run.run_cell = lambda *_: os.write(1, b"%d\\n" % os.getpid()) and time.sleep(600); '
            'benchmark.main(sys.argv[1:])')
    parent = subprocess.Popen(
        [sys.executable, '-c', code, '--tracks', str(track), '--output', str(tmp_path / 'out'), '--laws', 'kanayama',
         'ramsete', *SMALL, '--workers', '2'], stdout=subprocess.PIPE, text=True)
    with parent:
        workers = [int(parent.stdout.readline()) for _ in range(2)]
        assert parent.pid not in workers
        parent.kill()
        # all that write to the pipe have ended
        assert parent.stdout.read() == ''


@pytest.mark.parametrize(('arguments', 'told'), [
    (['--robot', 'kobuki'], 'each track names its robot'),
    (['--tracks', 'rectangel'], "did you mean 'rectangle'?"),
    (['--laws', 'lqrr'], 'lqrr'),
    (['--verify'], 'holds no benchmark'),
])
def test_what_cannot_be_compared_is_refused(track, tmp_path, capsys, arguments, told):
    with pytest.raises(SystemExit) if '--laws' in arguments else pytest.MonkeyPatch.context():
        assert run(track, tmp_path / 'out', *arguments) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(('text', 'told'), [
    ('/**: {ros__parameters: {velocity_rate: 100.0}}', "has no section 'track'"),
    ('track: {ros__parameters: {within: 1.0}}\n/**: {ros__parameters: {velocity_rate: 100.0}}', 'purpose is missing'),
    ('track: {ros__parameters: {purpose: x, wihtin: 1.0}}', "did you mean 'within'?"),
])
def test_a_track_with_a_mistake_is_refused_by_name(tmp_path, text, told):
    file = tmp_path / 'odd.yaml'
    file.write_text(text)
    with pytest.raises(ParameterError, match=r'odd\.yaml') as error:
        Benchmark(BenchmarkRequest(ParameterSources(), tracks=(str(file),)))
    assert told in str(error.value)


def test_python_returns_the_same_table(track, tmp_path):
    assert run(track, tmp_path / 'out', '--laws', 'ramsete') == 0
    from mobile_robot_control import benchmark as compared

    found = compared(laws=['ramsete'], tracks=[track], budgets=[25], scenarios=1, runs=4, workers=1)
    assert found.hash == read(tmp_path / 'out')[0]['hash']
    assert found.hash in repr(found)
    assert list(found.to_dataframe()['law']) == ['ramsete']
    assert found.hash in found.report(tmp_path / 'page').html


def generations(folder):
    """Count those that were scored, of finished cells and of those begun."""
    found = 20 * len([*folder.glob('cells/*.json')])
    for file in folder.glob('cells/*.journal'):
        # that of a cell which ends now
        with contextlib.suppress(FileNotFoundError):
            found += file.read_bytes().count(b'\n') - 1
    return found


@pytest.mark.soak
@pytest.mark.timeout(1800)
@pytest.mark.parametrize('where', [['--workers', '1'], ['--workers', '2'], 'dask'])
def test_killed_at_ten_random_moments_it_ends_with_the_same_hash(tmp_path, where):
    command = [sys.executable, '-m', 'mobile_robot_control.cli.benchmark', '--laws', 'kanayama', 'periodic', '--tracks',
               'published', 'on_curve', '--budgets', '500', '--runs', '10', '--scenarios', '4']
    if where == 'dask':
        from distributed import LocalCluster  # an extra

        cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
        where = ['--scheduler', cluster.scheduler_address]
    subprocess.run([*command, '--output', str(tmp_path / 'whole')], check=True, capture_output=True)
    rng, kills = random.Random(1), 0  # noqa: S311 (of moments)
    for _ in range(10):
        started = subprocess.Popen([*command, *where, '--output', str(tmp_path / 'killed'), '--resume'],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        # of 80 generations: however fast the machine is, ten kills leave some
        enough = generations(tmp_path / 'killed') + rng.randint(0, 5)
        while started.poll() is None and generations(tmp_path / 'killed') <= enough:
            time.sleep(0.05)
        time.sleep(rng.uniform(0.0, 0.2))
        kills += started.poll() is None
        started.kill()
        started.wait()
    assert kills >= 5
    subprocess.run([*command, *where, '--output', str(tmp_path / 'killed'), '--resume'], check=True,
                   capture_output=True)
    assert read(tmp_path / 'killed')[0]['hash'] == read(tmp_path / 'whole')[0]['hash']
