"""The judged runs of a benchmark as files: one with all, and one against which further laws are ranked."""

import csv
import gzip
import io
import json
import math
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.benchmarking.cell import Cell
from mobile_robot_control.benchmarking.cell_result import (
    CONFIGURED,
    FED,
    JUDGED,
    OWN,
    SEARCHED,
    Done,
    kind_of_gains,
)
from mobile_robot_control.benchmarking.ranking import RANKED
from mobile_robot_control.elementary import ARITHMETIC
from mobile_robot_control.loop.monte_carlo import JudgedRuns
from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.settings.configure import ParameterSources
from mobile_robot_control.settings.tracks import Track
from mobile_robot_control.system.files import FileKind, parse_json, read_bounded, write_atomically

NAME = 'benchmark_table.json.gz'
"""The file of a table."""
RUN_COLUMNS = ('track', 'law', 'gains', 'seed', 'budget', 'run', 'curve', 'scale', 'start_x', 'start_y',
               'start_heading', 'mass', 'friction', 'delay', 'noise_seed', 'success', 'outcome', *JUDGED)
"""Of `benchmark_runs.csv`."""
_PACKED, _UNPACKED = FileKind('table of judged runs', 1 << 24), 1 << 25


class JudgedTable(NamedTuple):
    """
    The judged runs of a benchmark.

    Attributes
    ----------
    arithmetic : int
        Of all numbers.
    hash : str
        Of the benchmark.
    budgets : tuple of int
        Candidates of its searches; () where gains were taken as configured.
    restarts, scenarios, runs : int
        Searches of a cell, scenarios of a search, and those that judge.
    tracks : dict of str to dict
        By name: `content`, digits that change with the track; `objective` of its searches; `seeds`.
    horizons : dict of str to int
        Of the laws that look ahead, by name [position ticks].
    results : list of dict
        `track`, `law`, `gains`, `seed`, `budget`; `success` (1 or 0) and `rms` [m] of each judged run, null where there
        is none; of a node, of the first runs.
    """

    arithmetic: int
    hash: str
    budgets: tuple[int, ...]
    restarts: int
    scenarios: int
    runs: int
    tracks: dict[str, dict[str, Any]]
    horizons: dict[str, int]
    results: list[dict[str, Any]]

    @property
    def laws(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(dict.fromkeys(one['law'] for one in self.results))

    def judged(self, track: str, budget: int) -> dict[str, dict[int, JudgedRuns]]:
        """Return the judged runs of a track, without feedforward, by law and seed; a law not searched has none."""
        by_law: dict[str, dict[int, JudgedRuns]] = {}
        for result in self.results:
            if (result['track'], result['budget']) == (track, budget) and result['gains'] != FED:
                own = by_law.setdefault(result['law'], {})
                runs = runs_of(result)
                if runs is not None:
                    own[result['seed']] = runs
        return by_law


def runs_of(result: Mapping[str, Any]) -> JudgedRuns | None:
    """Return the judged runs of a result of a table; None where there are none."""
    if result['success'] is None:
        return None
    rms = np.array([math.inf if value is None else value for value in result['rms']])
    return JudgedRuns(np.array(result['success'], bool), {RANKED: rms}, np.full(len(rms), ''))


def content_digits(track: Track, more: ParameterSources) -> str:
    """Return digits that change with what a track is made of."""
    return sha256(json.dumps(track.content(more), sort_keys=True).encode()).hexdigest()[:16]


def horizons_of(cells: Iterable[Cell]) -> dict[str, int]:
    """Return the horizons of the laws of cells that declare one, by their names in the table."""
    return {cell.name: cell.horizon for cell in cells if cell.horizon}


def judged_table(done: Done, digits: str, earlier: JudgedTable | None = None) -> JudgedTable:
    """
    Return the judged runs of cells, one at least.

    Parameters
    ----------
    done : list of (Cell, CellResult)
        Cells with their results.
    digits : str
        Hash of the benchmark.
    earlier : JudgedTable or None
        That they were ranked against; the runs on its tracks that are theirs, too, become part of the table.
    """
    first = next(iter(done))[0]
    tracks: dict[str, dict[str, Any]] = {}
    horizons = horizons_of(cell for cell, _ in done)
    results = []
    for cell, cell_result in done:
        name = cell.track.name
        if name not in tracks:
            tracks[name] = {'content': content_digits(cell.track, cell.more), 'objective': cell.objective, 'seeds': []}
        tracks[name]['seeds'] = sorted({*tracks[name]['seeds'], cell.seed})
        for result in cell_result.results:
            judged = result.runs(cell.runs)
            results.append({
                'track': name, 'law': cell.name, 'gains': kind_of_gains(cell), 'seed': cell.seed,
                'budget': result.budget, 'success': None if judged is None else judged.success.astype(int).tolist(),
                'rms': None if judged is None else [value if math.isfinite(value) else None
                                                    for value in judged.metrics[RANKED].tolist()]})
    if earlier:
        results = [one for one in earlier.results if one['track'] in tracks] + results
        tracks = {name: earlier.tracks[name] for name in tracks}
        horizons = earlier.horizons | horizons
    return JudgedTable(
        arithmetic=ARITHMETIC, hash=digits, budgets=first.budgets, restarts=first.restarts, scenarios=first.training,
        runs=earlier.runs if earlier else max(cell.runs for cell, _ in done), tracks=tracks, horizons=horizons,
        results=results)


def write_judged_table(file: Path, table: JudgedTable) -> None:
    """Write judged runs; the same runs give the same bytes."""
    content = json.dumps(table._asdict(), separators=(',', ':'))
    write_atomically(file, gzip.compress(content.encode(), mtime=0))


def read_judged_table(file: Path) -> JudgedTable:
    """
    Read judged runs.

    Raises
    ------
    ParameterError
        If the file cannot be read, is no such table, or is of another arithmetic.
    """
    try:
        with gzip.open(io.BytesIO(read_bounded(file, _PACKED))) as opened:
            unpacked = opened.read(_UNPACKED + 1)
        if len(unpacked) > _UNPACKED:
            raise ValueError(f'more than {_UNPACKED} bytes unpacked')
        content = parse_json(unpacked)
        table = JudgedTable(**{**content, 'budgets': tuple(content['budgets'])})
        if table.arithmetic == ARITHMETIC:
            _check(table)
    except (OSError, EOFError, zlib.error, ArithmeticError, ValueError, TypeError, KeyError, AttributeError) as error:
        reason = getattr(error, 'strerror', None) or f'is no table of judged runs ({error})'
        raise ParameterError([f'{file}: {reason}; name the {NAME} of a benchmark']) from None
    if table.arithmetic != ARITHMETIC:
        raise ParameterError([f'{file}: was computed with arithmetic {table.arithmetic}, and this program has '
                              f'{ARITHMETIC}: their last bits differ; take the table of this version'])
    return table


def _check(table: JudgedTable) -> None:
    """Raise an error unless all values are what they should be."""
    texts = [table.hash, *(track[name] for track in table.tracks.values() for name in ('content', 'objective'))]
    numbers = [*table.horizons.values(), *(seed for track in table.tracks.values() for seed in track['seeds'])]
    if not (all(isinstance(text, str) for text in texts) and all(isinstance(number, int) for number in numbers)):
        raise TypeError('hash, a track or a horizon is not as it should be')
    for result in table.results:
        name, runs = result['law'], table.runs
        if not (name.isprintable() and result['track'] in table.tracks
                and result['gains'] in (SEARCHED, CONFIGURED, FED, OWN)
                and result['seed'] in table.tracks[result['track']]['seeds']
                and result['budget'] in (table.budgets or (0,))):
            raise ValueError('a result is of a track, a seed or a budget that the table lacks')
        if result['success'] is None:
            continue
        rms = np.array(result['rms'], float)
        is_short = result['gains'] == OWN and 0 < len(rms) < runs
        if (len(result['success']) != len(rms) or not (len(rms) == runs or is_short)
                or not {*result['success']} <= {0, 1} or np.any(rms < 0.0)):
            raise ValueError(f'a result has not {runs} runs with success and error')


def csv_text(columns: Sequence[str], rows: Iterator[Sequence[Any]]) -> str:
    """Return a table as CSV."""
    table = io.StringIO()
    writer = csv.writer(table, lineterminator='\n')
    writer.writerow(columns)
    writer.writerows(rows)
    return table.getvalue()


def runs_table(done: Done) -> str:
    """Return `benchmark_runs.csv`: a row for each judged run, with its scenario; empty where not known."""
    scenarios: dict[Any, Any] = {}

    def rows() -> Iterator[Sequence[Any]]:
        for cell, cell_result in done:
            tried = [(kind_of_gains(cell), str(one.budget), one.judged) for one in cell_result.results if one.judged]
            if cell_result.configured:
                tried.append((CONFIGURED, '', cell_result.configured))
            if not tried:
                continue
            key = cell.track.name, cell.seed, cell.feedforward, cell.runs
            if key not in scenarios:
                scenarios[key] = cell.drawn('judging', cell.configuration(), cell.runs)
            for gains, budget, judged in tried:
                for n, scenario in enumerate(scenarios[key]):
                    yield (cell.track.name, cell.name, gains, cell.seed, budget, n + 1, scenario.curve,
                           scenario.scale, *scenario.start, scenario.mass, scenario.friction, scenario.delay,
                           scenario.noise.seed, int(judged.success[n]), judged.outcome[n],
                           *(judged.metrics[name][n] for name in JUDGED))

    return csv_text(RUN_COLUMNS, rows())
