"""The guard between law and robot: none in lockstep; on the wall clock stops, the approach, faulty odometry."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

import math
from collections.abc import Callable, Mapping
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from mobile_robot_control.control.approach import stands_still
from mobile_robot_control.control.limits import TrackingLimit
from mobile_robot_control.control.odometry_faults import CONTRARY, SILENCE, Opposition
from mobile_robot_control.control.tracking_error import distance
from mobile_robot_control.elementary import hypot
from mobile_robot_control.quantities import (
    NANOSECONDS,
    BodyAcceleration,
    BodyVelocity,
    Observation,
    Pose,
    Reference,
)
from mobile_robot_control.reference.localisation import apart, composed
from mobile_robot_control.ros.position.law_runner import LawRunner
from mobile_robot_control.ros.position.namesakes import Namesakes
from mobile_robot_control.ros.position.odometry import CONFLICT, OdomConflict, OdomTwist
from mobile_robot_control.ros.position.safety_stop import SafetyStop, refuse_to_stop
from mobile_robot_control.ros.shared.diagnostics import Condition
from mobile_robot_control.settings.nodes import PositionControllerParameters

_ZERO = BodyVelocity(0.0, 0.0)
_FAR = 0.5
"""[m] from the cart: a start at a larger distance is logged."""
_BESIDE = 0.1
"""[m] from a cart that stands: the robot has nothing to drive."""


def tell_far_start(node: Node, pose: Pose, cart: Pose, speed: float = 0.0) -> None:
    """Log a start far from the cart, which the robot approaches at a speed [m/s], or does not."""
    apart = hypot(cart.x - pose.x, cart.y - pose.y)
    if apart <= _FAR:
        return
    where = (f'the run starts {apart:.2f} m from the cart: the robot is at ({pose.x:.2f}, {pose.y:.2f}) m, the cart at '
             f'({cart.x:.2f}, {cart.y:.2f}) m')
    if speed > 0.0:
        node.get_logger().info(f'{where}, and waits; the robot drives there at {speed:g} m/s at most')
    else:
        node.get_logger().warning(f'{where}; set plant.initial_pose, or place the curve elsewhere')


class LockstepGuard:
    """
    Passes the law's command on: in lockstep there is no robot to stop.

    Parameters
    ----------
    node : Node
        The position controller.
    law : LawRunner
        Of the node.

    """

    stands = is_aside = False

    def note_sent(self, message: bytes) -> None:
        """Keep nothing: in lockstep a second controller is counted by its stamps."""

    def __init__(self, node: Node, law: LawRunner) -> None:
        self._node, self._law = node, law
        refuse_to_stop(node)

    def note_odometry(
        self, _stamp: int, _pose: Pose, velocity: BodyVelocity, _values: PositionControllerParameters, _drives: bool
    ) -> BodyVelocity:
        """Receive odometry; return the velocity of the robot."""
        return velocity

    def is_held(self, _values: PositionControllerParameters) -> bool:
        """Return whether the robot must stand."""
        return False

    def command(
        self, observation: Observation, stamp: int, _values: PositionControllerParameters,
        acceleration: BodyAcceleration | None = None,
    ) -> BodyVelocity:
        """Return the command of a step at a stamp [ns]."""
        return self._law.command(observation, stamp, math.inf, acceleration)

    def check_start(self, _values: PositionControllerParameters, pose: Pose, reference: Reference) -> None:
        """Log a start far from the cart."""
        tell_far_start(self._node, pose, reference.pose)

    def rest(self) -> None:
        """Keep nothing: no robot was stopped."""

    def condition(self, _values: PositionControllerParameters, _problems: list[str], _drives: bool) -> None:
        """Return None: no robot stands."""

    def forget_run(self) -> None:
        """Keep what there is: simulated time never jumps."""


class RobotGuard:
    """
    Chooses the command of each tick on the wall clock: a stop, the approach to a waiting cart, or the law's.

    Parameters
    ----------
    node : Node
        The position controller.
    law : LawRunner
        Of the node.
    conflict : callable
        Makes the OdomConflict of a run.
    act : callable
        As in SafetyStop.
    publish : callable
        Publishes events.
    kind : str
        Type of the command.

    """

    def __init__(
        self, node: Node, law: LawRunner, conflict: Callable[[], OdomConflict], act: Callable[[], str],
        publish: Callable[[Mapping[str, Any]], None], kind: str,
    ) -> None:
        self._node, self._law, self._publish = node, law, publish
        self._others = Namesakes(node, kind, self._stop_along)
        self.note_sent = self._others.note_sent
        self._stop = SafetyStop(
            node, act, lambda why: publish({'stop': why} if why else {'release': True}), self._others)
        self._twist, self._make_conflict, self._conflict = OdomTwist(node), conflict, conflict()
        self._pose = Pose(0.0, 0.0, 0.0)
        self._stamp, self._unheard, self._command, self._opposition = 0, 0, _ZERO, Opposition()
        self._correction: Pose | None = None
        self._has_driven = self._is_beside = self._was_beside = False
        self._far = ''

    def _stop_along(self, reason: str) -> None:
        """Stop the robot that another node of this name has stopped."""
        if not self._stop.reason:
            self._stop.stop(reason)

    @property
    def stands(self) -> bool:
        """Whether the robot is stopped, or too far from the cart to set out."""
        return bool(self._stop.reason or self._others.reason or self._far)

    @property
    def is_aside(self) -> bool:
        """Whether another node of this name drives the robot, whose commands zeros would halve."""
        return bool(self._others.reason and not self._stop.reason)

    def note_odometry(
        self, stamp: int, pose: Pose, velocity: BodyVelocity, values: PositionControllerParameters, drives: bool
    ) -> BodyVelocity:
        """Receive odometry; return the velocity of the robot, from its poses if they contradict the twist."""
        before, last, self._pose, self._stamp, self._unheard = self._pose, self._stamp, pose, stamp, 0
        used = self._twist.note_odometry(stamp, pose, velocity, self._command, values.input_timeout)
        silence = (stamp - last) / NANOSECONDS
        if self._twist.jump and silence > SILENCE:
            # a base that was killed is a second publisher until DDS misses it
            self._conflict.begin_after_silence(stamp, pose, velocity)
        else:
            self._conflict.note_odometry(stamp, pose, velocity)
            if self._conflict.present:
                self._twist.forget_odometry()  # the poses of several publishers are no jumps of one
                return velocity
        self._opposition = self._opposition.after(
            self._command if drives else _ZERO, before, pose, velocity, silence,
            values.odom_latency + max(values.control.feedforward.dead_time))
        if self._twist.jump:
            self._note_jump(*self._twist.jump, values.limits, (
                f'across a silence of {silence:.1f} s' if silence > SILENCE else 'against its twist'))
        if drives and self._opposition.fault() and not self._stop.reason:
            self._opposition = Opposition()
            self._stop.stop(f'{CONTRARY}; see that it drives forwards and turns left as it is told, then call release')
        return used

    def _note_jump(self, moved: float, turned: float, limits: TrackingLimit, against: str) -> None:
        """Report a jump of odometry [m], [rad]; stop a robot beyond the limits that may set out by itself."""
        self._opposition = Opposition()
        words = f'the pose of odom has jumped by {moved:.2f} m and {turned:.2f} rad {against}'
        self._node.get_logger().warning(f'{words}: it was corrected or reset')
        self._publish({'odom_jump': [moved, turned]})
        is_far = 0.0 < limits.odom_jump < moved or 0.0 < limits.odom_turn < turned
        if is_far and self._has_driven and not self._is_beside:
            self._stop.stop(f'{words}, and limits.odom_jump is {limits.odom_jump:g} m, limits.odom_turn '
                            f'{limits.odom_turn:g} rad; see whether it knows where it is, then call release')

    def note_correction(self, correction: Pose, limits: TrackingLimit) -> None:
        """Receive a correction of odometry; stop a robot that has driven, if it jumps beyond the limits."""
        # the cart also stands while a localisation is silent
        was_beside, self._was_beside = self._was_beside, self._is_beside
        before, self._correction = self._correction or correction, correction
        moved, turned = apart(composed(correction, self._pose), composed(before, self._pose))
        if not (0.0 < limits.localisation_jump < moved or 0.0 < limits.localisation_turn < turned):
            return
        words = f'the localisation has moved the robot by {moved:.2f} m and {turned:.2f} rad at once'
        self._node.get_logger().warning(words)
        self._publish({'localisation_jump': [moved, turned]})
        if self._has_driven and not (was_beside and self._is_beside):
            self._stop.stop(f'{words}, and limits.localisation_jump is {limits.localisation_jump:g} m, '
                            f'limits.localisation_turn {limits.localisation_turn:g} rad; see whether it knows where '
                            'it is, then call release')

    def is_held(self, values: PositionControllerParameters) -> bool:
        """Return whether the robot must stand."""
        return bool(self._stop.reason or self._others.reason) or self._in_conflict(values)

    def _in_conflict(self, values: PositionControllerParameters) -> bool:
        return values.stop_on_odom_conflict and self._conflict.present

    def _stands_far(self, observation: Observation, values: PositionControllerParameters) -> bool:
        """Return whether the robot stands because the reference is beyond `approach.distance`; log it once."""
        before, apart = self._far, distance(observation.error)
        self._far = self._where(observation.reference.pose, apart, values) if _is_far(apart, values) else ''
        if self._far and not before:
            self._node.get_logger().error(f'the robot stands: {self._far}')
        elif before and not self._far:
            self._node.get_logger().info('the reference is near: the robot drives')
            self._law.begin_law(values.control, under_way=True)
        return bool(self._far)

    def _where(self, cart: Pose, apart: float, values: PositionControllerParameters) -> str:
        """Say where robot and cart are, at a distance [m] that is too large."""
        robot = self._pose
        return (f'{apart:.2f} m lie between the robot at ({robot.x:.2f}, {robot.y:.2f}) m and the cart at '
                f'({cart.x:.2f}, {cart.y:.2f}) m, and approach.distance is {values.approach.distance:g} m; '
                'place the curve near the robot, bring it there, or raise the limit')

    def check_start(self, values: PositionControllerParameters, pose: Pose, reference: Reference) -> None:
        """Begin a run; log a start far from the cart, to which the robot sets out."""
        self._has_driven, self._opposition = False, Opposition()
        if not _is_far(hypot(reference.pose.x - pose.x, reference.pose.y - pose.y), values):
            tell_far_start(self._node, pose, reference.pose, self.approach_speed(values, reference))

    def rest(self) -> None:
        """Keep a stop for a node that is started again."""
        self._stop.remember()

    def approach_speed(self, values: PositionControllerParameters, reference: Reference) -> float:
        """Return the robot's speed of approach to a waiting cart [m/s]; 0 if the law tracks it."""
        return values.approach.speed if stands_still(reference) else 0.0

    def command(
        self, observation: Observation, _stamp: int, values: PositionControllerParameters,
        acceleration: BodyAcceleration | None = None,
    ) -> BodyVelocity:
        """Return the command; zero if the robot is too far from the reference, or has just been stopped for that."""
        self._unheard += 1
        if self._unheard <= SILENCE * values.shared.position_rate:
            # a cart also stands once odometry is silent
            self._is_beside = stands_still(observation.reference) and distance(observation.error) <= _BESIDE
        self._command = self._chosen(observation, values, acceleration)
        self._has_driven = self._has_driven or any(self._command)
        return self._command

    def _chosen(
        self, observation: Observation, values: PositionControllerParameters, acceleration: BodyAcceleration | None
    ) -> BodyVelocity:
        if self._stands_far(observation, values):
            return _ZERO
        speed = self.approach_speed(values, observation.reference)
        if not self._stop.allows(distance(observation.error), values.limits.tracking_error, speed > 0.0):
            return _ZERO
        if speed > 0.0:
            return self._law.approach(observation.error, observation.reference, speed, values.control)
        return self._law.command(observation, None, values.input_timeout, acceleration)

    def condition(self, values: PositionControllerParameters, problems: list[str], drives: bool) -> Condition | None:
        """Return the condition of a node with a standing robot or faulty odometry."""
        if self._stop.reason:
            return Condition(DiagnosticStatus.ERROR, 'stopped', detail=self._stop.reason)
        if self._others.reason:
            return Condition(DiagnosticStatus.ERROR, 'stopped', detail=self._others.reason)
        if self._in_conflict(values):
            return Condition(DiagnosticStatus.ERROR, 'stopped', detail='; '.join([CONFLICT, *problems]))
        if self._far and drives:
            return Condition(DiagnosticStatus.ERROR, 'stopped', detail='; '.join([self._far, *problems]))
        if self._twist.problem and drives:
            return Condition(DiagnosticStatus.WARN, 'running', detail='; '.join([self._twist.problem, *problems]))
        return None

    def forget_run(self) -> None:
        """Forget a run after a jump back of simulated time; a stop stays."""
        self._conflict = self._make_conflict()
        self._twist.forget_odometry()


def _is_far(apart: float, values: PositionControllerParameters) -> bool:
    """Return whether a distance from the cart [m] is too large to set out."""
    return 0.0 < values.approach.distance < apart
