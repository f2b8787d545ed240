"""The plant's input `disturbance`: pushes on the robot, each held over one velocity step."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import math
from functools import partial
from typing import Any

from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node

from mobile_robot_control.messages.parsing import RefusedMessageError, read_wrench
from mobile_robot_control.quantities import Push
from mobile_robot_control.ros.shared.conversions import bytes_reader
from mobile_robot_control.ros.shared.inputs import InputValidator
from mobile_robot_control.ros.shared.qos import SUBSCRIBED
from mobile_robot_control.ros.shared.run_events import RunEvents
from mobile_robot_control.ros.shared.stamp_policy import StampDecision, StampPolicy, WallClockStampPolicy
from mobile_robot_control.topics import DISTURBANCE

_MOST = 1000
"""Most pushes that wait for their steps."""


class GridStamps(StampPolicy):
    """Accepts every stamp of the velocity grid, in lockstep, and stamp 0, which stands for the next step."""

    def __init__(self, period: int) -> None:
        self._period = period

    def decide(self, stamp: int) -> StampDecision:
        """Return HOLD or REFUSED for a stamp [ns]."""
        return StampDecision.REFUSED if stamp < 0 or stamp % self._period else StampDecision.HOLD

    def refusal(self, stamp: int) -> RefusedMessageError:
        """Return the reason to refuse a stamp [ns]."""
        return RefusedMessageError('stamp not on the grid', f'{stamp / 1e9} s; the period is {self._period / 1e9} s, '
                                   'and stamp 0 means the next step')

    def leave_run(self) -> bool:
        """Do nothing: there is no run to leave."""
        return False

    def step(self, stamp: int) -> int:
        """Return the step of a stamp [ns]."""
        return stamp // self._period


class Now(WallClockStampPolicy):
    """Accepts stamps of the wall clock, which, like stamp 0, stand for the next step."""

    def decide(self, stamp: int) -> StampDecision:
        """Return HOLD or REFUSED for a stamp [ns]."""
        return super().decide(stamp) if stamp else StampDecision.HOLD

    def age(self, stamp: int) -> float:
        """Return the age of a stamp [s]; 0 for a stamp of no clock."""
        return super().age(stamp) if stamp else 0.0

    def step(self, _stamp: int) -> int:
        """Return the step of a stamp [ns] of another clock."""
        return 0


class DisturbanceInput:
    """
    Stores the pushes to come.

    Parameters
    ----------
    node : Node
        The plant.
    policy : GridStamps or Now
        For stamps.
    frame : str
        Of pushes.
    validator : InputValidator
        Of the plant.
    events : RunEvents
        Receives each push that acts.
    takes_velocity : bool
        Whether the plant is a base, which has no forces and accepts no pushes.

    Attributes
    ----------
    waiting : dict of int to Push
        Pushes by step of the velocity grid.

    """

    def __init__(
        self, node: Node, policy: GridStamps | Now, frame: str, validator: InputValidator, events: RunEvents,
        takes_velocity: bool,
    ) -> None:
        self._node, self._validator, self._events, self._takes_velocity = node, validator, events, takes_velocity
        self._policy = policy
        self._topic = node.resolve_topic_name(DISTURBANCE)
        self._read_push = bytes_reader(
            'geometry_msgs/msg/WrenchStamped', partial(read_wrench, frame=frame))
        self.waiting: dict[int, Push] = {}
        node.create_subscription(WrenchStamped, DISTURBANCE, self._on_disturbance, SUBSCRIBED, raw=True)

    def take_push(self, k: int, stamp: int) -> Push | None:
        """Return the push of the k-th step, including late ones, at a stamp [ns]; None if there is none."""
        pushes = [self.waiting.pop(step) for step in sorted(self.waiting) if step <= k]
        if not pushes:
            return None
        push = Push(math.fsum(one.force for one in pushes), math.fsum(one.torque for one in pushes))
        self._events.publish(stamp, {DISTURBANCE: push})
        return push

    def _on_disturbance(self, message: bytes) -> None:
        valid = self._validator.validate(DISTURBANCE, message, self._read, self._policy)
        if valid is not None:
            step = self._policy.step(valid.stamp)
            before = self.waiting.get(step, Push(0.0, 0.0))
            self.waiting[step] = Push(before.force + valid.value.force, before.torque + valid.value.torque)

    def _read(self, message: bytes) -> Any:
        """Return the push of a message; raise RefusedMessageError if none can act."""
        if self._takes_velocity:
            raise RefusedMessageError('a base has no forces', "drive is 'velocity'; push a plant that takes torques")
        publishers = self._node.count_publishers(self._topic)
        if publishers > 1:
            raise RefusedMessageError('several publishers', f'{publishers} of them, whose pushes come in no certain '
                                      'order; stop all but one')
        if len(self.waiting) >= _MOST:
            raise RefusedMessageError('too many wait', f'{_MOST} pushes wait for their steps; publish fewer ahead')
        return self._read_push(message)
