"""Position controllers of somebody else in a benchmark: what is asked for, and the result of a cell, run by run."""

import re
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NamedTuple

from mobile_robot_control.benchmarking.cell import Cell
from mobile_robot_control.benchmarking.cell_result import JUDGED, BudgetResult, CellResult, DrivenPath, RunColumns
from mobile_robot_control.benchmarking.ranking import RANKED
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.experiment.foreign_nodes import ForeignNode, missing_program, read_command, started_node
from mobile_robot_control.parameters.declaration import Field, ParameterError
from mobile_robot_control.parameters.requests import Reader
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.settings.tracks import Track

NODE = 'position_controller'
"""The node whose place a command takes."""
REPETITIONS = 5
"""Runs of one scenario by a node that two of them have shown not to be exact."""
NOTHING = CellResult([BudgetResult(0, '', judged=RunColumns([], [], {name: [] for name in JUDGED}))])
"""The result of a node before its first run."""


def _read_row(value: Any) -> tuple[str, tuple[str, ...]]:
    """Read NAME=COMMAND with the name of a row; raise ValueError with a remedy."""
    name, words = read_command(value, 'mine')
    if name in NODES and name != NODE:
        raise ValueError(f'a benchmark drives position controllers, and NAME is the name of their row; experiment '
                         f'--node drives a {name}')
    if not re.fullmatch(r'[A-Za-z0-9][A-Za-z0-9_.-]*', name, re.ASCII):
        raise ValueError(f"'{name}' is no name of a row; take letters, digits and _ . - alone")
    return name, words


class NodeRequest(NamedTuple):
    """The nodes of somebody else that a benchmark is asked for."""

    node: Annotated[tuple[tuple[str, tuple[str, ...]], ...], Field(
        '', 'command of a position controller of your own, a node; NAME is its row'),
        Reader(_read_row, 'NAME=COMMAND', again=True, example="mine='python my_node.py'")] = ()
    node_runs: Annotated[int, Field('', 'scenarios that judge a node on each track, divided among the seeds; a run '
                                    'takes some seconds', minimum=1)] = 20

    def nodes(self) -> dict[str, ForeignNode]:
        """Return the nodes by the names of their rows; raise ParameterError for what cannot be in a table."""
        names = [name for name, _ in self.node]
        faults = [f'--node {name} is given twice; each row has a name of its own' for name in sorted(
            {name for name in names if names.count(name) > 1})]
        faults += [f'--node {name}: there is a law of that name; take another one' for name in names if name in LAWS]
        faults += [fault for name, words in self.node for fault in missing_program(name, words)]
        if faults:
            raise ParameterError(faults)
        return {name: started_node(words) for name, words in self.node}

    def runs(self, seeds: int, most: int) -> int:
        """Return the scenarios of a cell, one at least, where a track has so many seeds and scenarios of each."""
        return min(-(-self.node_runs // seeds), most)


def refuse_tracks(tracks: Sequence[Track], more: Any) -> None:
    """Raise ParameterError for tracks whose nodes would not run in lockstep."""
    violations = [
        f"--node: the track '{track.name}' has lockstep = false, and its runs could not be compared with those of "
        'laws; change it there, or leave the track out'
        for track in tracks if not track.sources(more).configuration().plant.shared.lockstep]
    if violations:
        raise ParameterError(violations)


class NodeRun(NamedTuple):
    """
    A run of somebody else's node.

    Attributes
    ----------
    success : bool
        As of a law.
    outcome : str
        'completed', 'diverged' or 'node_died'.
    metrics : mapping of str to (float or None)
        By the names of JUDGED; None where there is none.
    reason : str
        Why it failed; '' where it is complete.
    path : DrivenPath or None
        None without a sample.
    """

    success: bool
    outcome: str
    metrics: Mapping[str, float | None]
    reason: str = ''
    path: DrivenPath | None = None


def next_run(cell: Cell, result: CellResult) -> int | None:
    """Return the number of the scenario that a node drives next, from 0 on; None where its cell is done."""
    driven, errors = len(_columns(result).success), result.repeated
    # of two runs of a scenario that differ, more show by how much
    again = len(errors) < 2 or (len(set(errors)) > 1 and len(errors) < REPETITIONS)
    if cell.repeats and driven and again:
        return 0
    return driven if driven < cell.runs else None


def missing_runs(cell: Cell, result: CellResult) -> int:
    """Return how many runs a node has still to drive, as far as its runs are exact."""
    return max(cell.runs - len(_columns(result).success), 0) + max(2 * cell.repeats - len(result.repeated), 0) - (
        cell.repeats and not result.repeated)


def with_run(result: CellResult, n: int, run: NodeRun) -> CellResult:
    """Return a result with a further run, of a new scenario or of the first one again."""
    columns = _columns(result)
    if n == 0:
        result = result._replace(repeated=[*result.repeated, run.metrics[RANKED]])
    if n < len(columns.success):
        return result
    columns = RunColumns([*columns.success, run.success], [*columns.outcome, run.outcome],
                         {name: [*columns.metrics[name], run.metrics[name]] for name in JUDGED})
    reason = '' if any(columns.success) else result.results[0].reason or run.reason
    return result._replace(results=[BudgetResult(0, reason, judged=columns)], path=result.path or run.path)


def of_budgets(cell: Cell, result: CellResult) -> CellResult:
    """Return the result of a node as that of each budget, with the runs that its cell asks for."""
    only, columns = result.results[0], _columns(result)
    judged = RunColumns(columns.success[:cell.runs], columns.outcome[:cell.runs],
                        {name: column[:cell.runs] for name, column in columns.metrics.items()})
    return result._replace(results=[only._replace(budget=budget, judged=judged) for budget in cell.budgets or (0,)])


def _columns(result: CellResult) -> RunColumns:
    judged = result.results[0].judged
    assert judged is not None  # noqa: S101 (for mypy: NOTHING has columns, too)
    return judged
