"""The node `reference_cart`: moves the virtual robot that the real one follows."""

import time
from functools import partial

from nav_msgs.msg import Path

from mobile_robot_control.messages import writing
from mobile_robot_control.messages.parsing import read_odometry
from mobile_robot_control.parameters.nodes import ReferenceCartParameters
from mobile_robot_control.quantities import Reference
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.ros.cart_wait import CartWait
from mobile_robot_control.ros.diagnostics import Condition
from mobile_robot_control.ros.input_validation import make_reader
from mobile_robot_control.ros.loop_node import LoopNode
from mobile_robot_control.ros.qos import LATCHED, flush
from mobile_robot_control.ros.stamp_policy import StampDecision, make_stamp_policy

_PATH_POINTS = 400


class ReferenceCart(LoopNode[ReferenceCartParameters]):
    """Answers each odometry with the cart's pose and velocity at that time."""

    def __init__(self) -> None:
        super().__init__('reference_cart', ReferenceCartParameters)
        shared, curve = self._shared, self._values.curve
        self._curve, self._placement = CURVES[curve.curve], curve.placement
        self._policy = make_stamp_policy(self.get_clock(), shared, shared.position_rate)
        self._read = make_reader(
            'odom', partial(read_odometry, frame=shared.odom_frame_id, child_frame=shared.base_frame_id))
        self._write = writing.odometry_writer(shared.odom_frame_id, shared.reference_frame_id)
        self._reference = self._publish_on('reference')
        self._path = self.create_publisher(Path, 'reference_path', LATCHED)
        self._path.publish(writing.path_message(shared.odom_frame_id, [
            self._reference_at(self._placement.period * n / _PATH_POINTS).pose
            for n in range(_PATH_POINTS + 1)
        ]))
        self._subscribe('odom', self._on_odom)
        self._began: float | None = None
        waiting = self._values.waiting
        self._wait = None if shared.lockstep or not waiting.wait else CartWait(
            self, self._monitor, waiting.wait_distance, 1.0 / shared.position_rate, self._reference_at)
        self._start(shared.position_rate, self._tick)

    def _on_odom(self, message: bytes) -> None:
        valid = self._validator.validate('odom', message, self._read, self._policy)
        if valid is None:
            return
        if valid.decision is StampDecision.HOLD:
            if self._began is None:
                self._began = time.monotonic()
                self._note_run(StampDecision.HOLD)
            if self._wait is not None:
                self._wait.note(valid.value[0])
            return
        if valid.decision in (StampDecision.START, StampDecision.JOIN):
            self._note_run(valid.decision, valid.stamp)
        self._policy.accept(valid.stamp)
        self._publish(valid.stamp, self._reference_at(valid.stamp / 1e9))
        if valid.decision is not StampDecision.AGAIN:
            self._diagnostics.note_step()

    def _reached(self) -> int | None:
        return self._policy.accepted

    def _tick(self) -> None:
        """On the wall clock, the curve's time starts at the first odometry, and stands while the cart waits."""
        if self._began is not None:
            self._publish(self._clock_stamp(), self._reference_at(time.monotonic() - self._began)
                          if self._wait is None else self._wait.reference())
            self._diagnostics.note_step()

    def _condition(self) -> Condition | None:
        return self._wait.condition() if self._wait is not None else None

    def _reference_at(self, time: float) -> Reference:
        """Return the reference at a time along the curve [s]."""
        return reference_at(self._curve, time, self._placement)

    def _publish(self, stamp: int, reference: Reference) -> None:
        self._reference.publish(self._write(stamp, reference.pose, reference.velocity))

    def close(self) -> None:
        """End when the last messages have arrived."""
        super().close()
        flush(self._reference)
