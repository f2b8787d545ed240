"""The node `plant`: the simulated robot, from wheel torques or velocity commands to odometry."""

from collections.abc import Mapping
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus

from mobile_robot_control.configuration.nodes import PlantParameters, loop_of
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.quantities import BodyVelocity, WheelTorque
from mobile_robot_control.ros.diagnostics import Condition
from mobile_robot_control.ros.disturbance_input import DisturbanceInput
from mobile_robot_control.ros.input_validation import ValidInput
from mobile_robot_control.ros.loop_node import LoopNode
from mobile_robot_control.ros.pacing import LockstepPacer
from mobile_robot_control.ros.plant_input import PlantInput
from mobile_robot_control.ros.plant_publishers import PlantPublishers
from mobile_robot_control.ros.run_control import RunControl
from mobile_robot_control.ros.simulated_robot import SimulatedRobot
from mobile_robot_control.ros.stall_detector import StallDetector
from mobile_robot_control.ros.stamp_policy import AnswerStampPolicy, StampDecision, StampPolicy, WallClockStampPolicy
from mobile_robot_control.stamps import period_nanoseconds
from mobile_robot_control.topics import LoopGraph


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
        if self._robot_clock.is_simulated:
            raise ParameterError(['use_sim_time = True with lockstep = False: the plant moves by the wall clock and is '
                                  'a simulator itself; start it without use_sim_time, or in lockstep'])
        self._period, self._position_period = map(period_nanoseconds, (shared.velocity_rate, shared.position_rate))
        self._steps = round(self._values.duration * shared.velocity_rate)
        self._robot = SimulatedRobot(self._values)
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
        self._input = PlantInput(
            self._values, self._robot.takes_velocity, self._validator, self._policy, self._on_command)
        self._asked: BodyVelocity | WheelTorque = self._input.nothing
        self._input.subscribe(self, self._clock_stamp, self._subscribe)
        self._disturbances = DisturbanceInput(self, shared, self._validator, self._events, self._robot.takes_velocity)
        self._runs = RunControl(self, self._values, lambda: self._now, self._go_on, self._begin_anew)
        self._start(shared.velocity_rate, self._tick, self._pacer)
        if self._pacer is not None:
            self._pacer.ask(self._now)

    def _loop_graph(self) -> LoopGraph:
        return loop_of(self._values)

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

    def _waits_for_a_run(self, changed: Mapping[str, Any]) -> bool:
        return 'initial_pose' in changed

    def _change(self, values: PlantParameters, waits: bool) -> None:
        super()._change(values, waits)
        self._runs.change(values)
        if self._pacer is not None:
            self._pacer.change(values.real_time_factor)

    def _go_on(self) -> None:
        """Repeat the question of a run that was held."""
        if self._pacer is not None:
            self._pacer.remind()

    def _begin_anew(self) -> None:
        """Begin a new run: the robot at rest at its initial pose and, in lockstep, simulated time at 0."""
        ended, pose = self._stamp() + self._period, self._values.initial_pose
        self._robot.begin(pose)
        self._asked = self._input.nothing
        self._disturbances.waiting.clear()  # they were meant for the run that has ended
        self._runs.note_new_run()
        if self._pacer is not None:
            self._pacer.ask(self._now)
        self._events.publish(ended, {'reset': pose})
        self._note_run(StampDecision.START)
        self._events.publish_pending(self._stamp())

    def _stamp(self) -> int:
        """Return the stamp of messages that are published now [ns]."""
        return self._now if self._shared.lockstep else self._clock_stamp()

    def _condition(self) -> Condition | None:
        if self._runs.held:
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
        if not self._runs.held:
            self._stall_detector.note_silence(silence, self._now, self._now - self._now % self._position_period)
        self._plant_publishers.repeat_odometry()
        self._plant_publishers.publish_joint_states(self._now)

    def _on_command(self, valid: ValidInput) -> None:
        if valid.decision is StampDecision.HOLD:
            self._asked = valid.value
        elif valid.decision is StampDecision.STEP and not self._runs.held:
            self._on_answer(valid.value)

    def _on_answer(self, asked: BodyVelocity | WheelTorque) -> None:
        if self._runs.begins_anew():
            self._begin_anew()
            self._stall_detector.note_progress()
            return
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
        if self._runs.held:
            # without odometry a cart that has not begun does not begin
            self._plant_publishers.publish_joint_states(self._clock_stamp())
            return
        if 0.0 < self._input.timeout < self._monitor.age(self._loop.command):
            self._asked = self._input.nothing
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

    def _step(self, asked: BodyVelocity | WheelTorque) -> bool:
        """Step the robot; return whether it gave less than was asked for."""
        if not self._in_run:
            self._note_run(StampDecision.START)
        waiting = self._disturbances.waiting
        saturated = self._robot.step(asked, self._disturbances.take(self._robot.k, self._stamp()) if waiting else None)
        if self._robot.diverged:
            self.get_logger().fatal(f'the motion diverged at t = {self._now / 1e9:g} s: {self._robot.where}; '
                                    'lower the gains or raise the rates')
            self.exit_code = 1
        return saturated

    def _last_condition(self) -> Condition:
        return Condition(DiagnosticStatus.ERROR, 'diverged') if self.exit_code == 1 else super()._last_condition()

    def close(self) -> None:
        """End when the last messages have arrived."""
        super().close()
        self._plant_publishers.flush()
