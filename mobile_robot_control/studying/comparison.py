"""Comparison of controllers in the same scenarios: paired differences, their intervals, and conclusions in words."""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from mobile_robot_control.analysis.intervals import binomial_interval, mean_interval
from mobile_robot_control.loop.metric_table import BAND, METRIC_TABLE
from mobile_robot_control.loop.monte_carlo import CONFIDENCE, Judged, JudgedRuns, metric_labels

COMPARED = ('late_max_position_error', 'rms_position_error')
"""The default metrics of paired differences."""
_SAME = 'no significant difference'


class Difference(NamedTuple):
    """
    One metric of two controllers in the same scenarios.

    Attributes
    ----------
    metric : str
        Its name.
    compared : int
        Scenarios in which both succeed and both values are known.
    mean : float
        Of the first's value minus the second's over those; nan without any.
    interval : tuple of float
        Of that mean; infinite with fewer than two scenarios.
    confidence : float
        Of the interval.

    """

    metric: str
    compared: int
    mean: float
    interval: tuple[float, float]
    confidence: float

    @property
    def sign(self) -> int:
        """1 if the first's value is larger for certain, -1 if it is smaller, 0 if the two cannot be told apart."""
        low, high = self.interval
        return int(low > 0.0) - int(high < 0.0)


class Comparison(NamedTuple):
    """
    Two controllers in the same scenarios.

    Attributes
    ----------
    first, second : str
        Their names.
    runs : int
        Scenarios that both ran.
    both, only_first, only_second : int
        Scenarios in which both succeeded, or only one did.
    share : tuple of float
        Interval of the share of `only_first` among the scenarios in which only one succeeds; (0, 1) without any.
    confidence : float
        Of that interval.
    differences : tuple of Difference
        Of each metric.

    """

    first: str
    second: str
    runs: int
    both: int
    only_first: int
    only_second: int
    share: tuple[float, float]
    confidence: float
    differences: tuple[Difference, ...]

    @property
    def more_successful(self) -> str:
        """The name of the one that succeeds in more scenarios; '' if the two cannot be told apart."""
        low, high = self.share
        return self.first if low > 0.5 else self.second if high < 0.5 else ''

    def better(self, difference: Difference) -> str:
        """Return the name of the one with the better value of a metric; '' if the two cannot be told apart."""
        sign = -difference.sign if METRIC_TABLE[difference.metric].better == 'larger' else difference.sign
        return ('', self.second, self.first)[sign]


def _difference(metric: str, first: JudgedRuns, second: JudgedRuns, confidence: float) -> Difference:
    """Compare one metric over pairs of successful runs."""
    a, b = first.metrics[metric], second.metrics[metric]
    # an error that does not settle has no settling time, and a base that takes velocities has no torque
    valued = np.isfinite(a) & np.isfinite(b)
    differences = (a[valued] - b[valued]).tolist()
    return Difference(metric, len(differences), math.fsum(differences) / len(differences) if differences else math.nan,
                      mean_interval(differences, confidence), confidence)


def compare(
    names: tuple[str, str], runs: tuple[Sequence[Judged], Sequence[Judged]], metrics: Sequence[str] = COMPARED,
    pairs: int = 1,
) -> Comparison:
    """
    Compare two controllers in the scenarios that both ran.

    Parameters
    ----------
    names : tuple of str
        Of the first and of the second.
    runs : tuple of sequence of Judged
        Of each, in the order of the same scenarios; surplus runs of one are left out.
    metrics : sequence of str
        Names of the compared metrics.
    pairs : int
        Number of compared pairs of controllers in all. The intervals of all pairs and metrics hold together: each of n
        has 1/n of the probability of error (Bonferroni); so do those of success, among themselves.

    """
    a, b = (JudgedRuns.of(one)[:min(map(len, runs))] for one in runs)
    both = a.success & b.success
    first, second = a.chosen(both), b.chosen(both)
    only_first, only_second = int(np.count_nonzero(a.success & ~both)), int(np.count_nonzero(b.success & ~both))
    alone, confidence = only_first + only_second, _of_each(pairs)
    return Comparison(
        *names, len(a), len(first), only_first, only_second,
        binomial_interval(only_first, alone, confidence) if alone else (0.0, 1.0), confidence,
        tuple(_difference(metric, first, second, _of_each(pairs * len(metrics))) for metric in metrics))


