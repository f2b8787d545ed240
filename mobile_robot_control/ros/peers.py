"""Who is missing: nodes notice silent inputs, and the plant says for whom a run waits."""

import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.subscription import Subscription

from mobile_robot_control.readings import Refused, serialised_stamp
from mobile_robot_control.ros.qos import NEWEST
from mobile_robot_control.ros.timers import every

_STALL = 0.5
"""[s]: a shorter silence is a busy machine's. Subscriptions that come and go cost every node on the network memory."""


class Peers:
    """
    Watches a node's inputs: a silent one is named once in the log, and its return once.

    Parameters
    ----------
    node : Node
        Whose inputs.
    sources : mapping of str to str
        The node that each input topic comes from, by topic.
    timeout : float
        Wall time of silence [s].

    Attributes
    ----------
    sources : mapping of str to str
        As given.

    """

    def __init__(self, node: Node, sources: Mapping[str, str], timeout: float) -> None:
        self.sources = sources
        self._node, self._timeout = node, timeout
        self._heard = dict.fromkeys(sources, time.monotonic())
        self._missing: set[str] = set()
        self._known: set[str] = set()
        every(min(0.5, timeout), self._look, node)

    def heard(self, topic: str) -> None:
        """
        Note that an input has come.

        Parameters
        ----------
        topic : str
            One of the sources' keys.

        """
        self._heard[topic] = time.monotonic()
        self._known.add(topic)
        if topic in self._missing:
            self._missing.remove(topic)
            self._node.get_logger().info(f'{topic} is back')

    def age(self, topic: str) -> float:
        """
        Give how long ago an input came.

        Parameters
        ----------
        topic : str
            One of the sources' keys.

        Returns
        -------
        float
            [s]; infinite before the first.

        """
        return time.monotonic() - self._heard[topic] if topic in self._known else math.inf

    def missing(self) -> list[str]:
        """
        List the nodes whose messages are waited for.

        Returns
        -------
        list of str
            Sources of the inputs that never came, or not for the timeout.

        """
        return [source for topic, source in self.sources.items()
                if topic not in self._known or self._silent(topic)]

    def _silent(self, topic: str) -> bool:
        return time.monotonic() - self._heard[topic] > self._timeout

    def _look(self) -> None:
        for topic, source in self.sources.items():
            if topic not in self._missing and self._silent(topic):
                self._missing.add(topic)
                self._node.get_logger().warning(
                    f'no {topic} for {self._timeout} s: is {source} running, on the same clock as this node?'
                )


class Witness:
    """
    Finds out which node holds a lockstep run up.

    Listens to the answers that do not go to the plant, while a run stalls: every node that is there answers a
    repeated question, so the first link of the chain that stays silent is the one that is missing.

    Parameters
    ----------
    node : Node
        The plant's.
    timeout : float
        Wall time of silence after which the missing node is named [s].

    Attributes
    ----------
    named : list of str
        The nodes that have been named since the run last moved.

    """

    _CHAIN = (('reference', Odometry, 'reference_cart'), ('cmd_vel', TwistStamped, 'position_controller'))

    def __init__(self, node: Node, timeout: float) -> None:
        self._node, self._timeout = node, timeout
        self._newest: dict[str, int] = {}
        self._subscriptions: list[Subscription[Any]] = []
        self._suspect, self._suspected_at = '', 0.0
        self.named: list[str] = []

    def stalled(self, silence: float, stamp: int, tick: int) -> None:
        """
        Note that a question was not answered.

        Parameters
        ----------
        silence : float
            Wall time since it was asked [s].
        stamp, tick : int
            Of the present velocity and position tick [ns].

        """
        if silence < min(_STALL, self._timeout / 2):
            return
        if not self._subscriptions:
            self._subscriptions = [
                self._node.create_subscription(kind, topic, self._listener(topic), NEWEST, raw=True)
                for topic, kind, _ in self._CHAIN
            ]
        missing = self.missing(tick)
        if missing != self._suspect:
            self._suspect, self._suspected_at = missing, silence
        # a node that comes back is answered by the next one a moment later: that one is not missing
        if silence - self._suspected_at > self._timeout and missing not in self.named:
            self.named.append(missing)
            self._node.get_logger().warning(
                f'waiting for {missing} at t = {stamp / 1e9:g} s: no answer for {silence:.1f} s'
            )

    def missing(self, tick: int) -> str:
        """
        Name the node that a run waits for.

        Parameters
        ----------
        tick : int
            Stamp of the present position tick [ns].

        Returns
        -------
        str
            Node names, joined with ' and '.

        """
        absent = [source for topic, source in (*((topic, source) for topic, _, source in self._CHAIN),
                                               ('wheel_torques', 'velocity_controller'))
                  if self._node.count_publishers(topic) == 0]
        silent = next((source for topic, _, source in self._CHAIN if self._newest.get(topic) != tick),
                      'velocity_controller')
        return ' and '.join(absent or [silent])

    def progressed(self) -> None:
        """Note that the question was answered."""
        while self._subscriptions:
            self._node.destroy_subscription(self._subscriptions.pop())
        self._suspect = ''
        if self.named:
            self._node.get_logger().info(f'{" and ".join(self.named)} answered: the run goes on')
            self.named = []

    def _listener(self, topic: str) -> Callable[[bytes], None]:
        def listen(message: bytes) -> None:
            with suppress(Refused):
                self._newest[topic] = serialised_stamp(message)

        return listen
