"""Rows of a benchmark that are worse than in an earlier table, for certain: a check for continuous integration."""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import fmean
from typing import Annotated, NamedTuple

import numpy as np

from mobile_robot_control.analysis.intervals import mean_interval, student_tails
from mobile_robot_control.benchmarking.cell_result import FED, OWN, SEARCHED, kind_of_gains
from mobile_robot_control.benchmarking.judged_table import NAME, JudgedTable, read_judged_table, runs_of
from mobile_robot_control.benchmarking.ranking import LEAST_SUCCESS, RANKED, rejected
from mobile_robot_control.benchmarking.request import Benchmark, differing_tracks
from mobile_robot_control.elementary import exp, log, log1p
from mobile_robot_control.loop.monte_carlo import CONFIDENCE, JudgedRuns
from mobile_robot_control.parameters.declaration import Field, ParameterError

_OPTION = '--fail-if-worse'


class WorseRequest(NamedTuple):
    """Whether a benchmark is compared with an earlier one, row by row."""

    fail_if_worse: Annotated[str | None, Field(
        '', f'{NAME} of an earlier benchmark: exit code 1 if a row of this one is worse by more than the margin, for '
        'certain')] = None
    margin: Annotated[float, Field('', 'share by which the RMS error of a row may grow with --fail-if-worse',
                                   minimum=0.0)] = 0.1


class Row(NamedTuple):
    """What is compared: a law or node on a track, the kind of its gains, and the candidates of its search."""

    law: str
    track: str
    gains: str
    budget: int

    def __str__(self) -> str:
        return f'{self.law} on {self.track} ({self.gains}{f", budget {self.budget}" if self.budget else ""})'


class Change(NamedTuple):
    """
    A row now and before, in the same scenarios.

    Attributes
    ----------
    row : Row
        What it is of.
    is_searched : bool
        Whether its gains have the luck of a search, so that a seed is one observation; otherwise a scenario is.
    errors : tuple of float
        By observation, ln(RMS error now / before) where both succeed; its mean over the scenarios of a seed.
    shares : tuple of (float, float)
        By observation, the share of successes now and before.
    runs : int
        Scenarios now and before, of all observations.
    """

    row: Row
    is_searched: bool
    errors: tuple[float, ...]
    shares: tuple[tuple[float, float], ...]
    runs: int

    @property
    def is_none(self) -> bool:
        """Whether all runs are the same, to the last bit."""
        return not any(self.errors) and not self.loses

    @property
    def loses(self) -> bool:
        """Whether any share of successes is another one."""
        return any(now != before for now, before in self.shares)

    @property
    def successes(self) -> tuple[float, float]:
        """The shares of successes now and before."""
        now, before = zip(*self.shares, strict=True)
        return fmean(now), fmean(before)

    def observed(self) -> str:
        """Return how many observations it has, in words."""
        return f'{len(self.shares)} {"seeds" if self.is_searched else "scenarios"}'

    def fewer_successes(self) -> float:
        """Return the probability of as many failures more than before, where there are no more."""
        now, before = self.successes
        if not self.is_searched:
            return sign_test(self.shares.count((0.0, 1.0)), self.shares.count((1.0, 0.0)))
        # where few runs fail, as many in each seed is no proof that they differ little
        failing = 1.0 - (0.5 * (now + before) * self.runs + 0.5) / (self.runs + 1.0)
        least = 2.0 * failing * (1.0 - failing) / (self.runs / len(self.shares))
        return above([was - share for share, was in self.shares], 0.0, least)


def row_of(name: str, track: str, gains: str, budget: int) -> Row:
    """Return the row of a result; a node has the same runs with each budget."""
    return Row(name, track, gains, 0 if gains == OWN else budget)


class Verdict(NamedTuple):
    """
    The rows of a benchmark beside those of an earlier one.

    Attributes
    ----------
    compared : int
        Rows that both have.
    worse, undecided, lacking : list of str
        Those that are worse for certain, with the reason; those whose interval reaches beyond the margin; and those
        that the earlier one does not have.
    """

    compared: int
    worse: list[str]
    undecided: list[str]
    lacking: list[str]


