"""Stamps for messages that have none, from the times at which they were received."""

from bisect import bisect_right

import numpy as np

from mobile_robot_control.runs.series import Signal
from mobile_robot_control.stamps import NANOSECONDS

_AGREE = NANOSECONDS
"""[ns]: stamps that are nearer to their receipt than this are of the recorder's clock."""


def stamped_by_receipt(plain: Signal, clock: Signal) -> Signal:
    """
    Return messages that were stamped with their receipt on the clock of another topic.

    Parameters
    ----------
    plain : Signal
        Whose stamps are the times of receipt [ns].
    clock : Signal
        Such as odometry, with stamps and times of receipt.

    Returns
    -------
    Signal
        As it is where the clock's stamps are wall times of the same clock. Where they are of simulated time, or of a
        computer whose clock is wrong, each receipt is read on the clock, between the receipts of two of its messages;
        what was received before the first or after the last of them is left out.
    """
    if not clock.received.size or abs(np.median(clock.received - clock.stamps)) < _AGREE:
        return plain
    # whole numbers of Python: products of times in ns are larger than 64 bits
    pairs = sorted(zip(clock.received.tolist(), clock.stamps.tolist(), strict=True))
    times = [received for received, _ in pairs]
    kept: list[int] = []
    stamps: list[int] = []
    for n, received in enumerate(plain.received.tolist()):
        after = bisect_right(times, received)
        if 0 < after < len(pairs):
            (begun, first), (ended, last) = pairs[after - 1], pairs[after]
            stamp = first + (last - first) * (received - begun) // (ended - begun)
            if not stamps or stamp > stamps[-1]:
                kept.append(n)
                stamps.append(stamp)
    return Signal(np.array(stamps, np.int64), plain.received[kept], plain.values[kept])
