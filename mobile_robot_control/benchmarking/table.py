"""The table of a benchmark: numbers of each cell, ranks of laws on each track over seeds, and a summary over tracks."""

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from statistics import fmean
from typing import Any

import numpy as np

from mobile_robot_control.analysis.intervals import mean_interval
from mobile_robot_control.benchmarking.cell import Cell
from mobile_robot_control.benchmarking.cell_result import (
    CONFIGURED,
    FED,
    OWN,
    SEARCHED,
    BudgetResult,
    CellResult,
    Done,
    as_json,
    kind_of_gains,
)
from mobile_robot_control.benchmarking.judged_table import csv_text, horizons_of
from mobile_robot_control.benchmarking.ranking import (
    LEAST_SUCCESS,
    RANKED,
    Pair,
    Runs,
    better_pairs,
    majority_places,
    pairs_of,
    place_ranges,
    probability,
    quantile,
    rank_ranges,
    ratios,
)
from mobile_robot_control.benchmarking.request import Benchmark, published_rows
from mobile_robot_control.conformance.laws import is_repeatable
from mobile_robot_control.control.laws import BUILT_IN, LAWS
from mobile_robot_control.elementary import ARITHMETIC, exp
from mobile_robot_control.loop.monte_carlo import CONFIDENCE, JudgedRuns, wilson_interval

Values = Mapping[str, Any]


def cell_hash(cell: Cell, result: CellResult) -> str:
    """Return digits that change with what a cell is and has shown; a reason may name a file, and a time differs."""
    shown = as_json(result)
    results = [{name: value for name, value in one.items() if name != 'reason'} for one in shown['results']]
    content = [cell.name, cell.track.name, cell.seed, cell.feedforward, results, shown['configured']]
    return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def benchmark_values(benchmark: Benchmark, done: Done) -> dict[str, Any]:
    """Return the content of `benchmark.json`, of the cells that are done."""
    hashes = [cell_hash(*one) for one in done]
    tracks = {name: track.content(benchmark.request.sources) for name, track in benchmark.tracks.items()}
    hashed = [ARITHMETIC, tracks, benchmark.request.scenarios, benchmark.request.runs, hashes,
              *([benchmark.table.hash] if benchmark.table else [])]
    results = [row for one, digits in zip(done, hashes, strict=True) for row in _rows(*one, digits)]
    held = {id(cell) for cell, _ in done}
    # another one may not answer at all
    driven = {cell.name: cell.law for cell, result in done
              if not cell.node and any(one.judged for one in result.results)}
    groups = {name: track.parameters.group or name for name, track in benchmark.tracks.items()}
    table, ranks, pairs, undone = benchmark.table, list[Values](), list[Values](), list[Values]()
    laws = [*dict.fromkeys([*(table.laws if table else ()), *benchmark.names])]
    for number, budget in enumerate(benchmark.budgets or (0,)):
        for name in benchmark.tracks:
            earlier = table.judged(name, budget) if table else {}
            rows, track_pairs = _ranked(name, number, budget, done, [
                row for row in results if (row['track'], row['budget']) == (name, budget)], earlier)
            ranks += rows
            pairs += track_pairs
            undone += _undone(name, budget, earlier, track_pairs)
    return {
        'hash': sha256(json.dumps(hashed, sort_keys=True).encode()).hexdigest()[:16],
        'laws': laws, 'seeds': list(benchmark.seeds), 'budgets': list(benchmark.budgets),
        'restarts': benchmark.request.restarts, 'scenarios': benchmark.request.scenarios,
        'runs': benchmark.request.runs,
        'tracks': {name: {'purpose': track.parameters.purpose, 'source': track.source, 'group': groups[name],
                          'objective': benchmark.objective(track),
                          'success_within': track.parameters.success_within,
                          'published': [*published_rows(track, benchmark.request.sources)]}
                   for name, track in benchmark.tracks.items()},
        'unfinished': [{'law': cell.name, 'track': cell.track.name, 'seed': cell.seed, 'feedforward': cell.feedforward}
                       for cell in benchmark.cells if id(cell) not in held],
        'not_loaded': dict(LAWS.failures),
        'not_repeatable': [name for name, law in driven.items()
                           if LAWS[law] not in BUILT_IN and not is_repeatable(LAWS[law])],
        'nodes': nodes_of(benchmark, done),
        'horizons': {**(table.horizons if table else {}), **horizons_of(benchmark.cells)},
        'against': {'hash': table.hash, 'added': list(benchmark.names), 'undone': undone} if table else None,
        'summary': [row for budget in benchmark.budgets or (0,)
                    for row in summary_of(laws, budget, ranks, pairs, groups)],
        'ranks': ranks, 'pairs': pairs, 'results': results,
    }


