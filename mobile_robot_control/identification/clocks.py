"""The clocks of a recording: when messages were stamped, when they came, and what that tells of the robot."""

from typing import NamedTuple

import numpy as np

from mobile_robot_control.figures.lines import Floats
from mobile_robot_control.runs.series import Signal

_A_DAY = 86400.0
_WINDOWS = 20
_FEWEST = 25
"""Messages of a window in which the fastest one is looked for."""
_LATE = 0.98
"""Quantile of the lateness that counts as its largest."""
SAMPLED, SENT = 'sampled', 'sent'


class Clock(NamedTuple):
    """
    How a topic was stamped, on the recorder's clock.

    Attributes
    ----------
    times : array of float, shape (n,)
        Of the messages: their stamps, moved by what the fastest messages took to come [s].
    floor : float
        What these took, with the offset between both clocks [s].
    rate : float
        At which messages were sent, lost ones among them [Hz].
    jitter : float
        By how much messages came later than the fastest ones [s].
    lost : float
        Share of the messages that are missing, if they are sent at the usual rate.
    stamped : str
        SAMPLED, SENT, or '' where that cannot be told.
    """

    times: Floats
    floor: float
    rate: float
    jitter: float
    lost: float
    stamped: str


def is_wall(signal: Signal) -> bool:
    """Return whether stamps are those of a wall clock, near the time at which the messages were received."""
    return bool(signal.received.size and abs(np.median(signal.received - signal.stamps)) < 1e9 * _A_DAY)


def read_clock(signal: Signal, origin: int, on_receipt: bool) -> Clock:
    """
    Return the clock of a topic that has at least two messages.

    Parameters
    ----------
    signal : Signal
        With stamps, and times of receipt.
    origin : int
        Stamp of t = 0 [ns].
    on_receipt : bool
        Whether times are moved to the clock of the recorder; stamps of simulated time are as they are.
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
    """Return a line below what messages took [s]: the fastest of each window, so that clocks may drift."""
    count = min(_WINDOWS, stamps.size // _FEWEST)
    if count < 5:
        return np.full(stamps.size, took.min())
    parts = np.array_split(np.arange(stamps.size), count)
    fastest = np.array([part[took[part].argmin()] for part in parts])
    slope, height = np.polyfit(stamps[fastest], took[fastest], 1)
    line: Floats = height + slope * stamps
    # below all but single ones
    line += np.quantile(took - line, 0.01)
    return line
