"""Events at their own rate, each rounded up to the velocity grid: in whole numbers, so that nothing drifts."""

import math
from typing import NamedTuple

from mobile_robot_control.jit import jitable

SLOWEST = 0.001
"""Slowest rate of events [Hz]."""
_LARGEST = 1_000_000_000


class Events(NamedTuple):
    """
    Events on the velocity grid: the first at step 0, and at most one in each step.

    Attributes
    ----------
    number, periods : int
        So many events in so many velocity periods; both below 2**30, so that products with a step fit.
    """

    number: int
    periods: int


def events_at(rate: float, period: int) -> Events:
    """
    Return the events of a rate on the velocity grid.

    Parameters
    ----------
    rate : float
        [Hz], at least `SLOWEST`. A rate above that of the grid gives an event in each period.
    period : int
        Of the velocity grid [ns].

    Examples
    --------
    >>> events_at(30.0, 2_000_000)
    Events(number=3, periods=50)

    """
    from fractions import Fraction  # noqa: PLC0415 (takes 7 ms, which most nodes save)

    # to the nearest such fraction, because 1 / 0.033 is not exactly 1000/33
    share = min(Fraction(1), (Fraction(rate) * Fraction(period, 1_000_000_000)).limit_denominator(_LARGEST))
    return Events(share.numerator, share.denominator)


@jitable
def periods(time: float, period: int) -> int:
    """Return a time [s] in periods [ns], rounded up; an excess below a nanosecond is ignored."""
    return -(-max(0, int(math.ceil(time * 1e9 - 1.0))) // period)  # noqa: RUF046 (a float on a GPU)


@jitable
def events_until(k: int, events: Events) -> int:
    """
    Return the number of the newest event at a step of the velocity grid.

    Event j is at the first step at or after j / rate; step 0 has event 0, steps before it have negative numbers.
    """
    return k * events.number // events.periods


@jitable
def step_of(event: int, events: Events) -> int:
    """Return the step of the velocity grid at which an event occurs."""
    return -(-event * events.periods // events.number)


@jitable
def is_event(k: int, events: Events) -> bool:
    """Return whether an event occurs at a step of the velocity grid."""
    return k * events.number % events.periods < events.number
