"""Tracking errors computed from poses and reference, if no topic carries them."""

import numpy as np

from mobile_robot_control.angles import wrap_angle
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.quantities import Pose
from mobile_robot_control.runs.columns import TRUE_ERROR
from mobile_robot_control.runs.series import MANY_PERIODS, Series, Signal, empty_signal, period
from mobile_robot_control.topics import GROUND_TRUTH

_ROUNDING = 1e-9
"""[m], [rad]: more than a pose loses in a quaternion."""


def _poses_between(before: Floats, after: Floats, share: Floats) -> Floats:
    """Return poses on the straight lines between others, shape (n, 3); bit for bit the others' at their own stamps."""
    change = after - before
    change[:, 2] = [wrap_angle(turn) for turn in change[:, 2].tolist()]
    between = before + share[:, None] * change
    return np.where(share[:, None] == 0.0, before, np.where(share[:, None] == 1.0, after, between))


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
        Columns of `tracking_error` at the stamps of the poses. There is no error before the first reference, after the
        last one, and in its gaps.

    Notes
    -----
    Between two messages the reference is assumed on the straight line. On a curve of radius R at speed v and a period T
    between them the error is at most v² T² / (8 R): 0.16 mm at 0.5 m/s, 0.5 m and 20 Hz. With the newest message
    instead, it would be up to v T: 25 mm.
    """
    signal = empty_signal('tracking_error')
    ticks = reference.stamps
    if not ticks.size:
        return signal
    after = np.searchsorted(ticks, poses.stamps)
    within = np.flatnonzero((after < ticks.size) & (poses.stamps >= ticks[0]))
    after, stamps = after[within], poses.stamps[within]
    before = np.maximum(after - 1, 0)
    apart = ticks[after] - ticks[before]
    usable = np.flatnonzero((stamps == ticks[after]) | (apart <= MANY_PERIODS * period(ticks)))
    before, after, stamps, apart = before[usable], after[usable], stamps[usable], apart[usable]
    share = np.divide(stamps - ticks[before], apart, out=np.zeros(stamps.size), where=apart > 0)
    carts = _poses_between(reference.values[before, :3], reference.values[after, :3], share)
    robots = poses.values[within[usable], :3]
    errors = [tracking_error(Pose(*cart), Pose(*robot))
              for cart, robot in zip(carts.tolist(), robots.tolist(), strict=True)]
    return signal._replace(stamps=stamps, values=np.array(errors, float).reshape(-1, 3))


def with_errors(series: Series, exact: bool) -> Series:
    """
    Add the errors that no topic of a run carries.

    Parameters
    ----------
    series : Series
        Of a run.
    exact : bool
        Whether odometry shows the true motion if `ground_truth` is not recorded.

    Returns
    -------
    Series
        The error if `tracking_error` was not recorded, and `true_error` if the truth is known and the position
        controller saw another one: with noise, or with extrapolated odometry.
    """
    signals = dict(series.signals)
    reference = signals['reference']
    if not series.has('tracking_error'):
        signals['tracking_error'] = error_signal(signals['odom'], reference)
    if series.has(GROUND_TRUTH):
        if not series.has(TRUE_ERROR):
            signals[TRUE_ERROR] = error_signal(signals[GROUND_TRUTH], reference)
    elif exact:
        true = error_signal(signals['odom'], reference)
        if not (series.is_lockstep and _agree(true, signals['tracking_error'])):
            signals[TRUE_ERROR] = true
    return Series(signals)


def _agree(signal: Signal, other: Signal) -> bool:
    """Return whether errors are equal, except for rounding, at their common stamps."""
    _, ours, theirs = np.intersect1d(signal.stamps, other.stamps, assume_unique=True, return_indices=True)
    ahead, aside, turn = (signal.values[ours] - other.values[theirs]).T
    turned = np.abs(np.pi - np.remainder(np.pi - turn, 2.0 * np.pi))
    return not ((np.hypot(ahead, aside) > _ROUNDING) | (turned > _ROUNDING)).any()
