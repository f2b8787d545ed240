"""The node `position_controller`: from odometry and reference to a body velocity command."""

import math
from functools import partial

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist

from mobile_robot_control.configuration.nodes import PositionControllerParameters, counted_twice
from mobile_robot_control.control.feedforward import mean_acceleration
from mobile_robot_control.control.latency import carried_forward
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.messages import writing
from mobile_robot_control.messages.parsing import read_horizon, read_odometry, read_time
from mobile_robot_control.quantities import (
    NO_ACCELERATION,
    BodyAcceleration,
    BodyVelocity,
    Observation,
    Pose,
    Reference,
    TrackingError,
)
from mobile_robot_control.ros.command_choice import CommandChoice, approach_speed
from mobile_robot_control.ros.diagnostics import LAW_FAILED, Condition
from mobile_robot_control.ros.far_start import log_far_start
from mobile_robot_control.ros.input_validation import make_reader
from mobile_robot_control.ros.law_runner import LawRunner
from mobile_robot_control.ros.loop_node import LoopNode
from mobile_robot_control.ros.odom_age import OdomAge
from mobile_robot_control.ros.odom_conflict import CONFLICT, OdomConflict
from mobile_robot_control.ros.odom_twist import OdomTwist
from mobile_robot_control.ros.qos import PUBLISHED, flush
from mobile_robot_control.ros.stamp_policy import StampDecision, make_stamp_policy
from mobile_robot_control.stamps import period_nanoseconds

_ZERO = BodyVelocity(0.0, 0.0)


