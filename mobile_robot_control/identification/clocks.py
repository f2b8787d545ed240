"""The clocks of a recording: times of stamps and of receipt, and their meaning for the robot."""

from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.lines import Floats
from mobile_robot_control.runs.series import Signal

_A_DAY = 86400.0
_WINDOWS = 20
_FEWEST = 25
"""Messages of a window in which the fastest one is sought."""
_LATE = 0.98
"""Quantile of the lateness that counts as its largest."""
SAMPLED, SENT = 'sampled', 'sent'


class Clock(NamedTuple):
    """
    The stamps of a topic, on the recorder's clock.

    Attributes
    ----------
    times : array of float, shape (n,)
        Of the messages: their stamps, plus the delay of the fastest messages [s].
    floor : float
        That delay, with the offset between both clocks [s].
    rate : float
        Of the messages sent, including lost ones [Hz].
    jitter : float
        Largest delay of messages, relative to the fastest ones [s].
    lost : float
        Share of missing messages, at the usual rate.
    stamped : str
        SAMPLED, SENT, or '' if unknown.
    """

    times: Floats
    floor: float
    rate: float
    jitter: float
    lost: float
    stamped: str


def is_wall(signal: Signal) -> bool:
    """Return whether stamps come from a wall clock, near the time of receipt."""
    return bool(signal.received.size and abs(np.median(signal.received - signal.stamps)) < 1e9 * _A_DAY)


def read_clock(signal: Signal, origin: int, on_receipt: bool) -> Clock:
    """
    Return the clock of a topic with at least two messages.

    Parameters
    ----------
    signal : Signal
        With stamps, and times of receipt.
    origin : int
        Stamp of t = 0 [ns].
    on_receipt : bool
        Whether times are converted to the recorder's clock; stamps of simulated time are not.
    """
    stamps = (signal.stamps - origin) / 1e9
    intervals = np.diff(stamps)
    usual = float(np.median(intervals))
    sent = max(1.0, float(np.round(intervals / usual).sum()))
    lost, rate = 1.0 - intervals.size / sent, sent / float(stamps[-1] - stamps[0])
    if not on_receipt:
        return Clock(stamps, 0.0, rate, 0.0, max(0.0, lost), '')
    took = (signal.received - signal.stamps) / 1e9
    floor = _floor(stamps, took)
    late = took - floor
    received = np.diff(signal.received) / 1e9
    stamps_vary, receipts_vary = (float(np.percentile(np.abs(one - usual), 80.0)) for one in (intervals, received))
    stamped = ''
    if max(stamps_vary, receipts_vary) > 0.02 * usual:
        stamped = SAMPLED if stamps_vary < 0.5 * receipts_vary else SENT if float(
            np.quantile(late, _LATE)) < 0.5 * stamps_vary else ''
    return Clock(stamps + floor, float(np.median(floor)), rate, float(np.quantile(late, _LATE)),
                 max(0.0, lost), stamped)


def _floor(stamps: Floats, took: Floats) -> Floats:
    """Return a lower envelope of the delays of messages [s]: the fastest of each window, so that clocks may drift."""
    count = min(_WINDOWS, stamps.size // _FEWEST)
    if count < 5:
        return np.full(stamps.size, took.min())
    parts = np.array_split(np.arange(stamps.size), count)
    fastest = np.array([part[took[part].argmin()] for part in parts])
    slope, height = np.polyfit(stamps[fastest], took[fastest], 1)
    line: Floats = height + slope * stamps
    # below all but a few
    line += np.quantile(took - line, 0.01)
    return line
