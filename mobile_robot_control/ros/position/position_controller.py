"""The node `position_controller`: from odometry and reference to a body velocity command."""

from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus

from mobile_robot_control.control.compensation import carried_forward, mean_acceleration
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.parameters.declaration import ParameterError, build
from mobile_robot_control.quantities import NO_ACCELERATION, BodyVelocity, Observation, Reference
from mobile_robot_control.ros.position.law_runner import LawRunner
from mobile_robot_control.ros.position.modes import LockstepPosition, WallClockPosition
from mobile_robot_control.ros.position.namesakes import COMMAND
from mobile_robot_control.ros.position.odometry import OdomAge
from mobile_robot_control.ros.position.robot_guard import LockstepGuard, RobotGuard
from mobile_robot_control.ros.shared.conversions import reader
from mobile_robot_control.ros.shared.diagnostics import LAW_FAILED, Condition
from mobile_robot_control.ros.shared.lockstep import Outputs
from mobile_robot_control.ros.shared.loop_node import LoopNode
from mobile_robot_control.ros.shared.stamp_policy import Input, Inputs
from mobile_robot_control.settings.nodes import PositionControllerParameters, latency_cautions
from mobile_robot_control.topics import LAW_FILE

_STANDS: Outputs = {'cmd_accel': NO_ACCELERATION, 'cmd_vel': BodyVelocity(0.0, 0.0)}


def _timeout(values: PositionControllerParameters) -> float:
    return values.input_timeout


class PositionController(LoopNode[PositionControllerParameters]):
    """Runs the position law of `controller_type`."""

    modes = {True: LockstepPosition, False: WallClockPosition}  # noqa: RUF012 (nothing changes it)

    def __init__(self) -> None:
        super().__init__('position_controller', PositionControllerParameters)
        shared = self.shared
        self._law = LawRunner(self, self.parameters.control, 1.0 / shared.position_rate, self._tell)
        self._age: OdomAge = self._mode.make_age(shared)
        self._guard: LockstepGuard | RobotGuard = self._mode.make_guard(self, self._law)
        self._drives = False
        self._feeds = shared.feedforward.enabled
        topics = [topic for topic, wanted in (('odom', True), ('odom_time', shared.has_odom_time), (
            'reference_horizon', shared.reference_horizon > 0), ('reference', True)) if wanted]
        self._connect(
            {topic: Input(reader(topic, shared), self.position_period, _timeout) for topic in topics},
            ['cmd_accel', 'cmd_vel', 'tracking_error'] if self._feeds else ['cmd_vel', 'tracking_error'],
            shared.position_rate)
        self._mode.watch_corrections(self, self._guard)
        self.monitor.latencies['odom'] = self.parameters.odom_latency
        for text in latency_cautions(self.parameters):
            self.get_logger().warning(text)
        self._start()

    def _change(self, values: PositionControllerParameters, waits: bool) -> None:
        law, before = values.control.controller_type, self.parameters.control.controller_type
        super()._change(values, waits)
        self.monitor.latencies['odom'] = values.odom_latency
        self._law.change(values.control)
        if law != before:
            from mobile_robot_control.settings.law_sets import node_note  # noqa: PLC0415 (no node needs it to start)

            note = node_note(law, values)
            if note:
                self.get_logger().info(note)

    def read_again(self) -> None:
        """Read the changed files of laws again; their law joins the run as after a live switch."""
        try:
            read = LAWS.load_changed()
            control = self.parameters.control
            for name in read:
                gains: Any = build(LAWS[name].gains, getattr(control, name)._asdict())
                control = control._replace(**{name: gains})
            values = self.parameters._replace(control=control)
        except ParameterError as error:
            self.get_logger().error(f'{error}; the law goes on as it was')
            return
        if read:
            self.events.note_changes({LAW_FILE: ', '.join(f'{name} {checksum}' for name, checksum in read.items())})
            self._change(values, waits=False)

    def begin_run(self, inputs: Inputs, joins: bool) -> None:
        """Begin the law; a law that failed in another run starts again."""
        self._law.failure = ''
        self._law.begin_law(self.parameters.control, under_way=joins)
        if not joins:
            self._guard.check_start(
                self.parameters, inputs.value('odom')[0], Reference(*inputs.value('reference')))
        self._age.begin_run()

    def step(self, inputs: Inputs, _dt: float) -> Outputs:
        """Return command, acceleration and tracking error."""
        pose, velocity = inputs.value('odom')
        reference, *later = self._references(inputs)
        self._age.note_step(inputs.stamp, pose, velocity, inputs.value('odom_time'))
        if self.parameters.compensate_latency:
            pose = carried_forward(pose, velocity, self._age.at(inputs.stamp, self.parameters.odom_latency))
            reference = self._age.present(reference, inputs.stamp - inputs.messages['reference'][0])
        observation = Observation(tracking_error(reference.pose, pose), reference, velocity, tuple(later))
        acceleration = mean_acceleration(reference, later[0]) if self._feeds else None
        command = self._guard.command(observation, inputs.stamp, self.parameters, acceleration)
        if self._law.failure or self._guard.stands or acceleration is None:
            acceleration = NO_ACCELERATION
        self._drives = True
        return {'cmd_accel': acceleration, 'cmd_vel': command, 'tracking_error': observation.error}

    @staticmethod
    def _references(inputs: Inputs) -> tuple[Reference, ...]:
        """Return the reference, and those of the horizon, if any."""
        reference = Reference(*inputs.value('reference'))
        horizon = inputs.value('reference_horizon')
        if horizon is None:
            return (reference,)
        now, *later = horizon
        return (reference._replace(acceleration=now.acceleration), *later)

    def note_sent(self, topic: str, message: bytes) -> None:
        """Note a command."""
        if topic == COMMAND:
            self._guard.note_sent(message)

    def receive(self, topic: str, stamp: int, value: Any) -> Any:
        """Receive odometry; return it with the velocity of the robot."""
        if topic != 'odom':
            return value
        pose, velocity = value
        self._age.note_odometry(stamp, pose, velocity)
        return pose, self._guard.note_odometry(stamp, pose, velocity, self.parameters, self._drives)

    def is_held(self) -> bool:
        """Return whether the robot is stopped."""
        return self._guard.is_held(self.parameters)

    def resume(self) -> None:
        """Start the law again after a stand of the robot."""
        self._law.begin_law(self.parameters.control, under_way=True)

    def rest(self) -> Outputs:
        """Return a command that stops the robot, if it is this node's to command."""
        if not self._drives:
            self._guard.rest()
        self._drives = False
        return {} if self._guard.is_aside else _STANDS

    def forget_run(self) -> None:
        """Forget the ages and the conflict of a run after a jump back of simulated time."""
        self._age.begin_run()
        self._guard.forget_run()

    def _tell(self) -> None:
        self.diagnostics.publish_now()

    def act(self) -> str:
        """Apply a stop or a release at once; return the condition in words."""
        self._driver.tick()
        self.diagnostics.publish_now()
        return self.diagnostics.condition().text()

    def _condition(self) -> Condition | None:
        if self._law.failure:
            return Condition(DiagnosticStatus.ERROR, LAW_FAILED, detail=self._law.failure)
        return self._guard.condition(self.parameters, self.diagnostics.problems(), self._drives)

    def _last_condition(self) -> Condition:
        # a run may end before an experiment receives the first report
        return (self._condition() if self._law.failure else None) or super()._last_condition()