def _of_each(intervals: int) -> float:
    """Return the confidence of each of several intervals that hold together."""
    return 1.0 - (1.0 - CONFIDENCE) / intervals


def compare_all(controllers: Mapping[str, Sequence[Judged]], metrics: Sequence[str] = COMPARED) -> list[Comparison]:
    """Compare every pair of controllers, by name; the intervals also hold for the best one, chosen by the same runs."""
    pairs = list(itertools.combinations(controllers, 2))
    return [compare(pair, (controllers[pair[0]], controllers[pair[1]]), metrics, len(pairs)) for pair in pairs]


def best_of(controllers: Mapping[str, Sequence[Judged]], metrics: Sequence[str] = COMPARED) -> str:
    """
    Return the name of the controller with most successes; among equals, the one with the best mean of the first metric.

    Scenarios that not all of them ran are left out; for the metric, also those in which any failed or has no value.
    """
    length, (metric, *_) = min(map(len, controllers.values())), metrics
    ran = [JudgedRuns.of(runs)[:length] for runs in controllers.values()]
    shared = np.all([one.success & np.isfinite(one.metrics[metric]) for one in ran], axis=0)
    sign = -1.0 if METRIC_TABLE[metric].better == 'larger' else 1.0
    order = [(-int(np.count_nonzero(one.success)), sign * math.fsum(one.metrics[metric][shared].tolist()))
             for one in ran]
    return list(controllers)[order.index(min(order))]


def _shown(value: float, unit: str) -> str:
    """Return a number as text, a length in centimetres."""
    return f'{100.0 * value:.3g}' if unit == 'm' else f'{value:.3g}'


def _difference_text(pair: Comparison, difference: Difference, unit: str) -> str:
    valued = ' and have a value' if difference.compared < pair.both else ''
    if difference.compared < 2:
        return (f'not compared: {difference.compared} of {pair.runs} scenarios in which both succeed{valued}, and two '
                'are needed')
    (low, high), left_out = difference.interval, pair.runs - difference.compared
    over = f'in the {difference.compared} scenarios in which both succeed{valued}'
    if left_out:
        over += f'; {left_out} {"is" if left_out == 1 else "are"} left out'
    shown = f'{"cm" if unit == "m" else unit}'.rstrip()
    if not difference.sign:
        return (f'{_SAME}: that of {pair.first} minus that of {pair.second} is {_shown(difference.mean, unit)} {shown} '
                f'({_shown(low, unit)} to {_shown(high, unit)}) {over}').replace('  ', ' ')
    low, high = (low, high) if difference.sign > 0 else (-high, -low)
    larger = 'larger' if METRIC_TABLE[difference.metric].better == 'larger' else 'smaller'
    return (f'that of {pair.better(difference)} is {larger} by {_shown(abs(difference.mean), unit)} {shown} '
            f'({_shown(low, unit)} to {_shown(high, unit)}) {over}').replace('  ', ' ')


def _success_text(pair: Comparison) -> str:
    if pair.only_first == pair.only_second == 0:
        return f'{_SAME}: the same {pair.both} of {pair.runs} succeed'
    shown = f'{pair.more_successful} succeeds more often' if pair.more_successful else _SAME
    return f'{shown}: {pair.first} alone in {pair.only_first}, {pair.second} alone in {pair.only_second} of {pair.runs}'


