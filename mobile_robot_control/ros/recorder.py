"""The recorder: hears every topic of its namespace as serialised messages."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import importlib
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.task import Future

from mobile_robot_control.readings import Refused, serialised_stamp
from mobile_robot_control.ros.diagnostics import LISTENERS
from mobile_robot_control.ros.qos import LOOP
from mobile_robot_control.ros.timers import every

LOOP_TOPICS = {
    'odom': 'nav_msgs/msg/Odometry',
    'joint_states': 'sensor_msgs/msg/JointState',
    'reference': 'nav_msgs/msg/Odometry',
    'cmd_vel': 'geometry_msgs/msg/TwistStamped',
    'tracking_error': 'geometry_msgs/msg/Vector3Stamped',
    'wheel_torques': 'sensor_msgs/msg/JointState',
}
_LISTENERS = {'odom': 3, 'joint_states': 2, 'reference': 2, 'cmd_vel': 2, 'tracking_error': 1, 'wheel_torques': 2}
"""How many listen to each when all are there: the nodes that need it, and the recorder."""
_DEPTH = 5000
_AHEAD = LOOP.depth // 4
"""Steps that a lockstep run may be ahead of what is recorded."""
Sink = Callable[[str, str, int, bytes, bool], None]


def _message_class(kind: str) -> Any:
    package, _, name = kind.split('/')
    return getattr(importlib.import_module(f'{package}.msg'), name)


class Recorder(Node):
    """
    Hands every message of its namespace, and of ROS's own topics, to a sink.

    Parameters
    ----------
    namespace : str
        What to record.
    sink : callable
        Takes topic, type, wall time of receipt [ns], CDR, and whether the topic is latched.
    knows : callable
        Says whether the sink takes a type.

    Attributes
    ----------
    newest : dict of str to int
        Stamp [ns] of the newest message on each loop topic, by its relative name.
    received : int
        Wall time [ns] at which the last message of a loop topic was taken in.

    """

    def __init__(self, namespace: str, sink: Sink, knows: Callable[[str], bool]) -> None:
        super().__init__('recorder', namespace=namespace, enable_rosout=False)
        self._sink, self._knows = sink, knows
        self._heard: dict[str, Any] = {}
        self._listeners: dict[str, int] = {}
        self.newest: dict[str, int] = {}
        self.received = 0
        self._ahead = self._allowed = 0
        self._plant: Any = self.create_client(SetParameters, 'plant/set_parameters')
        self._loop = {self.resolve_topic_name(topic): topic for topic in LOOP_TOPICS}
        for topic, name in self._loop.items():
            self._record(topic, LOOP_TOPICS[name], latched=False)
        self._record('/clock', 'rosgraph_msgs/msg/Clock', latched=False)
        every(0.25, self._discover, self)

    def rivals(self, ours: int = 0) -> list[str]:
        """
        List the loop topics that another robot publishes.

        Parameters
        ----------
        ours : int
            Publishers that each topic should have.

        Returns
        -------
        list of str
            Absolute names of those with more.

        """
        return [topic for topic in self._loop if self.count_publishers(topic) > ours]

    def all_hear_each_other(self) -> bool:
        """
        Say whether every node knows of this recorder and of those that it talks to, by what it says of itself.

        Returns
        -------
        bool
            True if so: on the wall clock, where a paused plant is not answered, nothing more will be missed.

        """
        return all(self._listeners.get(topic, 0) >= _LISTENERS[name] for topic, name in self._loop.items())

    def hears_everything(self) -> bool:
        """
        Say whether a message has come on every loop topic.

        Returns
        -------
        bool
            True if so: nothing more will be missed.

        """
        return set(self.newest) == set(LOOP_TOPICS)

    def let_run(self, period: int = 0) -> Future[Any]:
        """
        Tell a paused plant to go on; one that is not discovered yet does not hear it, so say it until it answers.

        Parameters
        ----------
        period : int
            Of the velocity grid [ns], in lockstep: from now on the plant holds where publishers could no longer keep
            for this recorder what it has not taken yet. 0 lets it go on whatever happens, as the wall clock does.

        Returns
        -------
        Future
            Done when the plant has said yes.

        """
        self._ahead = _AHEAD * period
        return self._allow(paused=False)

    def _allow(self, **values: float) -> Future[Any]:
        if self._ahead:
            self._allowed = self._recorded() + self._ahead
            values['hold_at'] = self._allowed / 1e9
        answer: Future[Any] = self._plant.call_async(SetParameters.Request(
            parameters=[Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        ))
        return answer

    def _recorded(self) -> int:
        """Stamp [ns] up to which every velocity tick is recorded, question and answer."""
        return min(self.newest.get(topic, 0) for topic in ('joint_states', 'wheel_torques'))

    def _discover(self) -> None:
        """Join every topic of the namespace, and those that ROS shares between namespaces."""
        prefix = self.get_namespace().rstrip('/') + '/'
        for topic, kinds in self.get_topic_names_and_types():
            shared = topic in ('/diagnostics', '/tf', '/tf_static', '/rosout', '/parameter_events')
            if topic in self._heard or not (topic.startswith(prefix) or shared):
                continue
            offers = self.get_publishers_info_by_topic(topic)
            if not offers:
                continue
            latched = all(offer.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in offers)
            reliable = all(offer.qos_profile.reliability == ReliabilityPolicy.RELIABLE for offer in offers)
            if self._knows(kinds[0]):
                self._record(topic, kinds[0], latched, reliable)
            else:
                self._heard[topic] = None
                self.get_logger().warning(f'{topic} is not recorded: its type {kinds[0]} is not a common one')

    def _note_listeners(self, diagnostics: DiagnosticArray) -> None:
        self._listeners.update(
            (entry.key.removeprefix(LISTENERS), int(entry.value))
            for status in diagnostics.status for entry in status.values
            if entry.key.startswith(LISTENERS) and entry.value.isdecimal()
        )

    def _record(self, topic: str, kind: str, latched: bool, reliable: bool = True) -> None:
        name = self._loop.get(topic)

        def hear(message: bytes) -> None:
            now = time.time_ns()
            if name is not None:
                self.received = now
                with suppress(Refused):
                    self.newest[name] = serialised_stamp(message)
                if self._ahead and self._recorded() > self._allowed - self._ahead // 2:
                    self._allow()
            elif topic == '/diagnostics':
                self._note_listeners(deserialize_message(message, DiagnosticArray))
            self._sink(topic, kind, now, message, latched)

        quality = QoSProfile(
            depth=_DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        self._heard[topic] = self.create_subscription(_message_class(kind), topic, hear, quality, raw=True)
