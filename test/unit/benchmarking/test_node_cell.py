"""Nodes of somebody else in a benchmark: what is refused, how a cell grows run by run, and their rows in a table."""

import json
import sys

import numpy as np
import pytest
from helpers.small_benchmark import TRACK, read, run

from mobile_robot_control.benchmarking import command as benchmark
from mobile_robot_control.benchmarking.cell_result import JUDGED, read_result, write_result
from mobile_robot_control.benchmarking.judged_table import NAME, read_judged_table
from mobile_robot_control.benchmarking.node_cell import (
    NOTHING,
    REPETITIONS,
    NodeRequest,
    NodeRun,
    next_run,
    of_budgets,
    with_run,
)
from mobile_robot_control.benchmarking.ranking import pairs_of
from mobile_robot_control.benchmarking.request import Benchmark, BenchmarkRequest
from mobile_robot_control.loop.monte_carlo import JudgedRuns
from mobile_robot_control.settings.configure import ParameterSources

PYTHON = sys.executable
TOLD = '(node, not tuned)'


def node_run(error):
    return NodeRun(error is not None, 'completed' if error else 'node_died', dict.fromkeys(JUDGED, error),
                   '' if error else 'position_controller ended')


def cell_of(track, node_runs, seeds=(1,)):
    chosen = Benchmark(BenchmarkRequest(ParameterSources(), ('lqr',), (str(track),), tune=False, seeds=seeds),
                       NodeRequest((('mine', (PYTHON,)),), node_runs))
    return next(cell for cell in chosen.cells if cell.node)


def driven(cell, result, errors):
    """Add runs with errors in the order in which they are asked for; return it with the numbers of scenarios."""
    numbers = []
    for error in errors:
        numbers.append(next_run(cell, result))
        result = with_run(result, numbers[-1], node_run(error))
    return result, numbers


@pytest.mark.parametrize(('given', 'told'), [
    (['mine'], "write NAME=COMMAND, such as mine='python my_node.py'"),
    (['plant=x'], 'experiment --node drives a plant'), (['a b=x'], "'a b' is no name of a row"),
    (['lqr=python'], '--node lqr: there is a law of that name'), (['mine=python', 'mine=python'], 'is given twice'),
    (['mine=no_such_program'], "--node mine: there is no program 'no_such_program'"),
])
def test_what_cannot_be_a_row_is_refused_before_anything_runs(track, tmp_path, capsys, given, told):
    try:
        code = run(track, tmp_path / 'out', *(word for one in given for word in ('--node', one)))
    except SystemExit as ended:
        code = ended.code
    assert code == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / 'out').exists()


def test_a_track_whose_nodes_are_not_in_lockstep_is_refused_by_name(track, tmp_path, capsys):
    track.write_text(f'{TRACK}\n/**/*: {{ros__parameters: {{lockstep: false}}}}')
    assert run(track, tmp_path / 'out', '--node', f'mine={PYTHON}', '--laws', 'lqr', '--no-tune') == 2
    assert "--node: the track 'small' has lockstep = false" in capsys.readouterr().err


def test_the_runs_of_a_node_are_divided_among_the_seeds(track):
    assert [cell_of(track, runs, range(1, seeds + 1)).runs for runs, seeds in ((20, 1), (20, 3), (2, 5), (900, 5))] == [
        20, 7, 1, 100]


def test_a_node_whose_first_scenario_comes_out_the_same_again_drives_the_others_once(track):
    cell = cell_of(track, 3)
    result, numbers = driven(cell, NOTHING, [0.1, 0.1, 0.2, 0.3])
    assert (numbers, next_run(cell, result)) == ([0, 0, 1, 2], None)
    assert result.results[0].judged.metrics['rms_position_error'] == [0.1, 0.2, 0.3]
    assert result.repeated == [0.1, 0.1]


def test_a_node_that_is_not_exact_repeats_its_first_scenario(track):
    result, numbers = driven(cell_of(track, 2), NOTHING, [0.1, 0.2, None, 0.1, 0.1, 0.3])
    assert numbers == [*[0] * REPETITIONS, 1]
    assert result.repeated == [0.1, 0.2, None, 0.1, 0.1]


def test_only_a_node_without_any_success_has_a_reason(track):
    cell = cell_of(track, 2, (1, 2))._replace(runs=2, repeats=False)
    for errors, reason in (([None, None], 'position_controller ended'), ([None, 0.1], ''), ([0.1, None], '')):
        assert driven(cell, NOTHING, errors)[0].results[0].reason == reason


