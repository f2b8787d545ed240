"""The wall clock: every node at its own rate, with the newest input that it holds."""

import time
from collections.abc import Callable

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node

from mobile_robot_control.ros.lockstep import Turn

_LONGEST_LAG = 0.1
"""[s]: a node that was held up longer does not catch up."""


class OpenGate:
    """
    Lets every stamp in, to be held until the node's own clock asks for it: the wall clock's StampGate.

    Attributes
    ----------
    accepted : None
        No stamp is ever answered.

    """

    accepted = None

    def judge(self, stamp: int) -> Turn:  # noqa: ARG002 (one gate is like the other)
        """
        Say what a stamp means.

        Parameters
        ----------
        stamp : int
            [ns].

        Returns
        -------
        Turn
            Always HOLD.

        """
        return Turn.HOLD

    def accept(self, stamp: int) -> None:
        """
        Answer a stamp, which never happens here.

        Parameters
        ----------
        stamp : int
            [ns].

        """


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
        node.create_timer(self._period, self._run, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _run(self) -> None:
        now = time.monotonic()
        late = int((now - self._due) / self._period) if now > self._due else 0
        self.overruns += late
        self._due = max(self._due, now - _LONGEST_LAG)
        # half a period of slack: the timer and this count must not beat against each other
        while self._due <= now + 0.5 * self._period:
            self._due += self._period
            self._tick()
