"""The node `reference_cart`: moves the virtual robot that the real one follows."""

from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any

from nav_msgs.msg import Path

from mobile_robot_control.configuration.nodes import ReferenceCartParameters
from mobile_robot_control.messages import writing
from mobile_robot_control.messages.parsing import read_odometry
from mobile_robot_control.quantities import Reference
from mobile_robot_control.ros.cart_course import PERIOD, CartCourse
from mobile_robot_control.ros.cart_wait import CartWait
from mobile_robot_control.ros.diagnostics import Condition
from mobile_robot_control.ros.input_validation import make_reader
from mobile_robot_control.ros.loop_node import LoopNode
from mobile_robot_control.ros.qos import LATCHED, flush
from mobile_robot_control.ros.stamp_policy import StampDecision, make_stamp_policy
from mobile_robot_control.ros.stop_memory import remember_stops
from mobile_robot_control.stamps import period_nanoseconds

_JUMP = ('the cart would jump: on the wall clock its curve can change where wait is true, so that it waits at the new '
         'start; or start the node again')


class ReferenceCart(LoopNode[ReferenceCartParameters]):
    """Answers each odometry with the cart's pose and velocity at that time."""

    def __init__(self) -> None:
        super().__init__('reference_cart', ReferenceCartParameters)
        shared = self._shared
        period, horizon = period_nanoseconds(shared.position_rate), shared.reference_horizon
        self._course = CartCourse(self._values.curve, horizon, period)
        self._policy = make_stamp_policy(self.get_clock(), shared, shared.position_rate)
        self._read = make_reader(
            'odom', partial(read_odometry, frame=shared.odom_frame_id, child_frame=shared.base_frame_id))
        self._write = writing.odometry_writer(shared.odom_frame_id, shared.reference_frame_id)
        if not shared.lockstep:
            # before `reference` is published: a position controller that finds `reference` has found this one, too
            remember_stops(self, self._validator)
        self._horizon = self._publish_on('reference_horizon') if horizon else None
        if horizon:
            self._write_horizon = writing.horizon_writer(
                shared.odom_frame_id, shared.reference_frame_id, horizon, period)
        self._reference = self._publish_on('reference')
        self._path = self.create_publisher(Path, 'reference_path', LATCHED)
        self._publish_path()
        self._answer: tuple[Reference, ...] | None = None
        self._subscribe('odom', self._on_odom)
        self._began: float | None = None
        waiting = self._values.waiting
        self._wait = None if shared.lockstep or not waiting.wait else CartWait(
            self, self._robot_clock, self._monitor, waiting.wait_distance, 1.0 / shared.position_rate,
            self._course.reference, horizon)
        self._start(shared.position_rate, self._tick)

    def _forget(self) -> None:
        self._began = self._answer = None
        self._course.begin(self._values.curve)
        if self._wait is not None:
            self._wait.begin_anew()

    def _publish_path(self) -> None:
        self._path.publish(writing.path_message(self._shared.odom_frame_id, self._course.lap()))

    def _waits_for_a_run(self, changed: Mapping[str, Any]) -> bool:
        return self._shared.lockstep and set(changed) != {PERIOD}

    def _refusals(self, values: ReferenceCartParameters) -> Iterable[str]:
        jumps = values.curve.placement._replace(period=0.0) != self._values.curve.placement._replace(period=0.0)
        if (jumps or values.curve.curve != self._values.curve.curve) and not (
                self._shared.lockstep or self._wait is not None or self._began is None):
            yield _JUMP

    def _change(self, values: ReferenceCartParameters, waits: bool) -> None:
        before = self._values
        super()._change(values, waits)
        if waits:
            return
        only_period = before.curve.placement._replace(period=values.curve.placement.period)
        if values.curve == before.curve._replace(placement=only_period):
            self._course.change_period(values, self._time())
        else:
            self._begin_course()

    def _begin_course(self) -> None:
        """Begin on the curve of the parameters; a cart that waits, at its start."""
        if self._course.is_new(self._values.curve):
            self._course.begin(self._values.curve)
            self._publish_path()
            if self._wait is not None:
                self._wait.begin_anew()
        else:
            self._course.begin(self._values.curve)

    def _time(self) -> float:
        """Return the time along the curve [s]."""
        if self._shared.lockstep:
            return (self._policy.accepted or 0) / 1e9
        if self._wait is not None:
            return self._wait.time
        return 0.0 if self._began is None else self._robot_clock.now() - self._began

    def _on_odom(self, message: bytes) -> None:
        valid = self._validator.validate('odom', message, self._read, self._policy)
        if valid is None:
            return
        if valid.decision is StampDecision.HOLD:
            if self._began is None:
                self._began = self._robot_clock.now()
                self._note_run(StampDecision.HOLD)
            if self._wait is not None:
                self._wait.note(valid.value[0])
            return
        if valid.decision is StampDecision.AGAIN and self._answer is not None:
            self._publish(valid.stamp, self._answer)
            return
        if valid.decision in (StampDecision.START, StampDecision.JOIN):
            self._note_run(valid.decision, valid.stamp)
        if valid.decision is StampDecision.START:
            self._begin_course()
        self._policy.accept(valid.stamp)
        self._answer = self._course.references(valid.stamp)
        self._publish(valid.stamp, self._answer)
        self._diagnostics.note_step()
        if self._events.pending:
            self._events.publish_pending(valid.stamp)

    def _reached(self) -> int | None:
        return self._policy.accepted

    def _tick(self) -> None:
        """On the wall clock, the curve's time starts at the first odometry, and stands while the cart waits."""
        if self._began is not None:
            stamp = self._clock_stamp()
            self._publish(stamp, self._course.references(round((self._robot_clock.now() - self._began) * 1e9))
                          if self._wait is None else self._wait.references())
            self._diagnostics.note_step()
            if self._events.pending:
                self._events.publish_pending(stamp)

    def _condition(self) -> Condition | None:
        return self._wait.condition() if self._wait is not None else None

    def _publish(self, stamp: int, references: tuple[Reference, ...]) -> None:
        reference = references[0]
        if self._horizon is not None:
            self._horizon.publish(self._write_horizon(stamp, references))
        self._reference.publish(self._write(stamp, reference.pose, reference.velocity))

    def close(self) -> None:
        """End when the last messages have arrived."""
        super().close()
        flush(self._reference, *filter(None, [self._horizon]))