def rows_of(table: JudgedTable) -> dict[Row, dict[int, JudgedRuns | None]]:
    """Return the judged runs of a table by row and seed; None of a law whose search drove no candidate."""
    rows: dict[Row, dict[int, JudgedRuns | None]] = {}
    for result in table.results:
        row = row_of(result['law'], result['track'], result['gains'], result['budget'])
        rows.setdefault(row, {})[result['seed']] = runs_of(result)
    return rows


def read_earlier(file: str, benchmark: Benchmark) -> JudgedTable:
    """Read the table that a benchmark is compared with; raise ParameterError where no row of it can be."""
    table = read_judged_table(Path(file))
    violations = differing_tracks(_OPTION, benchmark.tracks.values(), table, benchmark.request.sources)
    held, searched = rows_of(table), bool(benchmark.budgets)
    if searched and table.budgets:
        violations += [f'{_OPTION}: the searches of the table had {name} = {getattr(table, name)}, and those of this '
                       f'benchmark have {getattr(benchmark.request, name)}; ask for the same with --{name}'
                       for name in ('scenarios', 'restarts')
                       if getattr(table, name) != getattr(benchmark.request, name)]
    common: dict[Row, set[int]] = {}
    for cell in benchmark.cells:
        for budget in cell.budgets or (0,):
            row = row_of(cell.name, cell.track.name, kind_of_gains(cell), budget)
            common.setdefault(row, set()).update({cell.seed} & {*held.get(row, ())})
    judged = [row for row, seeds in common.items() if len(seeds) > (searched and row.gains != OWN)]
    if not (judged or violations):
        seeds = sorted({seed for track in table.tracks.values() for seed in track['seeds']})
        kinds = sorted({row.gains for row in held})
        violations = [f'{_OPTION} {file}: no row of this benchmark can be compared with it; it has '
                      f'{", ".join(table.laws)} on {", ".join(table.tracks)}, gains {", ".join(kinds)}, --budgets '
                      f'{" ".join(map(str, table.budgets))} and --seeds {" ".join(map(str, seeds))}, of which a law '
                      'that is searched needs two or more']
    if violations:
        raise ParameterError(violations)
    return table


def change_of(row: Row, is_searched: bool, now: Mapping[int, JudgedRuns], before: Mapping[int, JudgedRuns]) -> Change:
    """Return what has changed in a row, over the seeds and scenarios that it has now and had before."""
    errors: list[float] = []
    shares: list[tuple[float, float]] = []
    runs = 0
    for seed in sorted({*now, *before}):
        if seed not in now or seed not in before:
            continue
        count = min(len(now[seed]), len(before[seed]))
        a, b = (one[seed].chosen(slice(count)) for one in (now, before))
        both, runs = a.success & b.success, runs + count
        ratios = [log(x) - log(y) for x, y in zip(
            a.metrics[RANKED][both].tolist(), b.metrics[RANKED][both].tolist(), strict=True)]
        if not is_searched:
            errors += ratios
            shares += zip(a.success.astype(float).tolist(), b.success.astype(float).tolist(), strict=True)
        else:
            errors += [fmean(ratios)] if len(ratios) >= LEAST_SUCCESS * count else []
            shares.append((float(np.mean(a.success)), float(np.mean(b.success))))
    return Change(row, is_searched, tuple(errors), tuple(shares), runs)


def above(values: Sequence[float], bound: float, least_variance: float = 0.0) -> float:
    """
    Return the probability of a mean so far above a bound where the true one is not, by Student's test.

    Parameters
    ----------
    values : sequence of float
        Independent ones.
    bound : float
        Of the mean.
    least_variance : float
        Of each value, as far as it is known.

    Examples
    --------
    >>> round(above([1.0, 2.0, 3.0], 0.0), 4), above([1.0, 2.0, 3.0], 4.0)
    (0.0371, 1.0)

    """
    n = len(values)
    if n < 2 or (mean := fmean(values)) <= bound:
        return 1.0
    variance = max(math.fsum((value - mean) * (value - mean) for value in values) / (n - 1), least_variance)
    return 0.5 * student_tails((mean - bound) / math.sqrt(variance / n), n - 1) if variance else 0.0


