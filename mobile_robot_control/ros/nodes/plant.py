"""The node `plant`: the simulated robot, from wheel torques or velocity commands to odometry."""

from __future__ import annotations  # rclpy's classes are generic from kilted on

from collections.abc import Callable, Mapping
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from std_srvs.srv import Trigger

from mobile_robot_control.configuration.nodes import PlantParameters, loop_of
from mobile_robot_control.parameters.checking import ParameterError
from mobile_robot_control.quantities import BodyVelocity, WheelTorque
from mobile_robot_control.ros.clocks.lockstep import Outputs
from mobile_robot_control.ros.clocks.questions import QuestionDriver
from mobile_robot_control.ros.clocks.run_control import LockstepRunControl, RunControl
from mobile_robot_control.ros.clocks.stall_detector import StallDetector
from mobile_robot_control.ros.inputs.conversions import reader
from mobile_robot_control.ros.inputs.disturbance_input import DisturbanceInput
from mobile_robot_control.ros.inputs.stamp_policy import StampDecision
from mobile_robot_control.ros.inputs.table import Input, Inputs, never
from mobile_robot_control.ros.nodes.loop_node import LoopNode
from mobile_robot_control.ros.nodes.plant_publishers import PlantPublishers
from mobile_robot_control.ros.nodes.simulated_robot import SimulatedRobot
from mobile_robot_control.ros.services.condition import Condition
from mobile_robot_control.topics import LoopGraph

_MEASURED: Outputs = {'odom': None, 'joint_states': None}
"""The outputs of a step: the measurements after it."""


def _torque_timeout(values: PlantParameters) -> float:
    return values.torque_timeout or never(values)


