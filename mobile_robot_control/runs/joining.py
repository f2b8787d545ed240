"""One time base for the topics of a run: which message of each topic holds at each time."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobile_robot_control.figures.lines import Floats
from mobile_robot_control.recording.columns import COLUMNS, TRUE_ERROR
from mobile_robot_control.runs.series import Series
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
    tick : array of float, shape (n,)
        Time of the newest position tick [s].
    tick_number : array of int, shape (n,)
        The ticks counted.
    place : dict of str to array of int, shape (n,)
        By topic, the message whose values a row has; -1 where there is none.

    """

    series: Series
    time: Floats
    tick: Floats
    tick_number: Places
    place: dict[str, Places]

    def rows(self, begin: int, end: int) -> 'Joined':
        """Return the rows from the n-th up to, and without, another one."""
        return Joined(self.series, self.time[begin:end], self.tick[begin:end], self.tick_number[begin:end],
                      {topic: place[begin:end] for topic, place in self.place.items()})

    def values(self, topic: str) -> Floats:
        """Return the columns of a topic, shape (n, k); nan where there is no message."""
        place, values = self.place[topic], self.series.signals[topic].values
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
    newest = {topic: np.searchsorted(signal.stamps, clock, side='right') - 1
              for topic, signal in series.signals.items()}
    # of a topic that has not come yet, -1
    stamps = {topic: np.append(series.signals[topic].stamps, -1)[place] for topic, place in newest.items()}
    slow = np.stack([stamps[topic] for topic in POSITION_TOPICS if topic in _TICK or series.has(topic)])
    first, at = slow.min(axis=0), stamps['tracking_error']
    complete = np.flatnonzero((first >= 0) & (first == slow.max(axis=0)) if lockstep else first >= 0)
    ticks = complete[np.diff(at[complete], prepend=-1) > 0]
    number = np.searchsorted(ticks, np.arange(clock.size), side='right') - 1
    torque = stamps['wheel_torques']
    kept = np.flatnonzero((number >= 0) & (
        (torque == clock) | ((torque >= 0) & (not lockstep)) if series.has('wheel_torques') else True))
    number = number[kept]
    held = ticks[number]
    place = {topic: newest[topic][held] for topic in COLUMNS}
    place['wheel_torques'] = newest['wheel_torques'][kept]
    place['joint_states'] = newest['joint_states'][kept] if series.clock == 'joint_states' else np.full(kept.size, -1)
    if lockstep:
        place[TRUE_ERROR] = np.where(stamps[TRUE_ERROR][held] == at[held], place[TRUE_ERROR], -1)
    # on the wall clock a tick counts at the first row after it
    return Joined(series, (clock[kept] - series.origin) / 1e9,
                  (at[held] if lockstep else clock[held] - series.origin) / 1e9, number, place)