def sign_test(losses: int, wins: int) -> float:
    """
    Return the probability of at least so many losses, where losses and wins are equally likely.

    Examples
    --------
    >>> sign_test(3, 0), sign_test(0, 3)
    (0.125, 1.0)

    """
    n = losses + wins
    return float(math.fsum(math.comb(n, k) for k in range(losses, n + 1)) / (1 << n))


def worse_changes(changes: Sequence[Change], margin: float) -> list[tuple[Change, bool]]:
    """
    Return the changes that are for the worse with 95 %, all of them together; whether by error, or by success.

    Implements the method of Holm (Scandinavian Journal of Statistics 6, 1979) over both criteria of all rows. Where
    nothing differs to the last bit, nothing is tested.
    """
    tests = [(above(change.errors, log1p(margin)), change, True) for change in changes if any(change.errors)]
    tests += [(change.fewer_successes(), change, False) for change in changes if change.loses]
    return [tests[n][1:] for n in sorted(rejected([probability for probability, *_ in tests]))]


def verdict(new: JudgedTable, old: JudgedTable, margin: float) -> Verdict:
    """Compare the rows of a benchmark with those of an earlier one."""
    changes, worse, lacking = [], [], []
    before = rows_of(old)
    for row, runs in rows_of(new).items():
        common = [seed for seed in runs if before.get(row, {}).get(seed) is not None]
        if not common:
            lacking.append(str(row))
            continue
        if lost := [seed for seed in common if runs[seed] is None]:
            worse.append(f'{row}: was driven before, and is not searched now with seed {", ".join(map(str, lost))}')
        is_searched = row.gains == SEARCHED or (row.gains == FED and bool(new.budgets))
        changes.append(change_of(row, is_searched, _driven(runs), _driven(before[row])))
    certain = worse_changes(changes, margin)
    worse += [_in_words(change, by_error, margin) for change, by_error in certain]
    undecided = [str(change.row) for change in changes if not change.is_none and (change, True) not in certain
                 and mean_interval(change.errors, CONFIDENCE)[1] > log1p(margin)]
    return Verdict(len(changes), worse, undecided, lacking)


def _driven(runs: Mapping[int, JudgedRuns | None]) -> dict[int, JudgedRuns]:
    return {seed: one for seed, one in runs.items() if one is not None}


def verdict_lines(outcome: Verdict, file: str, folder: str, margin: float) -> Iterator[str]:
    """Yield what a comparison shows, and what to do, in sentences."""
    yield from (f'worse: {text}' for text in outcome.worse)
    if outcome.undecided:
        yield (f'undecided, since intervals reach beyond the margin; more seeds or scenarios tell: '
               f'{", ".join(outcome.undecided)}')
    if outcome.lacking:
        yield f'not in {file}, and not compared: {", ".join(outcome.lacking)}'
    if outcome.worse:
        yield (f'{len(outcome.worse)} of {outcome.compared} rows are worse than in {file}: look at paths and gains '
               f'in {folder}/benchmark.html; if the change is meant, keep {folder}/{NAME} as the new table')
    else:
        yield (f'no row is worse than in {file} by more than {100.0 * margin:g} %, for certain; compared: '
               f'{outcome.compared}')


def _in_words(change: Change, by_error: bool, margin: float) -> str:
    if not by_error:
        now, before = (f'{100.0 * share:.1f} %' for share in change.successes)
        return f'{change.row}: succeeds in {now} of the runs, and in {before} before ({change.observed()})'
    low, high = map(exp, mean_interval(change.errors, CONFIDENCE))
    return (f'{change.row}: RMS error {exp(fmean(change.errors)):.3f} times that of the table (95 % interval {low:.3f} '
            f'to {high:.3f}, {change.observed()}), and {1.0 + margin:g} are allowed')