def test_a_cell_with_fewer_runs_goes_on_and_one_with_more_gives_the_first(track, tmp_path):
    few, many = cell_of(track, 2), cell_of(track, 4)
    assert few.file(tmp_path) == many.file(tmp_path)
    write_result(few.file(tmp_path), driven(few, NOTHING, [0.1, 0.1, 0.2])[0])
    held = read_result(few.file(tmp_path))
    assert (next_run(few, held), next_run(many, held)) == (None, 2)
    whole, _ = driven(many, held, [0.3, 0.4])
    both = of_budgets(few._replace(budgets=(25, 50)), whole).results
    assert [one.budget for one in both] == [25, 50]
    assert [one.judged.metrics['rms_position_error'] for one in both] == [[0.1, 0.2]] * 2


def test_a_node_is_compared_in_the_scenarios_that_it_has_driven():
    def runs(*errors):
        return JudgedRuns(np.array([error is not None for error in errors]), {
            'rms_position_error': np.array([error or np.inf for error in errors])}, np.array(errors, str))

    pair, = pairs_of({'law': {1: runs(0.1, 0.2, 9.0), 2: runs(None, 0.1, 0.1)}, 'node': {1: runs(0.2, 0.4),
                                                                                     2: runs(0.1, 0.2)}})
    assert pair.errors == (pytest.approx(-np.log(2.0)),) * 2
    assert pair.successes == (0.0, -0.5)


@pytest.fixture
def instant(monkeypatch):
    """Nodes that drive in no time, with the error of the scenario's number and seed."""
    from mobile_robot_control.benchmarking import node_runs

    asked = []

    def drive_run(cell, n, folder, stop):
        asked.append((cell.name, cell.seed, n))
        return node_run(0.001 * (n + cell.seed))

    monkeypatch.setattr(node_runs, 'drive_run', drive_run)
    return asked


def test_a_node_has_a_row_a_rank_and_a_note_in_every_file(track, tmp_path, capsys, instant):
    words = ['--laws', 'lqr', 'ramsete', '--no-tune', '--seeds', 1, 2, 3]
    node = ['--node', f'mine={PYTHON} x.py', '--node-runs', 6]
    assert run(track, tmp_path / 'whole', *words, *node) == 0
    assert len(instant) == 6 + 1
    values, rows = read(tmp_path / 'whole')
    assert [(row['law'], row['gains'], row['runs']) for row in rows][-3:] == [('mine', 'own', '2')] * 3
    ranked = next(row for row in values['ranks'] if row['law'] == 'mine')
    assert (ranked['rank'], ranked['seeds'], ranked['rms']) == (1, 3, 0.002)
    assert values['nodes']['mine']['repeated'] == {'small': [0.001, 0.001]}
    page = (tmp_path / 'whole' / 'benchmark.html').read_text()
    printed = capsys.readouterr().out
    for text in (f'mine {TOLD}: driven over DDS in 2 scenarios of each seed; a repeated run', f'mine {TOLD}'):
        assert text in printed
        assert text in page
    # against the table of the laws alone, the same pairs
    assert run(track, tmp_path / 'laws', *words) == 0
    table = tmp_path / 'laws' / NAME
    added = ['--tracks', str(track), '--output', str(tmp_path / 'added'), '--against', str(table), *map(str, node)]
    assert benchmark.main(added) == 0
    other = json.loads((tmp_path / 'added' / 'benchmark.json').read_text())
    assert other['pairs'] == values['pairs']
    assert {row['law'] for row in other['results']} == {'mine'}
    assert f'mine {TOLD} ranks among 3 laws: small 1' in capsys.readouterr().out
    both = [read_judged_table(tmp_path / folder / NAME) for folder in ('whole', 'added')]
    assert both[1]._replace(hash=both[0].hash) == both[0]
    # a table with a node ranks further rows
    again = ['--tracks', str(track), '--output', str(tmp_path / 'more'), '--against', str(tmp_path / 'added' / NAME)]
    assert benchmark.main([*again, '--node', f'mine={PYTHON}']) == 2
    assert "the table has a law 'mine' already" in capsys.readouterr().err
    assert benchmark.main([*again, '--node', f'other={PYTHON}', '--node-runs', '3']) == 0
    assert f'mine {TOLD}: unbeaten' in capsys.readouterr().out


def test_every_run_of_a_node_is_kept_when_it_is_interrupted(track, tmp_path, capsys, instant, monkeypatch):
    from mobile_robot_control.benchmarking import node_runs

    words = ['--laws', 'lqr', '--no-tune', '--node', f'mine={PYTHON}', '--node-runs', 3, '--resume']
    whole = node_runs.drive_run
    monkeypatch.setattr(node_runs, 'drive_run', lambda cell, n, *more: whole(cell, n, *more) if n < 2 else None)
    assert run(track, tmp_path / 'out', *words) == 1
    assert 'benchmark: interrupted, after 1 of 2 cells; --resume goes on' in capsys.readouterr().err
    monkeypatch.setattr(node_runs, 'drive_run', whole)
    instant.clear()
    assert run(track, tmp_path / 'out', *words) == 0
    assert instant == [('mine', 1, 2)]
