"""The node `position_controller`: from odometry and reference to a body velocity command."""

from functools import partial

from geometry_msgs.msg import Twist, TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.node import Node

from mobile_robot_control.configuration import PositionControllerParameters
from mobile_robot_control.control import handover
from mobile_robot_control.control.tracking_error import tracking_error
from mobile_robot_control.quantities import BodyVelocity, Pose, Reference, TrackingError
from mobile_robot_control.readings import read_odometry
from mobile_robot_control.ros import messages
from mobile_robot_control.ros.border import Border, make_gate, reader
from mobile_robot_control.ros.diagnostics import Diagnostics
from mobile_robot_control.ros.lockstep import Turn
from mobile_robot_control.ros.parameter_bridge import declare
from mobile_robot_control.ros.parameter_service import CheckedParameterService
from mobile_robot_control.ros.peers import Peers
from mobile_robot_control.ros.qos import LOOP, NEWEST, flush
from mobile_robot_control.ros.wall_clock import Ticker


class PositionController(Node):
    """
    Runs the position law that `controller_type` names.

    Attributes
    ----------
    exit_code : None
        The node never ends by itself.

    """

    def __init__(self) -> None:
        super().__init__('position_controller', start_parameter_services=False)
        self._values = declare(self, PositionControllerParameters)
        shared = self._values.shared
        self.exit_code: int | None = None
        self._lockstep = shared.lockstep
        self._dt = 1.0 / shared.position_rate
        self._gate = make_gate(self, shared, shared.position_rate)
        self._read_odom, self._read_reference = (
            reader(Odometry, partial(read_odometry, frame=shared.odom_frame_id, child_frame=child))
            for child in (shared.base_frame_id, shared.reference_frame_id)
        )
        self._peers = Peers(self, {'odom': 'plant', 'reference': 'reference_cart'}, shared.peer_timeout)
        self._border = Border(self, self._peers)
        self._running = handover.begin(self._values.control, under_way=False)
        self._odom: tuple[int, Pose] | None = None
        self._reference: tuple[int, Reference] | None = None
        self._answer: tuple[BodyVelocity, TrackingError] | None = None
        self._write_twist = messages.twist_writer(shared.base_frame_id, shared.stamped_cmd_vel)
        self._write_error = messages.error_writer(shared.base_frame_id)
        self._cmd_vel = self.create_publisher(TwistStamped if shared.stamped_cmd_vel else Twist, 'cmd_vel', LOOP)
        self._tracking_error = self.create_publisher(Vector3Stamped, 'tracking_error', LOOP)
        self.create_subscription(Odometry, 'odom', self._on_odom, NEWEST, raw=True)
        self.create_subscription(Odometry, 'reference', self._on_reference, NEWEST, raw=True)
        CheckedParameterService(self, PositionControllerParameters, self._change)
        self._tracking = False
        ticker = None if shared.lockstep else Ticker(self, shared.position_rate, self._tick)
        self._diagnostics = Diagnostics(self, self._border, self._peers, ticker)

    def _change(self, values: PositionControllerParameters) -> None:
        self._values = values
        self._running = handover.change(self._running, values.control)

    def _on_odom(self, message: bytes) -> None:
        admitted = self._border.admit('odom', message, self._read_odom, self._gate)
        if admitted is None:
            return
        if admitted.turn is Turn.AGAIN:
            self._publish(admitted.stamp)
            return
        self._odom = (admitted.stamp, admitted.value[0])
        self._answer_pair()

    def _on_reference(self, message: bytes) -> None:
        admitted = self._border.admit('reference', message, self._read_reference, self._gate)
        if admitted is not None and admitted.turn is not Turn.AGAIN:
            self._reference = (admitted.stamp, Reference(*admitted.value))
            self._answer_pair()

    def _answer_pair(self) -> None:
        """Step and answer once odometry and reference of the same, new stamp are there."""
        if self._odom is None or self._reference is None or self._odom[0] != self._reference[0]:
            return
        stamp = self._odom[0]
        turn = self._gate.judge(stamp)
        if turn in (Turn.AGAIN, Turn.REFUSED, Turn.HOLD):
            return
        if turn is not Turn.STEP:
            if self._gate.accepted is not None:
                self.get_logger().info('a new run')
            self._running = handover.begin(self._values.control, under_way=turn is Turn.JOIN)
        self._gate.accept(stamp)
        self._step(stamp, self._odom[1], self._reference[1])

    def _tick(self) -> None:
        """On the wall clock: step with the newest inputs, or stop the robot while one of them is silent."""
        stamp = self.get_clock().now().nanoseconds
        silent = [topic for topic in self._peers.sources if self._peers.age(topic) > self._values.input_timeout]
        if self._odom is not None and self._reference is not None and not silent:
            if not self._tracking:
                self._running = handover.begin(self._values.control, under_way=self._answer is not None)
            self._tracking = True
            self._step(stamp, self._odom[1], self._reference[1])
        elif self._answer is not None:
            self._tracking = False
            self._diagnostics.stopped(*silent)
            self._publish_command(stamp, BodyVelocity(0.0, 0.0))

    def _step(self, stamp: int, pose: Pose, reference: Reference) -> None:
        error = tracking_error(reference.pose, pose)
        self._running, command = handover.step(self._running, error, reference, self._dt)
        self._answer = (command, error)
        # somebody waits for the answer, nobody for the books
        self._publish(stamp)
        self._diagnostics.stepped()

    def _publish(self, stamp: int) -> None:
        if self._answer is not None:
            command, error = self._answer
            self._publish_command(stamp, command)
            self._tracking_error.publish(self._write_error(stamp, error))

    def _publish_command(self, stamp: int, command: BodyVelocity) -> None:
        self._cmd_vel.publish(self._write_twist(stamp, command))

    def close(self) -> None:
        """Stop a robot that runs on the wall clock; end when the last messages have arrived."""
        if not self._lockstep and self._answer is not None:
            self._publish_command(self.get_clock().now().nanoseconds, BodyVelocity(0.0, 0.0))
        self._diagnostics.end()
        flush(self._cmd_vel, self._tracking_error)