def nodes_of(benchmark: Benchmark, done: Done) -> dict[str, dict[str, Any]]:
    """Return what is known of nodes by the names of their rows, those of a table among them."""
    rows: dict[str, dict[str, Any]] = {
        one['law']: {'command': None, 'sha256': None, 'runs': len(one['success'])}
        for one in (benchmark.table.results if benchmark.table else ()) if one['gains'] == OWN}
    for cell in benchmark.cells:
        if cell.node:
            rows[cell.name] = {**cell.node.record, 'runs': cell.runs, 'repeated': {
                other.track.name: [*result.repeated] for other, result in done
                if other.name == cell.name and len(result.repeated) > 1}}
    return rows


def _rows(cell: Cell, cell_result: CellResult, digits: str) -> Iterator[dict[str, Any]]:
    """Yield the numbers of a cell, a row for each budget, and one of the gains as configured."""
    tried = [(kind_of_gains(cell), result) for result in cell_result.results]
    if cell_result.configured:
        tried.append((CONFIGURED, BudgetResult(max(cell.budgets), '', judged=cell_result.configured)))
    for gains, result in tried:
        judged, search = result.runs(cell.runs), result.search
        own = judged.chosen(judged.success) if judged else None

        def at(name: str, fraction: float = 0.5, own: JudgedRuns | None = own) -> float | None:
            return quantile(own.metrics[name].tolist(), fraction) if own else None

        successes = len(own) if own is not None else None
        yield {
            'track': cell.track.name, 'law': cell.name, 'gains': gains, 'seed': cell.seed, 'budget': result.budget,
            'runs': cell.runs if judged else 0, 'successes': successes,
            'success_interval': None if successes is None else list(wilson_interval(successes, cell.runs)),
            'rms': at(RANKED), 'rms_95': at(RANKED, 0.95), 'worst': at('max_position_error', 1.0),
            'settling_time': at('settling_time'), 'peak_wheel_torque': at('peak_wheel_torque'),
            'energy': at('energy'), 'torque_variation': at('torque_variation'),
            'command_variation': at('command_variation'), 'step_time': cell_result.step_time,
            'score': search.score if search else None, 'eq29': search.objectives.get('eq29') if search else None,
            'rms_searched': search.objectives.get('rms_position_error') if search else None,
            'agreeing': search.agreeing if search and cell.restarts > 1 else None,
            'at_edge': search.at_edge if search else [], 'hash': digits,
            'reason': result.reason, 'values': result.gains,
        }


