"""The stall detector: it names the node that blocks a lockstep run."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from rclpy.node import Node
from rclpy.subscription import Subscription

from mobile_robot_control.messages.parsing import RefusedMessageError, serialised_stamp
from mobile_robot_control.ros.services.qos import subscribe_to
from mobile_robot_control.topics import LoopGraph, first_silent

_STALL = 0.5
"""[s]: a shorter silence may come from a busy machine."""


class StallDetector:
    """
    Finds the node that blocks a lockstep run.

    From the first stall on it subscribes to the answers that do not go to the plant. Every running node answers a
    repeated question, so the first silent link of the chain is the missing node. The subscriptions stay: if one is
    destroyed just before the plant is suspended for longer than the timeout of DDS, other nodes may not discover the
    plant again (https://github.com/eProsima/Fast-DDS/issues/457).

    Parameters
    ----------
    node : Node
        The plant's.
    timeout : float
        Wall time of silence after which the missing node is named [s].
    loop : LoopGraph
        The plant's loop.

    Attributes
    ----------
    named : list of str
        The nodes named since the run last moved.

    """

    def __init__(self, node: Node, timeout: float, loop: LoopGraph) -> None:
        self._node, self._timeout, self._loop = node, timeout, loop
        # the answers in their order; the last one goes to the plant
        self._chain = tuple(loop.topics[answer] for _, answer in loop.answers)
        self._newest: dict[str, int] = {}
        self._subscriptions: list[Subscription[Any]] = []
        self._suspect, self._suspected_at = '', 0.0
        self.named: list[str] = []

    def note_silence(self, silence: float, stamp: int, tick: int) -> None:
        """
        Note an unanswered question.

        Parameters
        ----------
        silence : float
            Wall time since the question [s].
        stamp, tick : int
            Of the present velocity and position tick [ns].

        """
        if silence < min(_STALL, self._timeout / 2):
            return
        if not self._subscriptions:
            self._subscriptions = [subscribe_to(self._node, topic.name, self._listener(topic.name))
                                   for topic in self._chain[:-1]]
        missing = self.missing(tick)
        if missing != self._suspect:
            self._suspect, self._suspected_at = missing, silence
        # the answer to a node that has just come back follows a moment later: the next node is not missing
        if silence - self._suspected_at > self._timeout and missing not in self.named:
            self.named.append(missing)
            self._node.get_logger().warning(
                f'waiting for {missing} at t = {stamp / 1e9:g} s: no answer for {silence:.1f} s'
            )

    def missing(self, tick: int) -> str:
        """Name the nodes, joined with ' and ', that block a run at a position tick [ns]."""
        absent = [topic.publisher for topic in self._chain if self._node.count_publishers(topic.name) == 0]
        # the plant has no answer to the present question, so one node always counts as silent
        return ' and '.join(absent) or str(first_silent(self._newest, tick, tick, self._loop))

    def note_progress(self) -> None:
        """Note an answer to the question."""
        self._suspect = ''
        if self.named:
            self._node.get_logger().info(f'{" and ".join(self.named)} answered: the run goes on')
            self.named = []

    def _listener(self, topic: str) -> Callable[[bytes], None]:
        """Make a callback that stores the newest stamp of a topic."""

        def listen(message: bytes) -> None:
            with suppress(RefusedMessageError):
                self._newest[topic] = serialised_stamp(message)

        return listen
