"""The node `velocity_controller`: from a body velocity command and the wheels' velocities to wheel torques."""

from functools import partial

from mobile_robot_control.configuration.nodes import VelocityControllerParameters
from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.velocity_pi import VelocityPiState
from mobile_robot_control.messages import writing
from mobile_robot_control.messages.parsing import read_acceleration, read_wheel_velocity
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.quantities import BodyAcceleration, BodyVelocity, WheelTorque, WheelVelocity
from mobile_robot_control.ros.command_input import CommandInput
from mobile_robot_control.ros.input_validation import ValidInput, make_reader
from mobile_robot_control.ros.loop_node import LoopNode
from mobile_robot_control.ros.qos import flush
from mobile_robot_control.ros.stamp_policy import StampDecision, make_stamp_policy
from mobile_robot_control.stamps import period_nanoseconds

_OLDEST_ACCELERATION = 0.5
"""[s]: on the wall clock, an older acceleration is not fed forward."""
_ZERO = BodyVelocity(0.0, 0.0)
_OLDEST_WHEELS = 0.1
"""[s]: on the wall clock, no torque is asked for when the wheels' velocities are older."""


class VelocityController(LoopNode[VelocityControllerParameters]):
    """Runs the multivariable PI law."""

    def __init__(self) -> None:
        super().__init__('velocity_controller', VelocityControllerParameters)
        shared = self._shared
        self._changed = self._values
        self._dt = 1.0 / shared.velocity_rate
        self._period, self._position_period = map(period_nanoseconds, (shared.velocity_rate, shared.position_rate))
        self._policy = make_stamp_policy(self.get_clock(), shared, shared.velocity_rate)
        self._command_policy = make_stamp_policy(self.get_clock(), shared, shared.position_rate)
        self._read_wheels = make_reader('joint_states', read_wheel_velocity)
        self._commands = CommandInput(
            self._validator, self._command_policy, shared.base_frame_id, self._clock_stamp, self._on_command)
        self._state = VelocityPiState()
        self._wheels: tuple[int, WheelVelocity] | None = None
        self._command: tuple[int, BodyVelocity] | None = None
        self._feeds = shared.feedforward.enabled
        # without feedforward it is never asked for
        self._acceleration: tuple[int, BodyAcceleration] | None = None
        self._torque = WheelTorque(0.0, 0.0)
        self._write = writing.torque_writer()
        self._wheel_torques = self._publish_on('wheel_torques')
        self._subscribe('joint_states', self._on_joint_states)
        if self._feeds:
            self._read_acceleration = make_reader(
                'cmd_accel', partial(read_acceleration, frame=shared.base_frame_id))
            self._subscribe('cmd_accel', self._on_acceleration)
        self._commands.subscribe(self, shared.stamped_cmd_vel, self._subscribe)
        self._start(shared.velocity_rate, self._tick)

    def _forget(self) -> None:
        self._wheels = self._command = self._acceleration = None
        self._state, self._torque = VelocityPiState(), WheelTorque(0.0, 0.0)
        self._publish(self._clock_stamp())

    def _change(self, values: VelocityControllerParameters, _waits: bool) -> None:
        self._changed = values  # used from a position tick on

    def _on_joint_states(self, message: bytes) -> None:
        valid = self._validator.validate('joint_states', message, self._read_wheels, self._policy)
        if valid is None:
            return
        if valid.decision is StampDecision.AGAIN:
            self._publish(valid.stamp)
            return
        self._wheels = (valid.stamp, valid.value)
        self._answer_wheels()

    def _on_command(self, valid: ValidInput) -> None:
        # a command is held until the wheels of its position tick ask for it; of two with one stamp the first counts
        if self._command is None or self._command[0] != valid.stamp:
            self._command = (valid.stamp, valid.value)
            self._answer_wheels()

    def _on_acceleration(self, message: bytes) -> None:
        valid = self._validator.validate('cmd_accel', message, self._read_acceleration, self._command_policy)
        if valid is not None and (self._acceleration is None or self._acceleration[0] != valid.stamp):
            self._acceleration = (valid.stamp, valid.value)
            self._answer_wheels()

    def _answer_wheels(self) -> None:
        """Step and answer once new wheel velocities, and what their position tick commands, are there."""
        if self._wheels is None or self._command is None:
            return
        if self._feeds and (self._acceleration is None or self._acceleration[0] != self._command[0]):
            return
        stamp, wheels = self._wheels
        if self._command[0] != stamp - stamp % self._position_period:
            return
        decision = self._policy.decide(stamp)
        if decision in (StampDecision.AGAIN, StampDecision.REFUSED, StampDecision.HOLD):
            return
        if decision is not StampDecision.STEP:
            self._note_run(decision, stamp)
            self._state = VelocityPiState()
        self._policy.accept(stamp)
        self._command_policy.accept(self._command[0])
        if stamp == self._command[0]:
            self._values = self._changed  # live changes, at position ticks as in the position controller
        self._step(stamp, wheels, self._command[1], self._acceleration and self._acceleration[1],
                   (stamp - self._command[0]) // self._period * self._dt)
        if self._events.pending and self._values is self._changed:
            self._events.publish_pending(stamp)

    def _tick(self) -> None:
        """On the wall clock: step with the newest inputs; a silent command means zero, silent wheels no torque."""
        if self._wheels is None:
            return
        if not self._in_run:
            self._note_run(StampDecision.HOLD)
        stamp = self._clock_stamp()
        self._values = self._changed
        timeout = self._values.cmd_vel_timeout
        fresh = self._command is not None and (timeout == 0.0 or self._monitor.age('cmd_vel') <= timeout)
        if self._monitor.age('joint_states') <= _OLDEST_WHEELS:
            # accelerations may fall silent alone, where another node commands
            fed = self._acceleration is not None and fresh and self._monitor.age('cmd_accel') <= _OLDEST_ACCELERATION
            self._step(stamp, self._wheels[1], self._command[1] if fresh and self._command else _ZERO,
                       self._acceleration[1] if fed and self._acceleration else None,
                       min(self._monitor.age('cmd_vel'), self._position_period / 1e9))
            if self._events.pending:
                self._events.publish_pending(stamp)
            if not fresh:
                self._diagnostics.note_stop('cmd_vel')
        else:
            self._state, self._torque = VelocityPiState(), WheelTorque(0.0, 0.0)
            self._diagnostics.note_stop('joint_states')
            self._publish(stamp)

    def _reached(self) -> int | None:
        return self._policy.accepted

    def _step(
        self, stamp: int, wheels: WheelVelocity, command: BodyVelocity, acceleration: BodyAcceleration | None,
        age: float,
    ) -> None:
        measured, robot = body_velocity(wheels, self._shared.robot), self._shared.robot
        limit = self._values.max_wheel_torque
        if acceleration is not None:
            self._state, self._torque = velocity_pi.fed_step(
                self._state, command, acceleration, age, measured, self._values.gains, robot, limit, self._dt)
        else:
            self._state, self._torque = velocity_pi.step(
                self._state, command, measured, self._values.gains, robot, limit, self._dt)
        # publish before updating diagnostics: the plant waits for the answer
        self._publish(stamp)
        self._diagnostics.note_step(saturated=0.0 < limit <= max(abs(self._torque.right), abs(self._torque.left)))

    def _publish(self, stamp: int) -> None:
        self._wheel_torques.publish(self._write(stamp, self._torque))

    def close(self) -> None:
        """Release a robot that runs on the wall clock; end when the last messages have arrived."""
        if not self._shared.lockstep and self._wheels is not None:
            self._torque = WheelTorque(0.0, 0.0)
            self._publish(self._clock_stamp())
        super().close()
        flush(self._wheel_torques)