def _head(pairs: Sequence[Comparison], best: str) -> str:
    """Return the introduction: the pairs that follow, and the meaning of their intervals."""
    differences = pairs[0].differences
    with_best = f' with {best}, the best' if len(pairs) > 1 else ''
    intervals = len(pairs) * len(differences)
    if intervals == 1:
        return f'compared in the same scenarios, with intervals of {100.0 * CONFIDENCE:g} %:'
    return (f'compared in the same scenarios{with_best}; the {intervals} intervals of all pairs and metrics hold '
            f'together with {100.0 * CONFIDENCE:g} % (each {100.0 * differences[0].confidence:.2f} %, Bonferroni):')


def comparison_texts(
    controllers: Mapping[str, Sequence[Judged]], metrics: Sequence[str] = COMPARED, band: float = BAND
) -> Iterator[str]:
    """
    Yield sentences: for two controllers their comparison, for more that of each with the best one; none for one.

    `band` [m] is the limit of a settled error.
    """
    pairs = compare_all(controllers, metrics)
    if not pairs:
        return
    best, labels = best_of(controllers, metrics), metric_labels(band)
    yield _head(pairs, best)
    for pair in pairs:
        if best in (pair.first, pair.second):
            for difference in pair.differences:
                label, unit = labels[difference.metric]
                yield f'{pair.first} and {pair.second}, {label}: {_difference_text(pair, difference, unit)}'
            yield f'{pair.first} and {pair.second}, success: {_success_text(pair)}'


def answer_text(
    controllers: Mapping[str, Sequence[Judged]], metrics: Sequence[str] = COMPARED, band: float = BAND
) -> str:
    """
    Return the best of several controllers, its advantage and the intervals, as a sentence; '' for one controller.

    Compared with each other one, the best is better by success, else by the first metric, or not significantly better.
    """
    pairs = compare_all(controllers, metrics)
    if not pairs:
        return ''
    best, (label, unit) = best_of(controllers, metrics), metric_labels(band)[metrics[0]]
    better, same = [], []
    for pair in pairs:
        if best not in (pair.first, pair.second):
            continue
        other, difference = pair.second if best == pair.first else pair.first, pair.differences[0]
        if pair.more_successful == best:
            alone, others = ((pair.only_first, pair.only_second) if best == pair.first else
                             (pair.only_second, pair.only_first))
            better.append(f'than {other} by success ({alone} of {pair.runs} runs succeed with {best} alone, '
                          f'{others} with {other} alone)')
        elif pair.better(difference) == best and not pair.more_successful:
            low, high = sorted(map(abs, difference.interval))
            better.append(f'than {other} by {_shown(abs(difference.mean), unit)} {"cm" if unit == "m" else unit} '
                          f'({_shown(low, unit)} to {_shown(high, unit)})')
        else:
            same.append(other)
    told = f'{best} is better {", ".join(better)}'
    if any('by success' not in text for text in better):
        told += f': the mean {label}, where both succeed, with intervals that hold together with {100 * CONFIDENCE:g} %'
    if not better:
        return f'{best} does best, but not significantly better than {", ".join(same)}'
    return f'{told}; it is not significantly better than {", ".join(same)}' if same else told


def comparison_values(
    controllers: Mapping[str, Sequence[Judged]], metrics: Sequence[str] = COMPARED
) -> list[dict[str, Any]]:
    """Return the comparison of each pair, as in `study.json`; unknown values are None."""
    return [{
        'first': pair.first, 'second': pair.second, 'runs': pair.runs,
        'both_succeed': pair.both, 'only_first_succeeds': pair.only_first, 'only_second_succeeds': pair.only_second,
        'success_confidence': pair.confidence,
        'success_share_interval': list(pair.share) if pair.only_first + pair.only_second else None,
        'more_successful': pair.more_successful or None,
        'metrics': [{
            'metric': difference.metric, 'compared': difference.compared, 'left_out': pair.runs - difference.compared,
            'confidence': difference.confidence, 'difference': difference.mean if difference.compared else None,
            'difference_interval': list(difference.interval) if difference.compared > 1 else None,
            'better': pair.better(difference) or None,
        } for difference in pair.differences],
    } for pair in compare_all(controllers, metrics)]
