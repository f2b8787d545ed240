"""The correction of odometry by a localisation, from /tf and /tf_static or the topic `correction`."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import Link, RefusedMessageError, read_or_refuse, read_transforms
from mobile_robot_control.messages.writing import message_class
from mobile_robot_control.quantities import NANOSECONDS, Pose
from mobile_robot_control.reference.localisation import Swings
from mobile_robot_control.ros.shared.inputs import InputValidator
from mobile_robot_control.ros.shared.qos import SUBSCRIBED
from mobile_robot_control.settings.frames import Frames
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.topics import CORRECTION

_TF = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
_STATIC = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_TF_KIND, _KIND = 'tf2_msgs/msg/TFMessage', 'geometry_msgs/msg/TransformStamped'
_NO_TYPE = ('the Python module tf2_msgs is missing, and /tf is not read: install it (apt install '
            f'ros-$ROS_DISTRO-tf2-msgs), or publish the correction on {CORRECTION}')
_AHEAD = 10.0
"""[s] ahead of the node's clock: a transform with a later stamp would keep all others out."""
_LARGEST = 1 << 18
"""[bytes] of a message of transforms: a larger one would hold up the step."""


class LocalisationInput:
    """
    Subscribes a node to corrections.

    Parameters
    ----------
    node : Node
        Of the loop.
    shared : Shared
        With the frames.
    validator : InputValidator
        Counts refused messages.
    take : callable
        Called with the stamp [ns] and the value of each correction.

    Attributes
    ----------
    heard : float
        Steady time of the last one [s]; -inf before the first.

    """

    def __init__(
        self, node: Node, shared: Shared, validator: InputValidator, take: Callable[[int, Pose], None]
    ) -> None:
        self._shared, self._validator, self._take = shared, validator, take
        self._clock, self._now, self._swings = node.get_clock(), 0, Swings()
        self.heard = float('-inf')
        self.problem = ''
        self._frames = Frames(shared.path_frame_id, shared.odom_frame_id)
        node.create_subscription(message_class(_KIND), CORRECTION, partial(self._receive, CORRECTION), SUBSCRIBED,
                                 raw=True)
        try:
            kind = message_class(_TF_KIND)
        except ModuleNotFoundError:
            self.problem = _NO_TYPE
            node.get_logger().warning(_NO_TYPE)
            return
        for topic, quality in (('/tf', _TF), ('/tf_static', _STATIC)):
            node.create_subscription(kind, topic, partial(self._receive, topic), quality, raw=True)

    def forget_transforms(self) -> None:
        """Forget all moving transforms, whose stamps begin again."""
        self._frames.forget_transforms()
        self._tell()

    def _tell(self) -> None:
        correction = self._frames.correction()
        if correction is not None:
            self.heard = time.monotonic()
            if self._swings.note_correction(correction[1]):
                self._validator.note_refusal('/tf', RefusedMessageError(
                    'two corrections in turn', f'{self._shared.path_frame_id} -> {self._shared.odom_frame_id} jumps to '
                    'and fro between two values: do two nodes publish it? End one of them'))
            self._take(*correction)

    def _receive(self, topic: str, message: bytes) -> None:
        kind = _KIND if topic == CORRECTION else _TF_KIND
        try:
            if len(message) > _LARGEST:
                raise RefusedMessageError('too large', f'{len(message)} bytes of transforms, and {_LARGEST} are the '
                                          'most; publish fewer in one message')
            links = read_or_refuse(kind, (partial(deserialise, kind), _listed, read_transforms), message)
            if not self._shared.lockstep:
                links = self._timely(topic, links)
            if self._frames.take_transforms(links, topic == '/tf_static'):
                self._tell()
        except RefusedMessageError as refusal:
            self._validator.note_refusal(topic, refusal)

    def _timely(self, topic: str, links: list[Link]) -> list[Link]:
        """Return the transforms that are not far ahead of the node's clock; forget all after a jump back of that."""
        before, self._now = self._now, self._clock.now().nanoseconds
        if self._now < before:
            self._frames.forget_transforms()
        if topic == '/tf_static' or self._now == 0:  # no message on /clock yet
            return links
        latest = self._now + round(_AHEAD * NANOSECONDS)
        for link in links:
            if link.stamp > latest:
                ahead = (link.stamp - self._now) / NANOSECONDS
                self._validator.note_refusal(topic, RefusedMessageError(
                    'stamp far ahead', f'{link.parent} -> {link.child} is {ahead:.1f} s ahead of the clock of this '
                    f'node, and {_AHEAD:g} s are the most; do both use the same clock?'))
        return [link for link in links if link.stamp <= latest]

    def missing_correction(self, timeout: float) -> str:
        """Return why there is no present correction, in words; '' if there is one."""
        if self.heard == float('-inf'):
            return '; '.join(filter(None, [self._frames.missing_transform(), self.problem]))
        age = time.monotonic() - self.heard
        return '' if age <= timeout else (
            f'the correction from {self._shared.path_frame_id} to {self._shared.odom_frame_id} is {age:.1f} s old, and '
            f'localisation.timeout is {timeout:g} s')


def _listed(message: object) -> list[Any]:
    return message if isinstance(message, list) else [message]