class PositionController(LoopNode[PositionControllerParameters]):
    """Runs the position law that `controller_type` names."""

    def __init__(self) -> None:
        super().__init__('position_controller', PositionControllerParameters)
        shared = self._shared
        self._policy = make_stamp_policy(self.get_clock(), shared, shared.position_rate)
        self._read_odom, self._read_reference = (
            make_reader(topic, partial(read_odometry, frame=shared.odom_frame_id, child_frame=child))
            for topic, child in (('odom', shared.base_frame_id), ('reference', shared.reference_frame_id))
        )
        self._law = LawRunner(self, self._values.control, 1.0 / shared.position_rate, self._tell_failure)
        self._twist, self._age = OdomTwist(self), OdomAge(shared)
        self._conflict = OdomConflict(self, self._watch, self._robot_clock, self._values.input_timeout)
        self._choice = CommandChoice(self, shared.lockstep, self._law, self._validator, self._act)
        self._odom: tuple[int, tuple[Pose, BodyVelocity]] | None = None
        self._odom_time: tuple[int, int] | None = None
        self._reference: tuple[int, Reference] | None = None
        self._horizon: tuple[int, tuple[Reference, ...]] | None = None
        self._answer: tuple[BodyVelocity, BodyAcceleration, TrackingError] | None = None
        self._write_twist = writing.twist_writer(shared.base_frame_id, shared.stamped_cmd_vel)
        self._write_error = writing.error_writer(shared.base_frame_id)
        self._cmd_vel = (self._publish_on('cmd_vel') if shared.stamped_cmd_vel
                         else self.create_publisher(Twist, 'cmd_vel', PUBLISHED))
        self._feeds = shared.feedforward.enabled
        self._write_acceleration = writing.acceleration_writer(shared.base_frame_id)
        self._cmd_accel = self._publish_on('cmd_accel') if self._feeds else None
        self._tracking_error = self._publish_on('tracking_error')
        if shared.has_odom_time:
            self._read_time = make_reader('odom_time', read_time)
            self._subscribe('odom_time', self._on_odom_time)
        self._subscribe('odom', self._on_odom)
        if shared.reference_horizon:
            self._read_horizon = make_reader('reference_horizon', partial(
                read_horizon, ticks=shared.reference_horizon, period=period_nanoseconds(shared.position_rate),
                frame=shared.odom_frame_id, child_frame=shared.reference_frame_id))
            self._subscribe('reference_horizon', self._on_horizon)
        self._subscribe('reference', self._on_reference)
        self._tracking, self._stopped = False, ''
        self._monitor.latencies['odom'] = self._values.odom_latency
        for text in counted_twice(self._values):
            self.get_logger().warning(text)
        self._start(shared.position_rate, self._tick)

    def _forget(self) -> None:
        self._odom = self._reference = self._horizon = self._answer = None
        self._tracking = False
        self._age.begin()
        self._conflict = OdomConflict(self, self._watch, self._robot_clock, self._values.input_timeout)
        self._publish_command(self._clock_stamp(), _ZERO)

    def _change(self, values: PositionControllerParameters, waits: bool) -> None:
        super()._change(values, waits)
        self._monitor.latencies['odom'] = values.odom_latency
        self._law.change(values.control)

    def _on_odom(self, message: bytes) -> None:
        valid = self._validator.validate('odom', message, self._read_odom, self._policy)
        if valid is None:
            return
        if valid.decision is StampDecision.AGAIN:
            self._publish(valid.stamp)
            return
        pose, velocity = valid.value
        if valid.decision is StampDecision.HOLD:
            self._age.note(valid.stamp, pose, velocity)
            self._conflict.note(valid.stamp, pose, velocity)
            velocity = self._twist.note(valid.stamp, pose, velocity)
        self._odom = (valid.stamp, (pose, velocity))
        self._answer_inputs()

    def _on_odom_time(self, message: bytes) -> None:
        valid = self._validator.validate('odom_time', message, self._read_time, self._policy)
        if valid is not None and valid.decision is not StampDecision.AGAIN:
            self._odom_time = (valid.stamp, valid.value)
            self._answer_inputs()

    def _on_reference(self, message: bytes) -> None:
        valid = self._validator.validate('reference', message, self._read_reference, self._policy)
        if valid is not None and valid.decision is not StampDecision.AGAIN:
            self._reference = (valid.stamp, Reference(*valid.value))
            self._answer_inputs()

    def _on_horizon(self, message: bytes) -> None:
        valid = self._validator.validate('reference_horizon', message, self._read_horizon, self._policy)
        if valid is not None and valid.decision is not StampDecision.AGAIN:
            self._horizon = (valid.stamp, valid.value)
            self._answer_inputs()

    def _references(self) -> tuple[Reference, ...] | None:
        """Return the newest reference, and those of the horizon where there is one; None where one is missing."""
        if self._reference is None:
            return None
        if not self._shared.reference_horizon:
            return (self._reference[1],)
        if self._horizon is None or (self._shared.lockstep and self._horizon[0] != self._reference[0]):
            return None
        now, *later = self._horizon[1]
        return (self._reference[1]._replace(acceleration=now.acceleration), *later)

    def _answer_inputs(self) -> None:
        """Step and answer once odometry, reference and horizon of the same, new stamp are there."""
        references = self._references()
        if (self._odom is None or self._reference is None or references is None
                or self._odom[0] != self._reference[0]):
            return
        if self._shared.has_odom_time and (self._odom_time is None or self._odom_time[0] != self._odom[0]):
            return
        stamp = self._odom[0]
        decision = self._policy.decide(stamp)
        if decision in (StampDecision.AGAIN, StampDecision.REFUSED, StampDecision.HOLD):
            return
        if decision is not StampDecision.STEP:
            self._note_run(decision, stamp)
            self._law.failure = ''
            self._law.begin(self._values.control, decision is StampDecision.JOIN)
            self._check_start(decision)
            self._age.begin()
        self._policy.accept(stamp)
        self._age.note(stamp, *self._odom[1])
        if self._odom_time is not None:
            self._age.tell(self._odom_time[1])
        self._step(stamp, *self._odom[1], references)

    def _tick(self) -> None:
        """On the wall clock: step with the newest inputs, or stop the robot while one of them is silent."""
        stamp = self._clock_stamp()
        silent = [topic for topic in self._monitor.sources if self._monitor.age(topic) > self._values.input_timeout]
        references = self._references()
        if self._choice.stop.reason or self._in_conflict():
            self._tracking = False
            self._publish_command(stamp, _ZERO)
        elif self._odom is not None and references is not None and not silent and self._choice.stop.is_known():
            if not self._in_run:
                self._note_run(StampDecision.HOLD)
                self._check_start(StampDecision.START)
            if not self._tracking:
                self._law.begin(self._values.control, under_way=self._answer is not None)
            self._tracking = True
            self._step(stamp, *self._odom[1], references)
        elif self._answer is not None:
            self._tracking = False
            self._diagnostics.note_stop(*silent)
            self._publish_command(stamp, _ZERO)
        if self._choice.stop.reason != self._stopped:
            self._stopped = self._choice.stop.reason
            self._events.publish(stamp, {'stop': self._stopped} if self._stopped else {'release': True})

    def _check_start(self, decision: StampDecision) -> None:
        """Log where a run starts far from the cart."""
        if decision is StampDecision.START and self._odom is not None and self._reference is not None:
            log_far_start(self, self._odom[1][0], self._reference[1].pose,
                          approach_speed(self._values, self._reference[1]))

    def _in_conflict(self) -> bool:
        return self._values.stop_on_odom_conflict and self._conflict.present

    def _act(self) -> str:
        """Apply a stop or a release at once; return the condition in words."""
        self._tick()
        self._diagnostics.publish_now()
        return self._diagnostics.condition().text()

    def _reached(self) -> int | None:
        return self._policy.accepted

    def _step(self, stamp: int, pose: Pose, velocity: BodyVelocity, references: tuple[Reference, ...]) -> None:
        reference, *later = references
        if self._values.compensate_latency:
            pose = carried_forward(pose, velocity, self._age.at(stamp, self._values.odom_latency))
            if not self._shared.lockstep and self._reference is not None:
                reference = self._age.present(reference, stamp - self._reference[0])
        observation = Observation(tracking_error(reference.pose, pose), reference, velocity, tuple(later))
        acceleration = mean_acceleration(reference, later[0]) if self._feeds else None
        command = (self._law.command(observation, stamp, math.inf, acceleration) if self._shared.lockstep
                   else self._choice.command(observation, self._values, acceleration))
        stands = self._law.failure or self._choice.stop.reason
        self._answer = (command, NO_ACCELERATION if stands or acceleration is None else acceleration, observation.error)
        # publish before updating diagnostics: other nodes wait for the answer
        self._publish(stamp)
        self._diagnostics.note_step()
        if self._events.pending:
            self._events.publish_pending(stamp)

    def _tell_failure(self) -> None:
        self._diagnostics.publish_now()

    def _condition(self) -> Condition | None:
        if self._law.failure:
            return Condition(DiagnosticStatus.ERROR, LAW_FAILED, detail=self._law.failure)
        if self._choice.stop.reason:
            return Condition(DiagnosticStatus.ERROR, 'stopped', detail=self._choice.stop.reason)
        if self._in_conflict():
            return Condition(DiagnosticStatus.ERROR, 'stopped', detail='; '.join(
                [CONFLICT, *self._diagnostics.problems()]))
        if self._twist.problem and self._tracking:
            return Condition(DiagnosticStatus.WARN, 'running', detail='; '.join(
                [self._twist.problem, *self._diagnostics.problems()]))
        return None

    def _last_condition(self) -> Condition:
        # a run may end before the first report that an experiment receives
        return (self._condition() if self._law.failure else None) or super()._last_condition()

    def _publish(self, stamp: int) -> None:
        if self._answer is not None:
            command, acceleration, error = self._answer
            self._publish_command(stamp, command, acceleration)
            self._tracking_error.publish(self._write_error(stamp, error))

    def _publish_command(
        self, stamp: int, command: BodyVelocity, acceleration: BodyAcceleration = NO_ACCELERATION
    ) -> None:
        if self._cmd_accel is not None:
            self._cmd_accel.publish(self._write_acceleration(stamp, acceleration))
        self._cmd_vel.publish(self._write_twist(stamp, command))

    def close(self) -> None:
        """Stop a robot that runs on the wall clock; end when the last messages have arrived."""
        if not self._shared.lockstep and self._answer is not None:
            self._publish_command(self._clock_stamp(), _ZERO)
        super().close()
        flush(self._cmd_vel, self._tracking_error, *filter(None, [self._cmd_accel]))
