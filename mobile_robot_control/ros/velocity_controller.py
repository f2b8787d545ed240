"""The node `velocity_controller`: from a body velocity command and the wheels' velocities to wheel torques."""

from functools import partial

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState

from mobile_robot_control.configuration import VelocityControllerParameters, period_nanoseconds
from mobile_robot_control.control import velocity_pi
from mobile_robot_control.control.velocity_pi import VelocityPiState
from mobile_robot_control.model.kinematics import body_velocity
from mobile_robot_control.quantities import BodyVelocity, WheelTorque, WheelVelocity
from mobile_robot_control.readings import read_twist, read_wheel_velocity
from mobile_robot_control.ros import messages
from mobile_robot_control.ros.border import Border, make_gate, reader
from mobile_robot_control.ros.diagnostics import Diagnostics
from mobile_robot_control.ros.lockstep import Turn
from mobile_robot_control.ros.parameter_bridge import declare
from mobile_robot_control.ros.parameter_service import CheckedParameterService
from mobile_robot_control.ros.peers import Peers
from mobile_robot_control.ros.qos import LOOP, NEWEST, flush
from mobile_robot_control.ros.wall_clock import Ticker

_BLIND_AFTER = 0.1
"""[s]: on the wall clock, no torque is asked for when the wheels' velocities are older."""


class VelocityController(Node):
    """
    Runs the multivariable PI law.

    Attributes
    ----------
    exit_code : None
        The node never ends by itself.

    """

    def __init__(self) -> None:
        super().__init__('velocity_controller', start_parameter_services=False)
        self._values = self._changed = declare(self, VelocityControllerParameters)
        shared = self._values.shared
        self.exit_code: int | None = None
        self._robot, self._lockstep = shared.robot, shared.lockstep
        self._dt = 1.0 / shared.velocity_rate
        self._position_period = period_nanoseconds(shared.position_rate)
        self._gate = make_gate(self, shared, shared.velocity_rate)
        self._command_gate = make_gate(self, shared, shared.position_rate)
        self._read_wheels = reader(JointState, read_wheel_velocity)
        self._read_twist = reader(TwistStamped, partial(read_twist, frame=shared.base_frame_id))
        self._stamp_twist = messages.twist_writer('')
        self._peers = Peers(
            self, {'joint_states': 'plant', 'cmd_vel': 'position_controller'}, shared.peer_timeout
        )
        self._border = Border(self, self._peers)
        self._state = VelocityPiState()
        self._wheels: tuple[int, WheelVelocity] | None = None
        self._command: tuple[int, BodyVelocity] | None = None
        self._torque = WheelTorque(0.0, 0.0)
        self._write = messages.torque_writer()
        self._wheel_torques = self.create_publisher(JointState, 'wheel_torques', LOOP)
        self.create_subscription(JointState, 'joint_states', self._on_joint_states, NEWEST, raw=True)
        if shared.stamped_cmd_vel:
            self.create_subscription(TwistStamped, 'cmd_vel', self._on_cmd_vel, NEWEST, raw=True)
        else:
            self.create_subscription(Twist, 'cmd_vel', self._on_twist, NEWEST)
        CheckedParameterService(self, VelocityControllerParameters, self._change)
        ticker = None if shared.lockstep else Ticker(self, shared.velocity_rate, self._tick)
        self._diagnostics = Diagnostics(self, self._border, self._peers, ticker)

    def _change(self, values: VelocityControllerParameters) -> None:
        self._changed = values

    def _on_joint_states(self, message: bytes) -> None:
        admitted = self._border.admit('joint_states', message, self._read_wheels, self._gate)
        if admitted is None:
            return
        if admitted.turn is Turn.AGAIN:
            self._publish(admitted.stamp)
            return
        self._wheels = (admitted.stamp, admitted.value)
        self._answer_wheels()

    def _on_cmd_vel(self, message: bytes) -> None:
        # a command is held until the wheels of its position tick ask for it
        admitted = self._border.admit('cmd_vel', message, self._read_twist, self._command_gate)
        # and of two with one stamp the first counts
        if admitted is not None and (self._command is None or self._command[0] != admitted.stamp):
            self._command = (admitted.stamp, admitted.value)
            self._answer_wheels()

    def _on_twist(self, message: Twist) -> None:
        velocity = BodyVelocity(message.linear.x, message.angular.z)
        self._on_cmd_vel(self._stamp_twist(self.get_clock().now().nanoseconds, velocity))

    def _answer_wheels(self) -> None:
        """Step and answer once new wheel velocities and the command of their position tick are there."""
        if self._wheels is None or self._command is None:
            return
        stamp, wheels = self._wheels
        if self._command[0] != stamp - stamp % self._position_period:
            return
        turn = self._gate.judge(stamp)
        if turn in (Turn.AGAIN, Turn.REFUSED, Turn.HOLD):
            return
        if turn is not Turn.STEP:
            if self._gate.accepted is not None:
                self.get_logger().info('a new run')
            self._state = VelocityPiState()
        self._gate.accept(stamp)
        self._command_gate.accept(self._command[0])
        if stamp == self._command[0]:
            self._values = self._changed  # live changes, at position ticks as in the position controller
        self._step(stamp, wheels, self._command[1])

    def _tick(self) -> None:
        """On the wall clock: step with the newest inputs; a silent command means zero, silent wheels no torque."""
        if self._wheels is None:
            return
        stamp = self.get_clock().now().nanoseconds
        self._values = self._changed
        timeout = self._values.cmd_vel_timeout
        fresh = self._command is not None and (timeout == 0.0 or self._peers.age('cmd_vel') <= timeout)
        if self._peers.age('joint_states') <= _BLIND_AFTER:
            self._step(stamp, self._wheels[1], self._command[1] if fresh and self._command else BodyVelocity(0.0, 0.0))
            if not fresh:
                self._diagnostics.stopped('cmd_vel')
        else:
            self._state, self._torque = VelocityPiState(), WheelTorque(0.0, 0.0)
            self._diagnostics.stopped('joint_states')
            self._publish(stamp)

    def _step(self, stamp: int, wheels: WheelVelocity, command: BodyVelocity) -> None:
        self._state, self._torque = velocity_pi.step(
            self._state, command, body_velocity(wheels, self._robot), self._values.gains, self._robot,
            self._values.max_wheel_torque, self._dt,
        )
        # somebody waits for the answer, nobody for the books
        self._publish(stamp)
        limit = self._values.max_wheel_torque
        self._diagnostics.stepped(saturated=0.0 < limit <= max(abs(self._torque.right), abs(self._torque.left)))

    def _publish(self, stamp: int) -> None:
        self._wheel_torques.publish(self._write(stamp, self._torque))

    def close(self) -> None:
        """Let go of a robot that runs on the wall clock; end when the last messages have arrived."""
        if not self._lockstep and self._wheels is not None:
            self._torque = WheelTorque(0.0, 0.0)
            self._publish(self.get_clock().now().nanoseconds)
        self._diagnostics.end()
        flush(self._wheel_torques)
