"""
One time base for the topics of a run: the valid message of each row, and the motion of robot and cart between messages.

Recorded and simulated runs pass through the same functions, so their rows have the same meaning.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.figures.figure import Floats
from mobile_robot_control.runs.columns import COLUMNS, TRUE_ERROR
from mobile_robot_control.runs.series import MANY_PERIODS, Series, Stamps
from mobile_robot_control.topics import POSITION_TOPICS

Places = NDArray[np.intp]
_TICK = ('odom', 'reference', 'tracking_error')
"""Topics required for a position tick; other topics are held if present."""


class Joined(NamedTuple):
    """
    The rows of a run.

    Attributes
    ----------
    series : Series
        Its topics.
    time : array of float, shape (n,)
        Of each row [s].
    number : array of int, shape (n,)
        The newest position tick of each row, from 0.
    tick : array of float, shape (m,)
        Times of the position ticks [s].
    at_ticks : dict of str to array of int, shape (m,)
        By topic, the message used at a tick; -1 for none.
    at_rows : dict of str to array of int, shape (n,)
        By topic, the message used in a row.

    """

    series: Series
    time: Floats
    number: Places
    tick: Floats
    at_ticks: dict[str, Places]
    at_rows: dict[str, Places]

    def rows(self, begin: int, end: int) -> 'Joined':
        """Return the rows from index `begin` up to, but without, `end`."""
        return self._replace(time=self.time[begin:end], number=self.number[begin:end],
                             at_rows={topic: place[begin:end] for topic, place in self.at_rows.items()})

    def values(self, topic: str) -> Floats:
        """Return the columns of a topic at each row, shape (n, k); nan without a message."""
        place = self.at_rows[topic] if topic in self.at_rows else self.at_ticks[topic][self.number]
        values = self.series.signals[topic].values
        if not len(values):
            return np.full((place.size, values.shape[1]), np.nan)
        return np.where(place[:, None] < 0, np.nan, values[place])

    def truth(self) -> tuple[Floats, Floats]:
        """Return motion and tracking error, columns of `odom` and `tracking_error`: the true ones if they are known."""
        if not self.series.hides_truth:
            return self.values('odom'), self.values('tracking_error')
        error = self.values(TRUE_ERROR)
        return np.where(np.isnan(error[:, :1]), np.nan, self.values(self.series.motion)), error


def join(series: Series) -> Joined:
    """
    Join the topics of a run by stamp.

    Parameters
    ----------
    series : Series
        With the errors that no topic carries, see `with_errors`.

    Returns
    -------
    Joined
        In lockstep a row for each stamp common to both fast topics, with the newest position tick common to all slow
        topics. On the wall clock, where every node has its own stamps, a row for each ``joint_states``, with the newest
        of all others, once all have come. Odometry, reference and error are required; without ``joint_states``, or if
        they come less often than errors, there is a row for each error.

    """
    lockstep, clock = series.is_lockstep, series.signals[series.clock].stamps

    def newest(topic: str, at: Stamps) -> tuple[Places, Stamps]:
        """Return the newest message of a topic at each of some stamps, and its stamp; -1 before the first."""
        stamps = series.signals[topic].stamps
        place = np.searchsorted(stamps, at, side='right') - 1
        return place, np.append(stamps, -1)[place]

    _, error = newest('tracking_error', clock)
    oldest, latest = error, error
    for topic in POSITION_TOPICS:
        if topic in _TICK or series.has(topic):
            _, stamps = newest(topic, clock)
            oldest, latest = np.minimum(oldest, stamps), np.maximum(latest, stamps)
    complete = np.flatnonzero((oldest >= 0) & (oldest == latest) if lockstep else oldest >= 0)
    ticks = complete[np.diff(error[complete], prepend=-1) > 0]
    at, error = clock[ticks], error[ticks]
    number = np.searchsorted(ticks, np.arange(clock.size), side='right') - 1
    kept = number >= 0
    torque_places, stamps = newest('wheel_torques', clock)
    if series.has('wheel_torques'):
        kept &= (stamps == clock) | ((stamps >= 0) & (not lockstep))
    at_rows = {'wheel_torques': torque_places[kept], 'joint_states': newest('joint_states', clock[kept])[0]}
    if series.clock != 'joint_states':
        at_rows['joint_states'][:] = -1
    at_ticks = {topic: newest(topic, at)[0] for topic in COLUMNS if topic not in at_rows}
    if lockstep:
        at_ticks[TRUE_ERROR][newest(TRUE_ERROR, at)[1] != error] = -1
    # on the wall clock a tick counts at the first row after it
    return Joined(series, (clock[kept] - series.origin) / 1e9, number[kept],
                  (error if lockstep else at - series.origin) / 1e9, at_ticks, at_rows)


def _held(joined: Joined) -> dict[str, Floats]:
    """Return the values of the newest position tick at each row."""
    (motion, error), cart = joined.truth(), joined.values('reference')
    return {'pose': motion[:, :3], 'velocity': motion[:, 3:], 'reference': cart[:, :3],
            'reference_velocity': cart[:, 3:], 'tracking_error': error}


def moving_at(joined: Joined) -> dict[str, Floats]:
    """
    Return the motion of robot and cart at the time of each row.

    Parameters
    ----------
    joined : Joined
        The rows of a run.

    Returns
    -------
    dict of str to array
        `pose`, `velocity`, `reference`, `reference_velocity` and `tracking_error`, interpolated; in gaps of the
        recording, and for unknown values, those of the newest position tick.

    """
    held, series, time = _held(joined), joined.series, joined.time
    robot = series.motion if series.hides_truth else 'odom'
    moving: dict[str, Floats] = {}
    is_known = np.ones(time.size, dtype=bool)
    for topic, pose, velocity in ((robot, 'pose', 'velocity'), ('reference', 'reference', 'reference_velocity')):
        ticks = series.time(topic)
        if not ticks.size:
            return held
        # the interval of each row; after the last message, that message's own
        now = np.clip(np.searchsorted(ticks, time, side='right') - 1, 0, None)
        after = np.minimum(now + 1, ticks.size - 1)
        apart = ticks[after] - ticks[now]
        is_known &= apart <= MANY_PERIODS * np.median(np.diff(ticks)) if ticks.size > 1 else True
        x, y, heading, v, omega = (
            series.line(topic, name).value for name in ('x', 'y', 'heading', 'linear', 'angular'))
        # a diverging motion overflows
        with np.errstate(over='ignore', invalid='ignore'):
            turn = heading[now] + _wrapped(heading[after] - heading[now])
            passed = time - ticks[now]
            moving[pose] = np.column_stack([
                _hermite(x[now], x[after], (v * np.cos(heading))[[now, after]], passed, apart),
                _hermite(y[now], y[after], (v * np.sin(heading))[[now, after]], passed, apart),
                _wrapped(_hermite(heading[now], turn, omega[[now, after]], passed, apart))])
            share = np.divide(passed, apart, out=np.zeros_like(passed), where=apart > 0.0)
            moving[velocity] = np.column_stack([each[now] + share * (each[after] - each[now]) for each in (v, omega)])
    moving['tracking_error'] = _errors(moving['reference'], moving['pose'])
    # a row at a tick keeps its bits
    at_tick = np.isin(time, series.time(robot)) & np.isin(time, series.time('reference'))
    for name, values in moving.items():
        kept = ~is_known | at_tick | np.isnan(held[name]).any(axis=1)
        moving[name] = np.where(kept[:, None], held[name], values)
    return moving


def _wrapped(angle: Floats) -> Floats:
    """Return angles in (-π, π] [rad]."""
    return np.asarray(np.pi - np.remainder(np.pi - angle, 2.0 * np.pi))


def _hermite(start: Floats, end: Floats, rates: Floats, passed: Floats, apart: Floats) -> Floats:
    """Return the cubics through values, shape (n,), and rates [1/s], shape (2, n), at both ends of intervals [s]."""
    # in an interval of length 0, the rate of the start is held
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
