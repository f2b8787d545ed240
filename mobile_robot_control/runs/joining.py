"""One time base for the topics of a run: which message of each topic holds at each time."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.figures.lines import Floats
from mobile_robot_control.recording.columns import COLUMNS, TRUE_ERROR
from mobile_robot_control.runs.series import Series, Stamps
from mobile_robot_control.topics import POSITION_TOPICS

Places = NDArray[np.intp]
_TICK = ('odom', 'reference', 'tracking_error')
"""What a position tick needs; other topics are held where there are any."""


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
        By topic, the message whose values a tick has; -1 where there is none.
    at_rows : dict of str to array of int, shape (n,)
        The same of the topics whose values a row has.

    """

    series: Series
    time: Floats
    number: Places
    tick: Floats
    at_ticks: dict[str, Places]
    at_rows: dict[str, Places]

    def rows(self, begin: int, end: int) -> 'Joined':
        """Return the rows from the n-th up to, and without, another one."""
        return self._replace(time=self.time[begin:end], number=self.number[begin:end],
                             at_rows={topic: place[begin:end] for topic, place in self.at_rows.items()})

    def values(self, topic: str) -> Floats:
        """Return the columns of a topic at each row, shape (n, k); nan where there is no message."""
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
        In lockstep a row for each stamp that both fast topics have, with the newest position tick that all slow topics
        have. On the wall clock, where every node has stamps of its own, one for each ``joint_states``, with the newest
        of all others, from the time on when all have come. Odometry, reference and error are needed; without
        ``joint_states``, or where they come less often than errors, there is a row for each error.

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
    asked, stamps = newest('wheel_torques', clock)
    if series.has('wheel_torques'):
        kept &= (stamps == clock) | ((stamps >= 0) & (not lockstep))
    at_rows = {'wheel_torques': asked[kept], 'joint_states': newest('joint_states', clock[kept])[0]}
    if series.clock != 'joint_states':
        at_rows['joint_states'][:] = -1
    at_ticks = {topic: newest(topic, at)[0] for topic in COLUMNS if topic not in at_rows}
    if lockstep:
        at_ticks[TRUE_ERROR][newest(TRUE_ERROR, at)[1] != error] = -1
    # on the wall clock a tick counts at the first row after it
    return Joined(series, (clock[kept] - series.origin) / 1e9, number[kept],
                  (error if lockstep else at - series.origin) / 1e9, at_ticks, at_rows)