def _command_timeout(values: PlantParameters) -> float:
    return values.model.base.command_timeout or never(values)


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
        shared, lockstep = self._shared, self._shared.lockstep
        if self._robot_clock.is_simulated:
            raise ParameterError(['use_sim_time = True with lockstep = False: the plant moves by the wall clock and is '
                                  'a simulator itself; start it without use_sim_time, or in lockstep'])
        self._steps = round(self.parameters.duration * shared.velocity_rate)
        self._robot = SimulatedRobot(self.parameters)
        self._plant_publishers = PlantPublishers(self, self.parameters, self._robot, self._publish_on)
        self._control = (LockstepRunControl if lockstep else RunControl)(
            self.parameters, lambda: self.now, self._go_on, self.begin_anew)
        self._nothing = BodyVelocity(0.0, 0.0) if self._robot.takes_velocity else WheelTorque(0.0, 0.0)
        self._stamp: Callable[[], int] = (lambda: self.now) if lockstep else self._clock_stamp
        timeout, period = ((_command_timeout, self._position_period) if self._robot.takes_velocity
                           else (_torque_timeout, self._period))
        self._command = command = self._loop.command
        self._connect({command: Input(reader(command, shared), period, timeout, needed=False, stops=False)}, [],
                      shared.velocity_rate)
        self._disturbances = DisturbanceInput(self, shared, self._validator, self._events, self._robot.takes_velocity)
        self.create_service(Trigger, '~/reset', lambda _, response: _answer(response, self._control.reset()))
        self.create_service(Trigger, '~/step', lambda _, response: _answer(response, self._control.step()))
        if isinstance(self._driver, QuestionDriver):
            self._driver.ask()
        self._start()

    def _make_driver(self, inputs: Mapping[str, Input], rate: float) -> Any:
        if not isinstance(self._control, LockstepRunControl):
            return super()._make_driver(inputs, rate)
        (command,) = inputs.values()
        stalls = StallDetector(self, self._shared.peer_timeout, self._loop)
        driver = QuestionDriver(self, self, command.period, self._control, stalls, self.parameters.real_time_factor)
        self._pace = driver.pace
        return driver

    def _loop_graph(self) -> LoopGraph:
        return loop_of(self.parameters)

    def _monitored(self) -> dict[str, str]:
        # in lockstep the stall detector names the missing node
        return {} if self._shared.lockstep else super()._monitored()

    def _awaited(self) -> list[str]:
        # in lockstep the first step needs an answer of every other node
        others = [node for node in self._loop.nodes if node != self._own_name]
        return others if self._shared.lockstep else super()._awaited()

    def _reached(self) -> int:
        return self.now

    @property
    def now(self) -> int:
        """Simulated time [ns], also on the wall clock."""
        return self._robot.k * self._period

    @property
    def tick(self) -> int:
        """The present position tick [ns]."""
        return self.now - self.now % self._position_period

    @property
    def is_over(self) -> bool:
        """Whether the run has reached its end."""
        return self._robot.k == self._steps > 0

    def _waits_for_a_run(self, changed: Mapping[str, Any]) -> bool:
        return 'initial_pose' in changed

    def _change(self, values: PlantParameters, waits: bool) -> None:
        super()._change(values, waits)
        self._control.change(values)
        self._driver.change(values)

    def _go_on(self) -> None:
        self._driver.go_on()

    def begin_anew(self) -> None:
        """Begin a new run: the robot at rest at its initial pose and, in lockstep, simulated time at 0."""
        ended, pose = self._stamp() + self._period, self.parameters.initial_pose
        self._robot.begin(pose)
        self._disturbances.waiting.clear()  # they belong to the previous run
        self._driver.restart()
        self._events.publish(ended, {'reset': pose})
        self.note_run(StampDecision.START)
        self._events.publish_pending(self._stamp())

    def _condition(self) -> Condition | None:
        return Condition(DiagnosticStatus.OK, 'paused') if self._control.held else self._driver.condition()

    def step(self, inputs: Inputs, _dt: float) -> Outputs:
        """Move by one velocity period."""
        if not self._has_run:
            self.note_run(StampDecision.START)
        asked = inputs.value(self._command)
        push = self._disturbances.take(self._robot.k, self._stamp()) if self._disturbances.waiting else None
        self._saturated = self._robot.step(self._nothing if asked is None else asked, push)
        if self._robot.diverged:
            self.get_logger().fatal(f'the motion diverged at t = {self.now / 1e9:g} s: {self._robot.where}; '
                                    'lower the gains or raise the rates')
            self.exit_code = 1
        return _MEASURED

    # in lockstep

    def publish_question(self) -> None:
        """Publish the question of the present time, at position ticks with odometry."""
        now = self.now
        if now % self._position_period == 0:
            self._plant_publishers.publish_odometry(now)
        self._plant_publishers.publish_joint_states(now)

    def repeat_question(self) -> None:
        """Publish the newest wheels and odometry again, for the node that missed them."""
        self._plant_publishers.repeat_odometry()
        self.publish_wheels()

    def publish_wheels(self) -> None:
        """Publish `joint_states` of the present time."""
        self._plant_publishers.publish_joint_states(self._stamp())

    # on the wall clock

    def is_held(self) -> bool:
        """Return whether time stands still."""
        return self._control.held

    def rest(self) -> Outputs:
        """Publish only `joint_states` while time stands still: without odometry no cart begins."""
        if self._control.held:
            self.publish_wheels()
        return {}

    def publish(self, stamp: int, outputs: Outputs) -> None:
        """Publish the measurements after a step."""
        if self.exit_code is not None or not outputs:
            return
        if self._robot.has_sensors:
            self._plant_publishers.publish_sample(stamp)
        elif self.now % self._position_period == 0:
            self._plant_publishers.publish_odometry(stamp)
        self._plant_publishers.publish_joint_states(stamp)
        if self.is_over:
            self.exit_code = 0

    def _last_condition(self) -> Condition:
        return Condition(DiagnosticStatus.ERROR, 'diverged') if self.exit_code == 1 else super()._last_condition()

    def close(self) -> None:
        """End after the arrival of the last messages."""
        super().close()
        self._plant_publishers.flush()


def _answer(response: Any, answer: tuple[bool, str]) -> Any:
    response.success, response.message = answer
    return response
