"""How far a lockstep run has got, by the stamps of its odometry."""

import time

from nav_msgs.msg import Odometry

from bench.ear import Ear
from bench.graph import Graph
from mobile_robot_control.messages.parsing import serialised_stamp
from mobile_robot_control.ros.qos import SUBSCRIBED


class Odometer(Ear):
    """Hears how far simulated time has got, ten times less often than it steps."""

    def __init__(self, graph: Graph) -> None:
        super().__init__(graph.domain)
        self._graph = graph
        self._heard = (0.0, -1)
        self.listen_to('odom', Odometry, self._hear, SUBSCRIBED)

    def _hear(self, message: bytes) -> None:
        self._heard = (time.monotonic(), serialised_stamp(message))

    def reach(self, stamp: int) -> tuple[float, int]:
        """Wait for a stamp later than this one; give when it was heard [s], and the stamp [ns]."""
        self.until(lambda: self._heard[1] > stamp, 30.0, self._graph.check)
        return self._heard

    def speed(self, seconds: float) -> float:
        """Give simulated seconds in a second of wall time."""
        began, first = self.reach(self._heard[1])
        self.until(lambda: self._heard[0] > began + seconds, seconds + 30.0, self._graph.check)
        ended, last = self._heard
        return (last - first) / 1e9 / (ended - began)
