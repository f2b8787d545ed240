"""
Robot and cart at the time of each row of a run: between the position ticks that the topics carry.

Recorded and simulated runs go through the same functions, so that their rows mean the same.
"""

import numpy as np

from mobile_robot_control.figures.lines import Floats
from mobile_robot_control.runs.gaps import MANY_PERIODS
from mobile_robot_control.runs.joining import Joined


def _held(joined: Joined) -> dict[str, Floats]:
    """Return the values of the newest position tick at each row."""
    (motion, error), cart = joined.truth(), joined.values('reference')
    return {'pose': motion[:, :3], 'velocity': motion[:, 3:], 'reference': cart[:, :3],
            'reference_velocity': cart[:, 3:], 'tracking_error': error}


def moving_at(joined: Joined) -> dict[str, Floats]:
    """
    Return where robot and cart are at the time of each row.

    Parameters
    ----------
    joined : Joined
        The rows of a run.

    Returns
    -------
    dict of str to array
        `pose`, `velocity`, `reference`, `reference_velocity` and `tracking_error`, interpolated; in gaps of the
        recording, and for what is not known, those of the newest position tick.

    """
    held, series, time = _held(joined), joined.series, joined.time
    robot = series.motion if series.hides_truth else 'odom'
    made: dict[str, Floats] = {}
    known = np.ones(time.size, dtype=bool)
    for topic, pose, velocity in ((robot, 'pose', 'velocity'), ('reference', 'reference', 'reference_velocity')):
        ticks = series.time(topic)
        if not ticks.size:
            return held
        # the interval of each row; behind the last message, that message's own
        now = np.clip(np.searchsorted(ticks, time, side='right') - 1, 0, None)
        after = np.minimum(now + 1, ticks.size - 1)
        apart = ticks[after] - ticks[now]
        known &= apart <= MANY_PERIODS * np.median(np.diff(ticks)) if ticks.size > 1 else True
        x, y, heading, v, omega = (
            series.line(topic, name).value for name in ('x', 'y', 'heading', 'linear', 'angular'))
        # a motion that diverges overflows
        with np.errstate(over='ignore', invalid='ignore'):
            turn = heading[now] + _wrapped(heading[after] - heading[now])
            passed = time - ticks[now]
            made[pose] = np.column_stack([
                _hermite(x[now], x[after], (v * np.cos(heading))[[now, after]], passed, apart),
                _hermite(y[now], y[after], (v * np.sin(heading))[[now, after]], passed, apart),
                _wrapped(_hermite(heading[now], turn, omega[[now, after]], passed, apart))])
            share = np.divide(passed, apart, out=np.zeros_like(passed), where=apart > 0.0)
            made[velocity] = np.column_stack([each[now] + share * (each[after] - each[now]) for each in (v, omega)])
    made['tracking_error'] = _errors(made['reference'], made['pose'])
    # a row at a tick keeps its bits
    at_tick = np.isin(time, series.time(robot)) & np.isin(time, series.time('reference'))
    for name, values in made.items():
        kept = ~known | at_tick | np.isnan(held[name]).any(axis=1)
        made[name] = np.where(kept[:, None], held[name], values)
    return made


def _wrapped(angle: Floats) -> Floats:
    """Return angles in (-π, π] [rad]."""
    return np.asarray(np.pi - np.remainder(np.pi - angle, 2.0 * np.pi))


def _hermite(start: Floats, end: Floats, rates: Floats, passed: Floats, apart: Floats) -> Floats:
    """
    Return the cubic through values and rates at both ends of an interval (Hermite).

    Parameters
    ----------
    start, end : array, shape (n,)
        Values.
    rates : array, shape (2, n)
        At both ends [1/s].
    passed, apart : array, shape (n,)
        Time since the start, and length of the interval [s]; of length 0, the rate of the start is held.

    """
    s = np.divide(passed, apart, out=np.zeros_like(passed), where=apart > 0.0)
    change, begun, ended = end - start, rates[0] * apart, rates[1] * apart
    cubic = s * (begun + s * (3.0 * change - 2.0 * begun - ended + s * (begun + ended - 2.0 * change)))
    return np.asarray(start + np.where(apart > 0.0, cubic, rates[0] * passed))


def _errors(reference: Floats, pose: Floats) -> Floats:
    """Return the tracking errors, Eq. (23), of rows of poses [m], [m], [rad]."""
    with np.errstate(over='ignore', invalid='ignore'):
        ahead, aside, turn = (reference - pose).T
        cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        # Eq. (23): e1, e2, e3
        return np.column_stack([cos * ahead + sin * aside, cos * aside - sin * ahead, _wrapped(turn)])
