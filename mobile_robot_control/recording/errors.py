"""Tracking errors computed from poses and reference, where no topic carries them."""

import math
from array import array
from collections.abc import Iterator

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import Pose
from mobile_robot_control.recording.gaps import MANY_PERIODS, period
from mobile_robot_control.recording.signals import COLUMNS, GROUND_TRUTH, TRUE_ERROR, Signal, is_lockstep

_ROUNDING = 1e-9
"""[m], [rad]: a pose loses less on its way through a quaternion."""


def _poses(signal: Signal) -> Iterator[tuple[int, Pose]]:
    """Yield stamp and pose of each message of odometry or of the reference."""
    width = len(COLUMNS['odom'])
    for n, stamp in enumerate(signal.stamps):
        yield stamp, Pose(*signal.values[n * width:n * width + 3])


def _between(before: tuple[int, Pose], after: tuple[int, Pose], stamp: int) -> Pose:
    """Return the pose at a stamp between two others, on the straight line; bit for bit theirs at their own stamps."""
    (first, start), (last, end) = before, after
    if stamp in (first, last):
        return start if stamp == first else end
    share = (stamp - first) / (last - first)
    return Pose(start.x + share * (end.x - start.x), start.y + share * (end.y - start.y),
                start.heading + share * wrap_angle(end.heading - start.heading))


def error_signal(poses: Signal, reference: Signal) -> Signal:
    """
    Compute the tracking error of each pose, against the reference interpolated to the pose's stamp.

    Parameters
    ----------
    poses, reference : Signal
        Of odometry and of the reference cart, in one frame; their rates and the phases of their stamps may differ.

    Returns
    -------
    Signal
        Columns of `tracking_error` at the stamps of the poses. There is none before the first reference, after the
        last one, and in gaps of it.

    Notes
    -----
    Between two messages the reference is taken to be on the straight line. On a curve of radius R at speed v and a
    period T between them that costs at most v² T² / (8 R): 0.16 mm at 0.5 m/s, 0.5 m and 20 Hz. The newest message in
    its place would cost up to v T: 25 mm.
    """
    found = Signal(array('q'), array('q'), array('d'))
    references = _poses(reference)
    before = after = next(references, None)
    longest = MANY_PERIODS * period(reference.stamps)
    for stamp, pose in _poses(poses):
        while after is not None and after[0] < stamp:
            before, after = after, next(references, None)
        if before is None or after is None or before[0] > stamp:
            continue
        if stamp == after[0] or after[0] - before[0] <= longest:
            found.stamps.append(stamp)
            found.values.extend(tracking_error(_between(before, after, stamp), pose))
    return found


def with_errors(signals: dict[str, Signal], exact: bool) -> dict[str, Signal]:
    """
    Return the signals of a run with the errors that no topic of it carries.

    Parameters
    ----------
    signals : dict of str to Signal
        By topic.
    exact : bool
        Whether odometry is known to be the true motion.

    Returns
    -------
    dict of str to Signal
        With `tracking_error` computed where it was not recorded; and the true error, where the true motion is known and
        the position controller saw another one: with noise, or with odometry that it has carried forward.
    """
    made = dict(signals)
    reference = signals['reference']
    if not signals['tracking_error'].stamps:
        made['tracking_error'] = error_signal(signals['odom'], reference)
    if signals[GROUND_TRUTH].stamps:
        if not signals[TRUE_ERROR].stamps:
            made[TRUE_ERROR] = error_signal(signals[GROUND_TRUTH], reference)
    elif exact:
        true = error_signal(signals['odom'], reference)
        if not (is_lockstep(signals) and _agree(true, made['tracking_error'])):
            made[TRUE_ERROR] = true
    return made


def _agree(one: Signal, other: Signal) -> bool:
    """Return whether errors are the same, but for rounding, at the stamps that both have."""
    width = len(COLUMNS[TRUE_ERROR])
    place = {stamp: n * width for n, stamp in enumerate(other.stamps)}
    for n, stamp in enumerate(one.stamps):
        if stamp in place:
            ours, theirs = one.values[n * width:(n + 1) * width], other.values[place[stamp]:place[stamp] + width]
            apart = [a - b for a, b in zip(ours, theirs, strict=True)]
            if math.hypot(apart[0], apart[1]) > _ROUNDING or abs(wrap_angle(apart[2])) > _ROUNDING:
                return False
    return True
