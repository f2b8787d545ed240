"""The node `plant`: the simulated robot, from wheel torques to odometry."""

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node
from sensor_msgs.msg import JointState

from mobile_robot_control.configuration import PlantParameters, period_nanoseconds
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.imperfections import driven, empty_line
from mobile_robot_control.quantities import Pose, WheelTorque
from mobile_robot_control.readings import read_torque
from mobile_robot_control.ros.border import Border, Gate, reader
from mobile_robot_control.ros.diagnostics import Condition, Diagnostics
from mobile_robot_control.ros.lockstep import Pace, Turn
from mobile_robot_control.ros.parameter_bridge import declare
from mobile_robot_control.ros.parameter_service import CheckedParameterService
from mobile_robot_control.ros.peers import Peers, Witness
from mobile_robot_control.ros.plant_topics import PlantTopics
from mobile_robot_control.ros.qos import NEWEST
from mobile_robot_control.ros.wall_clock import ClockGate, Ticker

_NO_TORQUE = WheelTorque(0.0, 0.0)


class Plant(Node):
    """
    Steps the robot's dynamics and, in lockstep, simulated time.

    Attributes
    ----------
    exit_code : int or None
        0 after `duration`, 1 after the motion diverged, None before.

    """

    def __init__(self) -> None:
        super().__init__('plant', start_parameter_services=False)
        self._values = declare(self, PlantParameters)
        shared = self._values.shared
        self.exit_code: int | None = None
        self._period, self._position_period = map(period_nanoseconds, (shared.velocity_rate, shared.position_rate))
        self._steps = round(self._values.duration * shared.velocity_rate)
        self._sampled = dynamics.sample(shared.robot, 1.0 / shared.velocity_rate, self._values.centripetal_coupling)
        self._state = dynamics.at_rest(Pose(*self._values.initial_pose))
        self._applied = self._torque = _NO_TORQUE
        self._line = empty_line(self._values.imperfections.delay)
        self._k = 0  # steps so far
        self._topics = PlantTopics(self, self._values)
        self._witness = Witness(self, shared.peer_timeout)
        sources = {} if shared.lockstep else {'wheel_torques': 'velocity_controller'}  # there the witness knows
        self._peers = Peers(self, sources, shared.peer_timeout)
        self._border = Border(self, self._peers)
        self._read = reader(JointState, read_torque)
        self._pace: Pace | None = None
        self._gate: Gate
        if shared.lockstep:
            factor = self._values.real_time_factor
            self._gate = self._pace = Pace(self, self._period, factor, self._publish, self._repeat)
        else:
            self._gate = ClockGate(self, shared.stamp_tolerance)
        ticker = self._pace or Ticker(self, shared.velocity_rate, self._tick)
        self._diagnostics = Diagnostics(self, self._border, self._peers, ticker, self._condition)
        self.create_subscription(JointState, 'wheel_torques', self._on_wheel_torques, NEWEST, raw=True)
        CheckedParameterService(self, PlantParameters, self._change)
        if self._pace is not None:
            self._pace.ask(self._now)

    @property
    def _now(self) -> int:
        """Simulated time [ns], on the wall clock too."""
        return self._k * self._period

    @property
    def _held(self) -> bool:
        """Whether time stands still because somebody wants it so."""
        return self._values.paused or 0 < round(self._values.hold_at * 1e9) <= self._now

    def _change(self, values: PlantParameters) -> None:
        held, self._values = self._held, values
        if held and not self._held and self._pace is not None:
            self._pace.remind()

    def _condition(self) -> Condition | None:
        if self._held:
            return Condition(DiagnosticStatus.OK, 'paused')
        if self._witness.named:
            return Condition(DiagnosticStatus.ERROR if self._now else DiagnosticStatus.STALE, 'waiting',
                             self._witness.named)
        return None

    def _publish(self) -> None:
        """In lockstep: say where the robot is; at position ticks odometry too."""
        if self._now % self._position_period == 0:
            self._topics.publish_odometry(self._now, self._k, self._state)
        self._topics.publish_joint_states(self._now, self._k, self._state, self._applied)

    def _repeat(self, silence: float) -> None:
        """Say the newest of both again, whichever of the others missed it."""
        if not self._held:
            self._witness.stalled(silence, self._now, self._now - self._now % self._position_period)
        self._topics.repeat_odometry()
        self._topics.publish_joint_states(self._now, self._k, self._state, self._applied)

    def _on_wheel_torques(self, message: bytes) -> None:
        admitted = self._border.admit('wheel_torques', message, self._read, self._gate)
        if admitted is None:
            return
        if admitted.turn is Turn.HOLD:
            self._torque = admitted.value
        elif admitted.turn is Turn.STEP and not self._held:
            self._on_answer(admitted.value)

    def _on_answer(self, torque: WheelTorque) -> None:
        if self._k == self._steps > 0:
            self.exit_code = 0
            return
        saturated = self._step(torque)
        if self.exit_code is None and self._pace is not None:
            self._pace.ask(self._now)
        # somebody waits for the next question, nobody for the books
        self._diagnostics.stepped(saturated)
        self._witness.progressed()

    def _tick(self) -> None:
        """On the wall clock: step with the newest torque, or none when it is too old."""
        if self._held:
            # without odometry a cart that has not begun does not begin either
            self._topics.publish_joint_states(self.get_clock().now().nanoseconds, self._k, self._state, self._applied)
            return
        if self._peers.age('wheel_torques') > self._values.torque_timeout:
            self._torque = _NO_TORQUE
            self._diagnostics.stopped('wheel_torques')
        self._diagnostics.stepped(self._step(self._torque))
        if self.exit_code is None:
            stamp = self.get_clock().now().nanoseconds
            if self._now % self._position_period == 0:
                self._topics.publish_odometry(stamp, self._k, self._state)
            self._topics.publish_joint_states(stamp, self._k, self._state, self._applied)
            if self._k == self._steps > 0:
                self.exit_code = 0

    def _step(self, torque: WheelTorque) -> bool:
        """Step the robot; says whether the motors gave less than they were asked for."""
        values = self._values
        self._state, self._line, acting, self._applied = driven(
            self._state, self._line, torque, self._k, self._sampled, values.imperfections, values.max_wheel_torque)
        self._k += 1
        if dynamics.diverged(self._state):
            self.get_logger().fatal(
                f'the motion diverged at t = {self._now / 1e9:g} s: {self._state.pose}, {self._state.velocity}; '
                'lower the gains or raise the rates'
            )
            self.exit_code = 1
        return self._applied != acting

    def close(self) -> None:
        """End when the last messages have arrived."""
        if self.exit_code == 1:
            self._diagnostics.end(DiagnosticStatus.ERROR, 'diverged')
        else:
            self._diagnostics.end()
        self._topics.flush()
