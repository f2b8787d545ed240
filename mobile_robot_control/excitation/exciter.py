"""The exciter: it drives a robot for a recording, within a box by its odometry."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from rclpy.node import Node

from mobile_robot_control.control.odometry_faults import Opposition
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.elementary import hypot
from mobile_robot_control.excitation.excitation import Agreement, Area, Excited, excite
from mobile_robot_control.experiment.stopping import is_at_rest
from mobile_robot_control.messages import writing
from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import RefusedMessageError, read_odometry, read_or_refuse, serialised_stamp
from mobile_robot_control.quantities import BodyVelocity, Pose
from mobile_robot_control.ros.shared.peers import publisher_names
from mobile_robot_control.ros.shared.qos import SENSORS, publish_on, subscribe_to
from mobile_robot_control.ros.shared.stamp_policy import StampDecision, WallClockStampPolicy
from mobile_robot_control.topics import GROUND_TRUTH, LOOP_TOPICS, PLAIN_TWIST, RUN_TOPICS

_ODOMETRY = LOOP_TOPICS['odom'].kind
_STAMPED = LOOP_TOPICS['cmd_vel'].kind
_SILENT = 0.5
"""[s] of wall time without odometry before the robot is stopped."""
_REST = 0.5
"""[s] of zero commands first: a recording that begins in motion is of no use until its model has settled."""


class Exciter(Node):
    """
    Commands a robot, and hands the messages to record to a sink.

    Parameters
    ----------
    namespace : str
        Of the robot.
    topics : mapping of str to str
        Other names of topics of the loop.
    area : Area
        Area and speed of the robot.
    stamped : bool
        Whether commands are stamped, if the robot takes both kinds.
    frame : str
        Of the commands.
    tolerance : float
        Largest difference between now and a stamp of odometry [s].
    sink : callable
        Takes topic, type, wall time of receipt [ns] and CDR.

    Attributes
    ----------
    fault : str
        Reason of an early stop, in words; '' before.
    publisher : Publisher
        Of the commands; None before the start.
    way, turn, farthest : float
        Distance [m] and turn [rad] so far, and the largest distance from the start in x or y [m].
    """

    def __init__(
        self, namespace: str, topics: Mapping[str, str], area: Area, stamped: bool, frame: str,
        tolerance: float, sink: Callable[[str, str, int, bytes], object],
    ) -> None:
        super().__init__('exciter', namespace=namespace, enable_rosout=False)
        self._area, self._stamped, self._frame, self._sink = area, stamped, frame, sink
        self._command = topics.get('cmd_vel', 'cmd_vel')
        self._odom = self.resolve_topic_name(topics.get('odom', 'odom'))
        self.publisher: Any = None
        self._kind = ''
        self._start: Pose | None = None
        self._pose, self._velocity, self._heard = Pose(0.0, 0.0, 0.0), BodyVelocity(0.0, 0.0), -math.inf
        self._state, self._agreement, self._began = Excited(), Agreement(), 0.0
        self._told, self._told_at, self._opposition = BodyVelocity(0.0, 0.0), 0.0, Opposition()
        self._policy = WallClockStampPolicy(self.get_clock(), tolerance)
        self._stamp, self._refusal = -1, ''
        self.fault = ''
        self.way = self.turn = self.farthest = 0.0
        self._read = (partial(deserialise, _ODOMETRY), read_odometry)
        for name in ('odom', GROUND_TRUTH, 'joint_states', 'wheel_torques'):
            kind, topic = RUN_TOPICS[name].kind, self.resolve_topic_name(topics.get(name, name))
            subscribe_to(self, topic, partial(self._take, topic, kind), SENSORS, kind)

    def missing(self) -> str:
        """Describe what is missing of a robot; '' if nothing is."""
        if self._start is None:
            return (f'odometry on {self._odom} is refused: {self._refusal}' if self._refusal else
                    f'no odometry comes on {self._odom}; name it with --topic odom:=/NAME')
        if self._sources():
            return self._sources()
        topic = self.resolve_topic_name(self._command)
        kinds = {info.topic_type for info in self.get_subscriptions_info_by_topic(topic)}
        taken = [kind for kind in (_STAMPED, PLAIN_TWIST) if kind in kinds]
        if not taken:
            return (f'no robot takes {topic} as TwistStamped or Twist; start its driver, or name the topic with '
                    '--topic cmd_vel:=/NAME')
        self._kind = taken[0] if len(taken) == 1 else _STAMPED if self._stamped else PLAIN_TWIST
        return ''

    def _sources(self) -> str:
        """Describe several publishers of odometry; '' for one."""
        if self.count_publishers(self._odom) < 2:
            return ''
        # the name of a node is discovered after its publishers, and the robot is not left driving until then
        names = ' and '.join('a node that has just started' if '_UNKNOWN_' in name else name
                             for name in publisher_names(self, self._odom).split(' and '))
        return (f'{self._odom} has several publishers: {names}; stop all but one, or name '
                'another topic with --topic odom:=/NAME')

    def others(self) -> str:
        """Return the names of other nodes that command the robot."""
        names = publisher_names(self, self.resolve_topic_name(self._command)).split(' and ')
        if self.publisher is not None:
            with suppress(ValueError):  # not discovered yet
                names.remove(f'{self.get_namespace().rstrip("/")}/{self.get_name()}')
        # the name of a node is discovered after its publishers
        return ' and '.join(name for name in names if '_UNKNOWN_' not in name)

    def begin(self) -> None:
        """Begin at the robot's present pose; its odometry must have arrived."""
        self.publisher = publish_on(self, self._command, self._kind)
        self._write = writing.twist_writer(self._frame, self._kind == _STAMPED)
        self._began = self._told_at = time.monotonic()
        self._start = self._pose

    def step(self) -> None:
        """Publish the next command; note a fault if the robot must stop."""
        assert self._start is not None  # noqa: S101 (for mypy: it has begun)
        now = time.monotonic()
        seen = Pose(*tracking_error(self._pose, self._start))
        self._agreement = self._agreement.commanded(self._told, self._velocity, now - self._told_at, self._area)
        others = self.others()
        if now - self._heard > _SILENT:
            self.fault = (f'{self._odom} has been silent for {now - self._heard:.1f} s'
                          + (f', since it is refused: {self._refusal}' if self._refusal else ''))
        elif self._sources():
            self.fault = self._sources()
        elif self._agreement.fault():
            self.fault = self._agreement.fault()
        elif self._opposition.fault():
            self.fault = f'{self._opposition.fault()}; see that it drives forwards and turns left as it is told'
        elif others:
            self.fault = f'others command the robot: {others}; stop them'
        elif not self._area.holds(seen.x, seen.y):
            self.fault = (f'the robot has left the box: x {seen.x:.2f} m, y {seen.y:.2f} m from its start; take a '
                          'larger box, or a smaller --max-velocity')
        else:
            command, since = BodyVelocity(0.0, 0.0), now - self._began - _REST
            if since > 0.0:
                self._state, command = excite(self._state, since, seen, self._velocity, self._area)
            self._publish(command)
            self._told, self._told_at = command, now

    def stop(self) -> None:
        """Publish a zero command."""
        self._publish(BodyVelocity(0.0, 0.0))

    def stands(self) -> bool:
        """Return whether the robot stands, by recent odometry."""
        return time.monotonic() - self._heard < _SILENT and is_at_rest(self._velocity)

    def _publish(self, command: BodyVelocity) -> None:
        message = self._write(self.get_clock().now().nanoseconds, command)
        self.publisher.publish(message)
        self._sink(self.resolve_topic_name(self._command), self._kind, time.time_ns(), message)

    def _take(self, topic: str, kind: str, message: bytes) -> None:
        if self.publisher is not None:
            self._sink(topic, kind, time.time_ns(), message)
        if topic != self._odom:
            return
        try:
            stamp = serialised_stamp(message)
            if stamp == self._stamp:
                raise RefusedMessageError('stamp does not advance', f'{stamp / 1e9} s again: does its driver hang?')
            if self._policy.decide(stamp) is StampDecision.REFUSED:
                raise self._policy.refusal(stamp)
            if stamp < self._stamp:
                raise RefusedMessageError('stamp goes back', f'{stamp / 1e9} s after {self._stamp / 1e9} s')
            pose, velocity = read_or_refuse(_ODOMETRY, self._read, message)
        except RefusedMessageError as error:
            self._refusal = str(error)
            self.get_logger().warning(f'odometry is not used: {error}', throttle_duration_sec=5.0)
            return
        if self.publisher is not None and self._start is not None and (pose, velocity) != (self._pose, self._velocity):
            way = hypot(pose.x - self._pose.x, pose.y - self._pose.y)
            turn = abs(math.remainder(pose.heading - self._pose.heading, 2.0 * math.pi))
            seen = tracking_error(pose, self._start)
            self.way, self.turn = self.way + way, self.turn + turn
            self.farthest = max(self.farthest, abs(seen.longitudinal), abs(seen.lateral))
            self._agreement = self._agreement.moved(way, turn, (stamp - self._stamp) / 1e9, self._area)
            self._opposition = self._opposition.after(
                self._told, self._pose, pose, velocity, (stamp - self._stamp) / 1e9)
        self._pose, self._velocity, self._heard = pose, velocity, time.monotonic()
        self._stamp, self._refusal = stamp, ''
        self._start = self._start or pose
