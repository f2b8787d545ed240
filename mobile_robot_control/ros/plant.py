"""The node `plant`: the simulated robot, from wheel torques or velocity commands to odometry."""

from diagnostic_msgs.msg import DiagnosticStatus

from mobile_robot_control.messages.parsing import read_torque
from mobile_robot_control.model import dynamics
from mobile_robot_control.parameters.nodes import PlantParameters, loop_of
from mobile_robot_control.quantities import BodyVelocity, WheelTorque
from mobile_robot_control.ros.command_input import CommandInput
from mobile_robot_control.ros.diagnostics import Condition
from mobile_robot_control.ros.input_validation import ValidInput, make_reader
from mobile_robot_control.ros.loop_node import LoopNode
from mobile_robot_control.ros.pacing import LockstepPacer
from mobile_robot_control.ros.plant_publishers import PlantPublishers
from mobile_robot_control.ros.simulated_robot import SimulatedRobot
from mobile_robot_control.ros.stall_detector import StallDetector
from mobile_robot_control.ros.stamp_policy import AnswerStampPolicy, StampDecision, StampPolicy, WallClockStampPolicy
from mobile_robot_control.stamps import period_nanoseconds
from mobile_robot_control.topics import LoopGraph

_STANDS = BodyVelocity(0.0, 0.0)
_NO_TORQUE = WheelTorque(0.0, 0.0)


