"""Controllers compared in the same scenarios: paired differences with their intervals, and what they show, in words."""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.tuning.monte_carlo import CONFIDENCE, Judged
from mobile_robot_control.tuning.tail_probabilities import binomial_interval, student_quantile

COMPARED = 'rms_position_error'
"""The metric whose paired differences are taken [m]."""
_SAME = 'cannot be told apart'


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
        Scenarios in which both succeeded, or one alone.
    share : tuple of float
        Interval of the share of `only_first` in the scenarios in which one alone succeeds; (0, 1) where there is none.
    difference : float
        Mean over the scenarios in which both succeeded of the RMS position error of the first minus that of the second
        [m]; nan where there is none.
    interval : tuple of float
        Of that mean [m]; infinite where fewer than two scenarios are left.
    confidence : float
        Of both intervals.

    """

    first: str
    second: str
    runs: int
    both: int
    only_first: int
    only_second: int
    share: tuple[float, float]
    difference: float
    interval: tuple[float, float]
    confidence: float

    @property
    def left_out(self) -> int:
        """Scenarios in which one or both failed: the error of a run that failed is compared with nothing."""
        return self.runs - self.both

    @property
    def more_successful(self) -> str:
        """The name of the one that succeeds in more scenarios; '' where the two cannot be told apart."""
        low, high = self.share
        return self.first if low > 0.5 else self.second if high < 0.5 else ''

    @property
    def more_accurate(self) -> str:
        """The name of the one with the smaller error; '' where the two cannot be told apart."""
        low, high = self.interval
        return self.second if low > 0.0 else self.first if high < 0.0 else ''


def mean_interval(values: Sequence[float], confidence: float) -> tuple[float, float]:
    """
    Return the bounds of Student's interval of a mean; infinite where there are fewer than two values.

    Examples
    --------
    >>> [round(bound, 3) for bound in mean_interval([1.0, 2.0, 3.0], 0.95)]
    [-0.484, 4.484]

    """
    n = len(values)
    if n < 2:
        return -math.inf, math.inf
    mean = math.fsum(values) / n
    variance = math.fsum((value - mean) ** 2 for value in values) / (n - 1)
    half = student_quantile(confidence, n - 1) * math.sqrt(variance / n) if variance else 0.0
    return mean - half, mean + half


def compare(
    names: tuple[str, str], runs: tuple[Sequence[Judged], Sequence[Judged]], confidence: float = CONFIDENCE
) -> Comparison:
    """
    Compare two controllers in the scenarios that both ran.

    Parameters
    ----------
    names : tuple of str
        Of the first and of the second.
    runs : tuple of sequence of Judged
        Of each, in the order of the same scenarios; what one has more than the other is left out.
    confidence : float
        Of the intervals.

    """
    pairs = list(zip(*runs, strict=False))
    found = [a.metrics[COMPARED] - b.metrics[COMPARED] for a, b in pairs if a.success and b.success]
    only_first = sum(a.success and not b.success for a, b in pairs)
    only_second = sum(b.success and not a.success for a, b in pairs)
    alone = only_first + only_second
    return Comparison(
        *names, len(pairs), len(found), only_first, only_second,
        binomial_interval(only_first, alone, confidence) if alone else (0.0, 1.0),
        math.fsum(found) / len(found) if found else math.nan, mean_interval(found, confidence), confidence)


def compare_all(controllers: Mapping[str, Sequence[Judged]]) -> list[Comparison]:
    """
    Compare every pair of controllers, by name, in the same scenarios.

    The intervals of all pairs hold together: of n pairs each has 1/n of the probability to be wrong (Bonferroni). So
    they also hold for the best controller, which is chosen by the same runs.
    """
    pairs = list(itertools.combinations(controllers, 2))
    return [compare(pair, (controllers[pair[0]], controllers[pair[1]]), 1.0 - (1.0 - CONFIDENCE) / len(pairs))
            for pair in pairs]


def best_of(controllers: Mapping[str, Sequence[Judged]]) -> str:
    """
    Return the name of the controller with most successes, and of several the one with the smallest mean error.

    Scenarios that not all of them ran are left out, and of the errors those of scenarios in which any one failed.
    """
    ran = list(zip(*controllers.values(), strict=False))
    successes = [sum(run.success for run in runs) for runs in zip(*ran, strict=True)]
    shared = [runs for runs in ran if all(run.success for run in runs)]
    errors = [math.fsum(runs[k].metrics[COMPARED] for runs in shared) for k in range(len(controllers))]
    return list(controllers)[min(range(len(controllers)), key=lambda k: (-successes[k], errors[k]))]


def _length(metres: float) -> str:
    return f'{100.0 * metres:.3g}'


def _error_text(one: Comparison) -> str:
    """Return what the errors show, in words."""
    if one.both < 2:
        return f'not compared: {one.both} of {one.runs} scenarios in which both succeed, and two are needed'
    (low, high), difference = one.interval, one.difference
    over = f'in the {one.both} scenarios in which both succeed'
    if one.left_out:
        over += f'; {one.left_out} {"is" if one.left_out == 1 else "are"} left out, where one or both fail'
    if not one.more_accurate:
        return (f'{_SAME}: that of {one.first} minus that of {one.second} is {_length(difference)} cm '
                f'({_length(low)} to {_length(high)}) {over}')
    low, high = (low, high) if difference > 0.0 else (-high, -low)
    return (f'that of {one.more_accurate} is smaller by {_length(abs(difference))} cm '
            f'({_length(low)} to {_length(high)}) {over}')


def _success_text(one: Comparison) -> str:
    """Return what success and failure show, in words."""
    if one.only_first == one.only_second == 0:
        return f'{_SAME}: the same {one.both} of {one.runs} succeed'
    shown = f'{one.more_successful} succeeds more often' if one.more_successful else _SAME
    return f'{shown}: {one.first} alone in {one.only_first}, {one.second} alone in {one.only_second} of {one.runs}'


def _head(made: Sequence[Comparison], best: str) -> str:
    """Return which pairs follow, and what their intervals mean."""
    if len(made) == 1:
        return f'compared in the same scenarios, with intervals of {100.0 * CONFIDENCE:g} %:'
    return (f'compared in the same scenarios with {best}, the best; the intervals of all {len(made)} pairs hold '
            f'together with {100.0 * CONFIDENCE:g} % (each {100.0 * made[0].confidence:.2f} %, Bonferroni):')


def comparison_texts(controllers: Mapping[str, Sequence[Judged]]) -> Iterator[str]:
    """Yield sentences: of two controllers their comparison, of more that of each with the best one; none of one."""
    made = compare_all(controllers)
    if not made:
        return
    best = best_of(controllers)
    yield _head(made, best)
    for one in made:
        if best in (one.first, one.second):
            yield f'{one.first} and {one.second}, RMS error: {_error_text(one)}'
            yield f'{one.first} and {one.second}, success: {_success_text(one)}'


def comparison_values(controllers: Mapping[str, Sequence[Judged]]) -> list[dict[str, Any]]:
    """Return the comparison of each pair, as in `study.json`; None stands for what is not known."""
    return [{
        'first': one.first, 'second': one.second, 'confidence': one.confidence, 'runs': one.runs,
        'both_succeed': one.both, 'only_first_succeeds': one.only_first, 'only_second_succeeds': one.only_second,
        'left_out': one.left_out,
        'success_share_interval': list(one.share) if one.only_first + one.only_second else None,
        'more_successful': one.more_successful or None,
        'rms_difference': one.difference if one.both else None,
        'rms_difference_interval': list(one.interval) if one.both > 1 else None,
        'more_accurate': one.more_accurate or None,
    } for one in compare_all(controllers)]
