"""Intervals and probabilities of Student's, the binomial and the hypergeometric distribution, in plain Python."""

import math
from collections.abc import Sequence
from functools import lru_cache

from mobile_robot_control.elementary import exp, lgamma, log, log1p

_MOST_TERMS = 100_000
_TINY = 1e-300
_EPSILON = 1e-16


def _continued_fraction(a: float, b: float, x: float) -> float:
    """Return the continued fraction of the incomplete beta function, by the modified method of Lentz."""
    c, d = 1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0) or _TINY)
    value = d
    for m in range(1, _MOST_TERMS):
        for factor in (m * (b - m) * x / ((a + 2 * m - 1.0) * (a + 2 * m)),
                       -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1.0))):
            d = 1.0 / (1.0 + factor * d or _TINY)
            c = 1.0 + factor / c or _TINY
            value *= c * d
        if abs(c * d - 1.0) < _EPSILON:
            break
    return value


def incomplete_beta(a: float, b: float, x: float) -> float:
    """
    Return the regularised incomplete beta function I_x(a, b), which rises from 0 at x = 0 to 1 at x = 1.

    Implements the continued fraction 8.17.22 of the NIST Digital Library of Mathematical Functions.

    Examples
    --------
    >>> round(incomplete_beta(2.0, 1.0, 0.5), 12), round(incomplete_beta(1.0, 3.0, 0.5), 12)
    (0.25, 0.875)

    """
    if x <= 0.0 or x >= 1.0:
        return float(x >= 1.0)
    # the fraction converges fast only on this side of the mean
    if x > (a + 1.0) / (a + b + 2.0):
        return 1.0 - incomplete_beta(b, a, 1.0 - x)
    front = lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x)
    return exp(front) * _continued_fraction(a, b, x) / a


def beta_quantile(a: float, b: float, probability: float) -> float:
    """Return the x at which I_x(a, b) is a probability, to the last bits, by bisection."""
    low, high = 0.0, 1.0
    while low < (x := 0.5 * (low + high)) < high:
        low, high = (x, high) if incomplete_beta(a, b, x) < probability else (low, x)
    return x


@lru_cache(maxsize=256)
def student_quantile(confidence: float, freedom: int) -> float:
    """
    Return the t for which Student's distribution has a given probability within -t and t.

    Examples
    --------
    >>> round(student_quantile(0.95, 10), 4)
    2.2281

    """
    x = beta_quantile(0.5, 0.5 * freedom, confidence)
    return math.sqrt(freedom * x / (1.0 - x))


def student_tails(t: float, freedom: int) -> float:
    """
    Return the probability beyond -t and t of Student's distribution.

    Examples
    --------
    >>> round(student_tails(2.2281, 10), 4)
    0.05

    """
    return incomplete_beta(0.5 * freedom, 0.5, freedom / (freedom + t * t))


@lru_cache(maxsize=256)
def binomial_interval(successes: int, trials: int, confidence: float) -> tuple[float, float]:
    """
    Return the bounds of the exact interval of Clopper and Pearson for the rate of successes.

    It excludes 1/2 exactly when the two-sided sign test rejects it at this confidence.

    Examples
    --------
    >>> [round(bound, 4) for bound in binomial_interval(1, 10, 0.95)]
    [0.0025, 0.445]

    """
    tail = 0.5 * (1.0 - confidence)
    low = beta_quantile(successes, trials - successes + 1, tail) if successes else 0.0
    high = beta_quantile(successes + 1, trials - successes, 1.0 - tail) if successes < trials else 1.0
    return low, high


def _log_binomial(n: int, k: int) -> float:
    return lgamma(n + 1) - lgamma(k + 1) - lgamma(n - k + 1)


def log_hypergeometric_tail(hits: int, drawn: int, marked: int, total: int) -> float:
    """
    Return the logarithm of the probability of at least `hits` marked ones among those drawn without replacement.

    Implements the one-sided exact test of Fisher.

    Parameters
    ----------
    hits : int
        Marked ones among the drawn, at least the expected number: below it, the sum is long.
    drawn, marked, total : int
        Drawn ones; marked ones among all; all.

    Examples
    --------
    >>> round(exp(log_hypergeometric_tail(3, 3, 4, 8)), 12) == round(4 / 56, 12)
    True

    """
    first = (_log_binomial(marked, hits) + _log_binomial(total - marked, drawn - hits)
             - _log_binomial(total, drawn))
    ratio = summed = 1.0
    for k in range(hits, min(drawn, marked)):
        ratio *= (marked - k) * (drawn - k) / ((k + 1.0) * (total - marked - drawn + k + 1.0))
        summed += ratio
        if ratio < _EPSILON * summed:
            break
    return first + log(summed)


def mean_interval(values: Sequence[float], confidence: float) -> tuple[float, float]:
    """
    Return the bounds of Student's interval of a mean; infinite for fewer than two values.

    Examples
    --------
    >>> [round(bound, 3) for bound in mean_interval([1.0, 2.0, 3.0], 0.95)]
    [-0.484, 4.484]

    """
    n = len(values)
    if n < 2:
        return -math.inf, math.inf
    mean = math.fsum(values) / n
    variance = math.fsum((value - mean) * (value - mean) for value in values) / (n - 1)
    half = student_quantile(confidence, n - 1) * math.sqrt(variance / n) if variance else 0.0
    return mean - half, mean + half
