"""Lockstep: which stamps a node answers, and how the plant waits for the answers."""

import enum
import time
from collections.abc import Callable

from rclpy.node import Node

from mobile_robot_control.readings import Refused
from mobile_robot_control.ros.timers import every

_REPEAT_AFTER = 0.1
"""[s] of wall time without progress."""
_LONGEST_LAG = 0.1
"""[s]: a run that falls further behind the wall clock does not catch up."""


class Turn(enum.Enum):
    """What a stamp means to a node."""

    STEP = 'the next one on the grid'
    START = 'a new run'
    JOIN = 'the first one accepted, of a run under way'
    AGAIN = 'asked again'
    REFUSED = 'neither of these'
    HOLD = 'to be held: the node runs on its own clock'


class StampGate:
    """
    Decides by stamp, never by arrival order, what a node does with a message.

    Parameters
    ----------
    period : int
        Of the node's grid [ns].

    Attributes
    ----------
    accepted : int or None
        The stamp of the last step [ns]; None before the first.

    """

    def __init__(self, period: int) -> None:
        self.period = period
        self.accepted: int | None = None

    def judge(self, stamp: int) -> Turn:
        """
        Say what a stamp means; nothing changes.

        Parameters
        ----------
        stamp : int
            [ns].

        Returns
        -------
        Turn
            What to do.

        """
        if stamp < 0 or stamp % self.period:
            return Turn.REFUSED
        if stamp == self.accepted:
            return Turn.AGAIN
        if stamp == 0:
            return Turn.START
        if self.accepted is None:
            return Turn.JOIN
        return Turn.STEP if stamp == self.accepted + self.period else Turn.REFUSED

    def objection(self, stamp: int) -> Refused:
        """
        Say why a stamp is refused.

        Parameters
        ----------
        stamp : int
            [ns].

        Returns
        -------
        Refused
            To be counted.

        """
        if stamp < 0 or stamp % self.period:
            return Refused('stamp not on the grid', f'{stamp / 1e9} s; the period is {self.period / 1e9} s')
        return Refused('not the next stamp', f'{stamp / 1e9} s after {(self.accepted or 0) / 1e9} s')

    def accept(self, stamp: int) -> None:
        """
        Take a stamp as the one of the last step.

        Parameters
        ----------
        stamp : int
            [ns].

        """
        self.accepted = stamp


class Pace:
    """
    Holds simulated time back to a multiple of wall time, repeats what is not answered, and knows the answer's stamp.

    Parameters
    ----------
    node : Node
        The plant's.
    period : int
        Of the velocity grid [ns].
    real_time_factor : float
        1 is wall speed, 0 as fast as it goes.
    publish : callable
        Publishes what the plant has to say at the present time.
    repeat : callable
        Publishes it again, told how long [s] there has been no answer.

    Attributes
    ----------
    asking : bool
        Whether the present time has been published and not yet answered.
    overruns : int
        How often the run fell too far behind the wall clock to catch up.

    """

    def __init__(
        self, node: Node, period: int, real_time_factor: float, publish: Callable[[], None],
        repeat: Callable[[float], None],
    ) -> None:
        self._publish, self._repeat = publish, repeat
        self._wall_period = period / 1e9 / real_time_factor if real_time_factor > 0.0 else 0.0
        self._due = self._asked = time.monotonic()
        self._period, self._present = period, 0
        self.asking, self.overruns = False, 0
        every(_REPEAT_AFTER, self._look, node)
        if self._wall_period > 0.0:
            every(max(self._wall_period, 5e-4), self._tick, node)

    def judge(self, stamp: int) -> Turn:
        """
        Say what the stamp of an answer means.

        Parameters
        ----------
        stamp : int
            [ns].

        Returns
        -------
        Turn
            STEP for the answer that is waited for, AGAIN for an earlier one: what was asked twice is answered twice.

        """
        if stamp < 0 or stamp > self._present or stamp % self._period:
            return Turn.REFUSED
        return Turn.STEP if self.asking and stamp == self._present else Turn.AGAIN

    def objection(self, stamp: int) -> Refused:
        """
        Say why a stamp is refused.

        Parameters
        ----------
        stamp : int
            [ns].

        Returns
        -------
        Refused
            To be counted.

        """
        return Refused('not the present stamp', f'{stamp / 1e9} s at {self._present / 1e9} s')

    def ask(self, present: int) -> None:
        """
        Publish now, or as soon as the wall clock allows.

        Parameters
        ----------
        present : int
            Simulated time [ns].

        """
        self._present = present
        self._due += self._wall_period
        self.asking = False
        self._tick()

    def remind(self) -> None:
        """Ask again at once what is not answered."""
        if self.asking:
            self._repeat(0.0)

    def _tick(self) -> None:
        now = time.monotonic()
        if self.asking or now < self._due:
            return
        if now - self._due > _LONGEST_LAG:
            self._due = now - _LONGEST_LAG
            self.overruns += self._wall_period > 0.0
        self.asking, self._asked = True, now
        self._publish()

    def _look(self) -> None:
        silence = time.monotonic() - self._asked
        if self.asking and silence >= _REPEAT_AFTER:
            self._repeat(silence)
