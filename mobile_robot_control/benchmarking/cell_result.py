"""The result of one cell of a benchmark: searches, judged runs and a picture; its form as a file."""

import json
import math
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.benchmarking.cell import Cell
from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.loop.monte_carlo import JudgedRuns
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.search.gains import Gains, configured_gains
from mobile_robot_control.system.files import FileKind, parse_json, read_bounded, write_atomically

JUDGED = ('rms_position_error', 'max_position_error', 'settling_time', 'peak_wheel_torque', 'energy',
          'torque_variation', 'command_variation')
"""The metrics that are kept of every run."""
SEARCHED, CONFIGURED, FED, OWN = 'searched', 'configured', 'feedforward', 'own'
"""Gains of a result: of a search, as configured, of a search with feedforward, and those of somebody else's node."""
NOT_SEARCHED = 'not searched'
"""First words of the reason of a result whose search could drive no candidate."""
_FILE = FileKind('cell', 1 << 30)


class RunColumns(NamedTuple):
    """
    What the unseen scenarios have shown, run by run.

    Attributes
    ----------
    success : list of bool
        Whether each succeeds.
    outcome : list of str
        Of each.
    metrics : dict of str to list of (float or None)
        Of each, by the names of JUDGED; None where there is none.
    """

    success: list[bool]
    outcome: list[str]
    metrics: dict[str, list[float | None]]

    def runs(self) -> JudgedRuns:
        """Return the judged runs; a value that is not known is infinite."""
        columns = {name: np.array([math.inf if value is None else value for value in self.metrics[name]])
                   for name in JUDGED}
        return JudgedRuns(np.array(self.success, bool), columns, np.array(self.outcome, str))


class SearchEnd(NamedTuple):
    """
    What a search has come to.

    Attributes
    ----------
    score : float
        Of the best gains.
    objectives : dict of str to float
        Their objectives by name.
    agreeing : int
        Searches with other seeds that end as well.
    repeated : list of float
        Scores of all of them.
    at_edge : list of str
        Gains at an edge of their bounds.
    """

    score: float
    objectives: dict[str, float]
    agreeing: int
    repeated: list[float]
    at_edge: list[str]


class BudgetResult(NamedTuple):
    """
    The result of a cell with one budget.

    Attributes
    ----------
    budget : int
        Candidates of the search; 0 without one.
    reason : str
        Why it has no successful run; '' where it has.
    search : SearchEnd or None
        None without a search that has found gains.
    gains : mapping of str to object
        Values by ``NODE.PARAMETER``.
    judged : RunColumns or None
        None where nothing was driven.
    """

    budget: int
    reason: str
    search: SearchEnd | None = None
    gains: Mapping[str, Any] = {}
    judged: RunColumns | None = None

    def runs(self, count: int) -> JudgedRuns | None:
        """Return its judged runs: none of gains that no search found, failures of a law that cannot run."""
        if self.judged is not None:
            return self.judged.runs()
        if not was_searched(self.reason):
            return None
        return JudgedRuns(np.zeros(count, bool), {name: np.full(count, math.inf) for name in JUDGED},
                          np.full(count, 'law_failed'))


class DrivenPath(NamedTuple):
    """Time [s], path, reference and error [m] of one run, thinned out for a picture."""

    time: list[float]
    x: list[float]
    y: list[float]
    reference_x: list[float]
    reference_y: list[float]
    error: list[float]


class CellResult(NamedTuple):
    """
    The result of a cell.

    Attributes
    ----------
    results : list of BudgetResult
        In the order of the budgets.
    configured : RunColumns or None
        Runs with the gains as configured, beside those searched.
    step_time : float or None
        Of one step of the law [s].
    path : DrivenPath or None
        Of the first unseen scenario.
    repeated : list of (float or None)
        RMS errors of a node that has driven that scenario several times [m]; None where a run failed. [] for a law.
    """

    results: list[BudgetResult]
    configured: RunColumns | None = None
    step_time: float | None = None
    path: DrivenPath | None = None
    repeated: Sequence[float | None] = ()


Done = list[tuple[Cell, CellResult]]
"""Cells with their results, as `run_cell` returns them."""


def was_searched(reason: str) -> bool:
    """Return whether a result with a reason is of gains: no search may have found any that can be driven."""
    return not reason.startswith(NOT_SEARCHED)


def kind_of_gains(cell: Cell) -> str:
    """Return the kind of the gains that a cell judges."""
    return OWN if cell.node else FED if cell.feedforward else SEARCHED if cell.budgets else CONFIGURED


def gains_of(cell: Cell, gains: Mapping[str, Any]) -> Gains:
    """Return the gains of a result, exactly as they were judged."""
    return configured_gains(cell.sources().with_values(gains).configuration())


def _columns_as_json(columns: RunColumns) -> dict[str, Any]:
    return {'success': columns.success, 'outcome': columns.outcome, **columns.metrics}


def _columns_of_json(content: Mapping[str, Any]) -> RunColumns:
    return RunColumns(content['success'], content['outcome'], {name: content[name] for name in JUDGED})


def as_json(result: CellResult) -> dict[str, Any]:
    """Return a result as the content of its file."""
    return {
        'results': [{
            'budget': each.budget, **(each.search._asdict() if each.search else {}),
            **({'gains': each.gains, **_columns_as_json(each.judged)} if each.judged else {}), 'reason': each.reason}
            for each in result.results],
        'configured': _columns_as_json(result.configured) if result.configured else None,
        'step_time': result.step_time, 'drawn': result.path._asdict() if result.path else None,
        **({'repeated': [*result.repeated]} if result.repeated else {})}


def _of_json(content: Mapping[str, Any]) -> CellResult:
    return CellResult(
        [BudgetResult(result['budget'], result['reason'],
                      SearchEnd(*(result[name] for name in SearchEnd._fields)) if 'score' in result else None,
                      result.get('gains', {}), _columns_of_json(result) if 'success' in result else None)
         for result in content['results']],
        _columns_of_json(content['configured']) if content['configured'] else None,
        content['step_time'], DrivenPath(**content['drawn']) if content['drawn'] else None,
        content.get('repeated', ()))


def write_result(file: Path, result: CellResult) -> None:
    """Write the result of a cell, with its checksum."""
    content = as_json(result)
    write_atomically(file, json.dumps({'arithmetic': ARITHMETIC, 'checksum': _checksum(content), 'cell': content}))


def read_result(file: Path) -> CellResult:
    """Read the result of a cell; raise OSError or ValueError if it is not one that was written."""
    content = _content(file)['cell']
    try:
        return _of_json(content)
    except (KeyError, TypeError) as error:  # of another version
        raise ValueError(f'it has no {error}') from error


def check_arithmetic(file: Path) -> None:
    """Raise ParameterError if a cell was computed with another arithmetic."""
    try:
        arithmetic = _content(file).get('arithmetic', 1)
    except (OSError, ValueError):  # damaged: told where it is needed
        return
    if arithmetic != ARITHMETIC:
        raise ParameterError([f'{file}: was computed with arithmetic {arithmetic}, and this program has {ARITHMETIC}: '
                              'their last bits differ; --overwrite begins anew, or name another --output'])


def _content(file: Path) -> dict[str, Any]:
    content = parse_json(read_bounded(file, _FILE))
    if not isinstance(content, dict) or content.get('checksum') != _checksum(content.get('cell')):
        raise ValueError('its checksum is wrong')
    return content


def _checksum(content: object) -> int:
    return zlib.crc32(json.dumps(content).encode())
