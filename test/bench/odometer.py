"""How far a lockstep run has got, by the stamps of its odometry."""

import time

from nav_msgs.msg import Odometry

from bench.graph import Graph
from bench.listener import Listener
from mobile_robot_control.messages.parsing import serialised_stamp
from mobile_robot_control.ros.shared.qos import SUBSCRIBED


class Odometer(Listener):
    """Reads the simulated time from odometry, which comes at the position rate alone."""

    def __init__(self, graph: Graph) -> None:
        super().__init__(graph.domain)
        self._graph = graph
        self._newest = (0.0, -1)
        self.listen_to('odom', Odometry, self._take, SUBSCRIBED)

    def _take(self, message: bytes) -> None:
        self._newest = (time.monotonic(), serialised_stamp(message))

    def reach(self, stamp: int) -> tuple[float, int]:
        """Wait for a stamp later than this one; give the time of its receipt [s], and the stamp [ns]."""
        self.until(lambda: self._newest[1] > stamp, 30.0, self._graph.check)
        return self._newest

    def speed(self, seconds: float) -> float:
        """Give simulated seconds in a second of wall time."""
        began, first = self.reach(self._newest[1])
        self.until(lambda: self._newest[0] > began + seconds, seconds + 30.0, self._graph.check)
        ended, last = self._newest
        return (last - first) / 1e9 / (ended - began)
