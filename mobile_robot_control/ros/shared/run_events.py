"""Changes of a run, published on `events` with the first stamp that they affect."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Mapping
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from mobile_robot_control.quantities import NANOSECONDS
from mobile_robot_control.ros.shared.qos import flush
from mobile_robot_control.settings.nodes import PACE
from mobile_robot_control.system.texts import shortened
from mobile_robot_control.topics import EVENTS, MOST_EVENTS, RUN_KEY

KEPT = QoSProfile(
    depth=MOST_EVENTS, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Of `events`: they also hold for later subscribers."""


class RunEvents:
    """
    Publishes each change when the first stamp that it affects is certain.

    Parameters
    ----------
    node : Node
        Node that applies the changes.

    Attributes
    ----------
    run : int
        Runs that the node has begun after its first one.
    pending : list of dict
        Changes that act from the next step on, those of one call together.
    at_start : dict of str to object
        Changes that act from the next run on, together.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, EVENTS, KEPT)
        self._published = False
        self.run = 0
        self.pending: list[Mapping[str, Any]] = []
        self.at_start: dict[str, Any] = {}

    def note_changes(self, changes: Mapping[str, object], at_start: bool = False) -> None:
        """Note parameters set in one call, by name, except those that change no number."""
        kept = {name: value for name, value in changes.items() if name not in PACE}
        if at_start:
            self.at_start |= kept
        elif kept:
            self.pending.append(kept)
            # changes that wait for the next run take their newest values
            self.at_start |= {name: value for name, value in kept.items() if name in self.at_start}

    def begin_run(self, anew: bool, with_changes: bool = True) -> None:
        """Note that a run begins, another one or the first, and whether with the changes that wait for one."""
        self.run += anew
        if with_changes and self.at_start:
            self.pending.append(self.at_start)
            self.at_start = {}

    def publish_pending(self, stamp: int) -> None:
        """Publish the changes that act from a stamp [ns] on."""
        pending, self.pending = self.pending, []
        for changes in pending:
            self.publish(stamp, changes)

    def publish(self, stamp: int, changes: Mapping[str, Any]) -> None:
        """Publish changes that act together from a stamp [ns] on, one status each."""
        self._published = True
        name = self._node.get_fully_qualified_name().lstrip('/')
        array = DiagnosticArray(status=[DiagnosticStatus(
            name=name, hardware_id=name.rpartition('/')[0], message=shortened(f'{key} = {value}'),
            values=[KeyValue(key=key, value=value), KeyValue(key=RUN_KEY, value=str(self.run))],
        ) for key, value in ((key, _text(value)) for key, value in changes.items())])
        array.header.stamp = Time(sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS)
        self._publisher.publish(array)

    def flush(self) -> None:
        """Wait briefly until all messages have reached every subscriber."""
        if self._published:
            flush(self._publisher)


def _text(value: Any) -> str:
    """Return a value as JSON, numbers to the last bit."""
    import json  # noqa: PLC0415 (a node starts sooner without)

    return json.dumps(value if isinstance(value, str | bool | int | float) else [*value])