class Plant(LoopNode[PlantParameters]):
    """
    Steps the robot's dynamics and, in lockstep, simulated time.

    Attributes
    ----------
    exit_code : int or None
        0 after `duration`, 1 after the motion diverged, None before.

    """

    def __init__(self) -> None:
        super().__init__('plant', PlantParameters)
        shared = self._shared
        self._period, self._position_period = map(period_nanoseconds, (shared.velocity_rate, shared.position_rate))
        self._steps = round(self._values.duration * shared.velocity_rate)
        self._robot = SimulatedRobot(self._values)
        self._asked: BodyVelocity | WheelTorque = self._nothing
        self._plant_publishers = PlantPublishers(self, self._values, self._robot, self._publish_on)
        self._stall_detector = StallDetector(self, shared.peer_timeout, self._loop)
        self._pacer: LockstepPacer | None = None
        self._policy: StampPolicy
        if shared.lockstep:
            period = self._position_period if self._robot.takes_velocity else self._period
            self._policy = answers = AnswerStampPolicy(period)
            self._pacer = LockstepPacer(self, answers, self._values.real_time_factor, self._publish, self._repeat)
        else:
            self._policy = WallClockStampPolicy(self.get_clock(), shared.stamp_tolerance)
        if self._robot.takes_velocity:
            self._commands = CommandInput(
                self._validator, self._policy, shared.base_frame_id, self._clock_stamp, self._on_command)
            self._commands.subscribe(self, shared.stamped_cmd_vel, self._subscribe)
        else:
            self._read = make_reader('wheel_torques', read_torque)
            self._subscribe('wheel_torques', self._on_wheel_torques)
        self._start(shared.velocity_rate, self._tick, self._pacer)
        if self._pacer is not None:
            self._pacer.ask(self._now)

    def _loop_graph(self) -> LoopGraph:
        return loop_of(self._values)

    @property
    def _nothing(self) -> BodyVelocity | WheelTorque:
        """What stops the robot."""
        return _STANDS if self._robot.takes_velocity else _NO_TORQUE

    def _monitored(self) -> dict[str, str]:
        # in lockstep the stall detector names the missing node
        return {} if self._shared.lockstep else super()._monitored()

    def _awaited(self) -> list[str]:
        # in lockstep the first step needs an answer of every other node
        others = [node for node in self._loop.nodes if node != self._own_name]
        return others if self._shared.lockstep else super()._awaited()

    def _reached(self) -> int:
        return self._now

    @property
    def _now(self) -> int:
        """Simulated time [ns], on the wall clock too."""
        return self._robot.k * self._period

    @property
    def _held(self) -> bool:
        """Whether time stands still by `paused` or `hold_at`."""
        return self._values.paused or 0 < round(self._values.hold_at * 1e9) <= self._now

    def _change(self, values: PlantParameters) -> None:
        held = self._held
        super()._change(values)
        if held and not self._held and self._pacer is not None:
            self._pacer.remind()

    def _condition(self) -> Condition | None:
        if self._held:
            return Condition(DiagnosticStatus.OK, 'paused')
        if self._stall_detector.named:
            return Condition(DiagnosticStatus.ERROR if self._now else DiagnosticStatus.STALE, 'waiting',
                             self._stall_detector.named)
        return None

    def _publish(self) -> None:
        """In lockstep: publish the question, at position ticks with odometry."""
        if self._now % self._position_period == 0:
            self._plant_publishers.publish_odometry(self._now)
        self._plant_publishers.publish_joint_states(self._now)

    def _repeat(self, silence: float) -> None:
        """Publish the newest of both again, whichever node missed them."""
        if not self._held:
            self._stall_detector.note_silence(silence, self._now, self._now - self._now % self._position_period)
        self._plant_publishers.repeat_odometry()
        self._plant_publishers.publish_joint_states(self._now)

    def _on_wheel_torques(self, message: bytes) -> None:
        valid = self._validator.validate('wheel_torques', message, self._read, self._policy)
        if valid is not None:
            self._on_command(valid)

    def _on_command(self, valid: ValidInput) -> None:
        if valid.decision is StampDecision.HOLD:
            self._asked = valid.value
        elif valid.decision is StampDecision.STEP and not self._held:
            self._on_answer(valid.value)

    def _on_answer(self, asked: BodyVelocity | WheelTorque) -> None:
        if self._robot.k == self._steps > 0:
            self.exit_code = 0
            return
        saturated = self._step(asked)
        # a base follows a command until the next position tick, and needs no answer in between
        while self._robot.takes_velocity and self.exit_code is None and self._now % self._position_period:
            self._plant_publishers.publish_joint_states(self._now)
            if self._robot.k == self._steps > 0:
                self.exit_code = 0
            else:
                self._step(asked)
        if self.exit_code is None and self._pacer is not None:
            self._pacer.ask(self._now)
        # publish before updating diagnostics: the other nodes wait for the next question
        self._diagnostics.note_step(saturated)
        self._stall_detector.note_progress()

    def _tick(self) -> None:
        """On the wall clock: step with what was asked for last, or nothing when that is too old."""
        if self._held:
            # without odometry a cart that has not begun does not begin
            self._plant_publishers.publish_joint_states(self._clock_stamp())
            return
        if 0.0 < self._timeout < self._monitor.age(self._loop.command):
            self._asked = self._nothing
            self._diagnostics.note_stop(self._loop.command)
        self._diagnostics.note_step(self._step(self._asked))
        if self.exit_code is None:
            stamp = self._clock_stamp()
            if self._robot.has_sensors:
                self._plant_publishers.publish_sample(stamp)
            elif self._now % self._position_period == 0:
                self._plant_publishers.publish_odometry(stamp)
            self._plant_publishers.publish_joint_states(stamp)
            if self._robot.k == self._steps > 0:
                self.exit_code = 0

    @property
    def _timeout(self) -> float:
        """Wall time without what the plant takes after which it stops [s]; 0 for never."""
        return self._values.model.base.command_timeout if self._robot.takes_velocity else self._values.torque_timeout

    def _step(self, asked: BodyVelocity | WheelTorque) -> bool:
        """Step the robot; return whether it gave less than was asked for."""
        if not self._in_run:
            self._note_run(StampDecision.START)
        saturated = self._robot.step(asked)
        if dynamics.diverged(self._robot.state):
            self.get_logger().fatal(
                f'the motion diverged at t = {self._now / 1e9:g} s: {self._robot.state.pose}, '
                f'{self._robot.state.velocity}; lower the gains or raise the rates'
            )
            self.exit_code = 1
        return saturated

    def _last_condition(self) -> Condition:
        return Condition(DiagnosticStatus.ERROR, 'diverged') if self.exit_code == 1 else super()._last_condition()

    def close(self) -> None:
        """End when the last messages have arrived."""
        super().close()
        self._plant_publishers.flush()
