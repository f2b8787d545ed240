"""Cells of a benchmark side by side, in processes or on a GPU."""

import contextlib
import multiprocessing
import os
import signal
import subprocess
import sys

import pytest
from helpers.small_benchmark import SMALL, Stopped, hash_of, read, run

from mobile_robot_control.benchmarking import command as benchmark
from mobile_robot_control.benchmarking import side_by_side
from mobile_robot_control.benchmarking.request import Benchmark, BenchmarkRequest
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.loop import batch
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.parameters.plugins import register
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.system.process import Interrupt


class _Bar(contextlib.nullcontext):
    """Adds up its updates."""

    def __init__(self, shown):
        super().__init__(self)
        self._shown = shown

    def update(self, count):
        self._shown[1] += count


def test_two_processes_give_the_hash_of_one_also_where_a_law_came_by_hand_and_after_an_interrupt(
    track, tmp_path, monkeypatch, capsys
):
    register(LAWS['kanayama']._replace(name='by_hand'))
    laws = ['--laws', 'kanayama', 'by_hand', 'ramsete']
    assert run(track, tmp_path / 'one', *laws) == 0
    ends = []
    monkeypatch.setattr(benchmark, 'StagedBar', lambda total, *_, **__: ends.append([total, 0]) or _Bar(ends[-1]))
    monkeypatch.setattr(benchmark, 'Interrupt', lambda: Stopped(0))
    assert run(track, tmp_path / 'two', *laws, '--workers', 2) == 1
    assert 'after 0 of 3 cells' in capsys.readouterr().err
    monkeypatch.setattr(benchmark, 'Interrupt', Interrupt)
    assert run(track, tmp_path / 'two', *laws, '--workers', 2, '--resume') == 0
    assert ends[-1][0] == ends[-1][1]
    assert multiprocessing.active_children() == []
    assert hash_of(tmp_path / 'two') == hash_of(tmp_path / 'one')


class _Device:
    """Runs what threads ask for together, as a GPU does."""

    def __init__(self, fails=()):
        self.asked, self._fails = [], fails

    def together(self, several):
        self.asked.append(len(several))
        if len(self.asked) in self._fails:
            raise ParameterError(['the law does not compile'])
        return [batch.run_trials(one) for one in several]


def test_cells_that_share_the_launches_of_a_gpu_give_the_hash_of_one_after_another(track, tmp_path):
    words = ['--laws', 'kanayama', 'ramsete', '--seeds', '1', '2', '3', '--restarts', '2', '--feedforward']
    assert run(track, tmp_path / 'one', *words) == 0
    request = BenchmarkRequest(ParameterSources(), ('kanayama', 'ramsete'), (str(track),), seeds=(1, 2, 3), restarts=2,
                               feedforward=True, budgets=(25,), scenarios=1, runs=4)
    asked, device, shown = Benchmark(request), _Device(), []
    side_by_side.run_together(asked.cells, device, tmp_path / 'one' / 'cells', shown.append, lambda: False)
    assert (device.asked, sum(shown)) == ([0, 0], asked.rollouts)
    folder = tmp_path / 'two' / 'cells'
    folder.mkdir(parents=True)
    with pytest.raises(ParameterError, match='does not compile'):
        side_by_side.run_together(asked.cells, _Device(fails=(2,)), folder, shown.append, lambda: False)
    side_by_side.run_together(asked.cells, device, folder, shown.append, lambda: False)
    assert max(device.asked) == 6
    assert run(track, tmp_path / 'two', *words, '--resume') == 0
    assert hash_of(tmp_path / 'one') == hash_of(tmp_path / 'two')
    values, _ = read(tmp_path / 'two')
    for row in values['ranks']:
        assert row['converged'] <= row['seeds'] == 3
        assert min(row['configured_success'], row['feedforward_success']) > 0.0


def _damaged(*_):
    raise ParameterError(['a journal is damaged'])


@pytest.mark.parametrize(('end', 'told'), [
    (_damaged, 'a journal is damaged'), (lambda *_: os.kill(os.getpid(), signal.SIGKILL), 'fewer --workers')])
def test_an_error_in_a_process_and_its_death_are_told(track, tmp_path, monkeypatch, capsys, end, told):
    monkeypatch.setattr(side_by_side, 'run_cell', end)
    assert run(track, tmp_path / 'out', '--laws', 'kanayama', 'ramsete', '--workers', 2) == 2
    assert told in capsys.readouterr().err


def test_processes_end_with_a_parent_that_is_killed(track, tmp_path):
    """They would go on with the journals of the next benchmark."""
    code = ('import os, sys, time; from mobile_robot_control.benchmarking import command; '
            'from mobile_robot_control.benchmarking import side_by_side; '
            'side_by_side.run_cell = lambda *_: os.write(1, b"%d\\n" % os.getpid()) and time.sleep(600); '
            'command.main(sys.argv[1:])')
    with subprocess.Popen(
            [sys.executable, '-c', code, '--tracks', str(track), '--output', str(tmp_path / 'out'), '--laws',
             'kanayama', 'ramsete', *SMALL, '--workers', '2'], stdout=subprocess.PIPE, text=True) as parent:
        workers = [int(parent.stdout.readline()) for _ in range(2)]
        assert parent.pid not in workers
        parent.kill()
        # all that write to the pipe have ended
        assert parent.stdout.read() == ''
