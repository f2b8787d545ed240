"""Stamps for messages that have none, from the times at which they were received."""

from array import array
from bisect import bisect_right
from statistics import median

from mobile_robot_control.recording.signals import Signal
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
    pairs = list(zip(clock.received, clock.stamps, strict=False))
    if not pairs or abs(median(received - stamp for received, stamp in pairs)) < _AGREE:
        return plain
    pairs.sort()
    times = [received for received, _ in pairs]
    width = len(plain.values) // max(1, len(plain.stamps))
    found = Signal(array('q'), array('q'), array('d'))
    for n, received in enumerate(plain.received):
        after = bisect_right(times, received)
        if 0 < after < len(pairs):
            (begun, first), (ended, last) = pairs[after - 1], pairs[after]
            stamp = first + (last - first) * (received - begun) // (ended - begun)
            if not found.stamps or stamp > found.stamps[-1]:
                found.stamps.append(stamp)
                found.received.append(received)
                found.values.extend(plain.values[n * width:(n + 1) * width])
    return found