def _ranked(
    track: str, number: int, budget: int, done: Done, rows: Sequence[Values], earlier: Runs
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return the laws of a track with one budget and those known before, the best first, and their pairs."""
    runs = {law: dict(own) for law, own in earlier.items() if own}
    laws = dict.fromkeys([*earlier, *(row['law'] for row in rows)])
    for cell, result in done:
        if cell.track.name == track and not cell.feedforward:
            judged = result.results[number].runs(cell.runs)
            if judged is not None:
                runs.setdefault(cell.name, {})[cell.seed] = judged
    pairs = pairs_of(runs)
    better = better_pairs(pairs)
    ranges, apart = rank_ranges(runs, better), ratios(runs, pairs)
    best = next((law for law, ratio in apart.items() if ratio == 0.0), '')
    order = sorted(runs, key=lambda law: (apart.get(law, math.inf), -_success(runs[law]), law))

    def row(law: str) -> dict[str, Any]:
        # of a benchmark without searches, those configured
        kind = SEARCHED if budget else CONFIGURED
        searched = [one for one in rows if (one['law'], one['gains']) == (law, kind)]
        own = runs.get(law, {})
        errors = [value for one in own.values() for value in one.metrics[RANKED][one.success].tolist()]
        agreeing = [one['agreeing'] for one in searched if one['agreeing'] is not None]
        to_best = next((_turned(pair, law) for pair in pairs if {pair.first, pair.second} == {law, best}), ())
        return {
            'track': track, 'law': law, 'budget': budget, 'place': order.index(law) + 1 if own else None,
            'rank': ranges[law][0] if own else None, 'last_rank': ranges[law][1] if own else None,
            'seeds': len(own), 'success': _success(own) if own else None, 'rms': quantile(errors, 0.5),
            'ratio': exp(apart[law]) if law in apart else None,
            'ratio_interval': _exponentials(mean_interval(to_best, CONFIDENCE)) if len(to_best) > 1 else None,
            'converged': sum(one > 1 for one in agreeing) if agreeing else None,
            'at_edge': sum(bool(one['at_edge']) for one in searched) if searched else None,
            **{f'{kind}_{what}': value for kind in (CONFIGURED, FED)
               for what, value in _other([one for one in rows if (one['law'], one['gains']) == (law, kind)]).items()},
            'reason': next((one['reason'] for one in searched if one['reason']), ''),
        }

    names = [*order, *(law for law in laws if law not in runs)]
    return [row(law) for law in names], [_pair_row(track, budget, pair, better) for pair in pairs]


def _undone(track: str, budget: int, earlier: Runs, pairs: Sequence[Values]) -> Iterator[dict[str, Any]]:
    """Yield what is certain among the laws known before, and no more in the larger family of comparisons."""
    still = {(pair['better'], other) for pair in pairs for other in (pair['first'], pair['second'])}
    for better, worse in sorted(better_pairs(pairs_of({law: own for law, own in earlier.items() if own})) - still):
        yield {'track': track, 'budget': budget, 'better': better, 'worse': worse}


def _success(runs: Mapping[int, JudgedRuns]) -> float:
    return fmean(np.count_nonzero(one.success) / len(one) for one in runs.values())


def _turned(pair: Pair, law: str) -> tuple[float, ...]:
    """Return the differences of a pair as those of one of its laws."""
    return pair.errors if pair.first == law else tuple(-one for one in pair.errors)


def _exponentials(interval: tuple[float, float]) -> list[float | None]:
    return [exp(end) if math.isfinite(end) else None for end in interval]


def _other(rows: Sequence[Values]) -> dict[str, float | None]:
    """Return error and success of other gains over seeds: the median of the seeds' medians."""
    medians = [row['rms'] for row in rows if row['rms'] is not None]
    judged = [row['successes'] / row['runs'] for row in rows if row['runs']]
    return {'rms': quantile(medians, 0.5) if medians else None, 'success': fmean(judged) if judged else None}


def _pair_row(track: str, budget: int, pair: Pair, better: set[tuple[str, str]]) -> dict[str, Any]:
    winner = next((one for one in (pair.first, pair.second) for loser in (pair.first, pair.second)
                   if (one, loser) in better), None)
    return {
        'track': track, 'budget': budget, 'first': pair.first, 'second': pair.second, 'errors': list(pair.errors),
        'successes': list(pair.successes), 'ratio': exp(fmean(pair.errors)) if pair.errors else None,
        'ratio_interval': (_exponentials(mean_interval(pair.errors, CONFIDENCE)) if len(pair.errors) > 1 else None),
        'probability': probability(pair.errors), 'success_probability': probability(pair.successes),
        'better': winner,
    }


def summary_of(
    laws: Sequence[str], budget: int, ranks: Sequence[Values], pairs: Sequence[Values], groups: Mapping[str, str]
) -> list[dict[str, Any]]:
    """Return the laws over all tracks with one budget, by pairwise majority."""
    rows: dict[str, dict[str, Values]] = {law: {} for law in laws}
    for row in ranks:
        if row['budget'] == budget:
            rows[row['law']][row['track']] = row
    ranked = {law: {track: row for track, row in own.items() if row['rank'] is not None} for law, own in rows.items()}
    driven = [law for law, own in ranked.items() if own]
    certain: dict[str, list[tuple[str, str]]] = {track: [] for own in ranked.values() for track in own}
    compared: Counter[str] = Counter()
    for pair in pairs:
        if pair['budget'] == budget:
            both = pair['first'], pair['second']
            compared.update(both)
            if pair['better']:
                certain[pair['track']].append(both if pair['better'] == both[0] else both[::-1])
    places, ranges = majority_places(driven, certain), place_ranges(driven, certain, groups)
    decided = [pair for found in certain.values() for pair in found]

    def summary(law: str) -> dict[str, Any]:
        own = list(ranked[law].values())
        worst = max((row for row in own if row['ratio'] is not None), key=lambda row: row['ratio'], default={})
        least: Values = min(own, key=lambda row: row['success'], default={})
        return {
            'law': law, 'budget': budget, 'place': places.get(law),
            'first_place': ranges[law][0] if own else None, 'last_place': ranges[law][1] if own else None,
            'tracks': len(own), 'unbeaten': sum(map(is_first, own)), 'comparisons': compared[law],
            'wins': sum(better == law for better, _ in decided), 'losses': sum(worse == law for _, worse in decided),
            'largest_ratio': worst.get('ratio'), 'largest_on': worst.get('track'),
            'least_success': least.get('success'), 'least_on': least.get('track'),
            'failed': [row['track'] for row in own if row['success'] < LEAST_SUCCESS],
            'not_searched': [track for track, row in rows[law].items() if row['rank'] is None],
        }

    def order(row: Values) -> tuple[Any, ...]:
        # where nothing is certain, by the places on the tracks
        own = [ranks['place'] for ranks in ranked[row['law']].values()]
        return row['place'] is None, row['place'] or 0, fmean(own) if own else 0.0, row['law']

    return sorted(map(summary, laws), key=order)


def is_first(row: Values) -> bool:
    """Return whether no law is known to be better than that of a row, which succeeds in half of the runs at least."""
    return bool(row['rank'] == 1 and row['success'] >= LEAST_SUCCESS)


COLUMNS = ('track', 'law', 'gains', 'seed', 'budget', 'runs', 'successes', 'rms', 'rms_95', 'worst', 'settling_time',
           'peak_wheel_torque', 'energy', 'torque_variation', 'command_variation', 'step_time', 'score', 'eq29',
           'rms_searched', 'agreeing', 'at_edge', 'hash', 'reason')
"""Of `benchmark.csv`."""


def benchmark_table(values: Values) -> str:
    """Return `benchmark.csv`: a row for each law, track, kind of gains, seed and budget; empty where not known."""
    def cell(value: Any) -> Any:
        return '; '.join(value) if isinstance(value, list) else value

    return csv_text(COLUMNS, ([cell(row[name]) for name in COLUMNS] for row in values['results']))


def last_summary(values: Values) -> list[Any]:
    """Return the summary of the largest budget."""
    largest = max(values['budgets'], default=0)
    return [row for row in values['summary'] if row['budget'] == largest]
