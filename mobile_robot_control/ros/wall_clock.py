"""The wall clock: every node at its own rate, with the newest input that it holds."""

import time
from collections.abc import Callable

from rclpy.node import Node

from mobile_robot_control.readings import Refused
from mobile_robot_control.ros.lockstep import Turn
from mobile_robot_control.ros.timers import every

_LONGEST_LAG = 0.1
"""[s]: a node that was held up longer does not catch up."""


class ClockGate:
    """
    Lets stamps in that are neither old nor future, to be held until the node's own clock asks for them.

    The wall clock's StampGate.

    Parameters
    ----------
    node : Node
        Whose clock it is.
    tolerance : float
        How far a stamp may be from now [s].

    Attributes
    ----------
    accepted : None
        No stamp is ever answered.

    """

    accepted = None

    def __init__(self, node: Node, tolerance: float) -> None:
        self._clock, self._tolerance = node.get_clock(), tolerance

    def judge(self, stamp: int) -> Turn:
        """
        Say what a stamp means.

        Parameters
        ----------
        stamp : int
            [ns].

        Returns
        -------
        Turn
            HOLD or REFUSED.

        """
        return Turn.HOLD if abs(self._age(stamp)) <= self._tolerance else Turn.REFUSED

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
        age = self._age(stamp)
        reason = 'stamp too old' if age > 0.0 else 'stamp in the future'
        return Refused(reason, f'by {abs(age):.3f} s; stamp_tolerance is {self._tolerance} s: stamp messages with the '
                       'time at which they are sent, set the clocks of both machines alike, or raise it')

    def accept(self, stamp: int) -> None:
        """
        Answer a stamp, which never happens here.

        Parameters
        ----------
        stamp : int
            [ns].

        """

    def _age(self, stamp: int) -> float:
        return (int(self._clock.now().nanoseconds) - stamp) / 1e9


class Ticker:
    """
    Calls a step at a fixed rate by the steady clock.

    Parameters
    ----------
    node : Node
        Whose timer it is.
    rate : float
        [Hz].
    tick : callable
        The step. After a delay it is called as often as was missed, up to 0.1 s worth of it.

    Attributes
    ----------
    overruns : int
        Ticks that came a whole period late or were left out.

    """

    def __init__(self, node: Node, rate: float, tick: Callable[[], None]) -> None:
        self.overruns = 0
        self._period, self._tick = 1.0 / rate, tick
        self._due = time.monotonic() + self._period
        every(self._period, self._run, node)

    def _run(self) -> None:
        now = time.monotonic()
        late = int((now - self._due) / self._period) if now > self._due else 0
        self.overruns += late
        self._due = max(self._due, now - _LONGEST_LAG)
        # half a period of slack: the timer and this count must not beat against each other
        while self._due <= now + 0.5 * self._period:
            self._due += self._period
            self._tick()
