"""The node `reference_cart`: drives the virtual robot that the real one follows."""

import time
from functools import partial

from nav_msgs.msg import Odometry, Path
from rclpy.node import Node

from mobile_robot_control.configuration import ReferenceCartParameters
from mobile_robot_control.readings import read_odometry
from mobile_robot_control.reference.curves import CURVES, reference_at
from mobile_robot_control.ros import messages
from mobile_robot_control.ros.border import Border, make_gate, reader
from mobile_robot_control.ros.diagnostics import Diagnostics
from mobile_robot_control.ros.lockstep import Turn
from mobile_robot_control.ros.parameter_bridge import declare
from mobile_robot_control.ros.parameter_service import CheckedParameterService
from mobile_robot_control.ros.peers import Peers
from mobile_robot_control.ros.qos import LATCHED, LOOP, NEWEST, flush
from mobile_robot_control.ros.wall_clock import Ticker

_PATH_POINTS = 400


class ReferenceCart(Node):
    """
    Answers each odometry with where the cart is at that time, and how it moves.

    Attributes
    ----------
    exit_code : None
        The node never ends by itself.

    """

    def __init__(self) -> None:
        super().__init__('reference_cart', start_parameter_services=False)
        parameters = declare(self, ReferenceCartParameters)
        shared = parameters.shared
        self.exit_code: int | None = None
        self._curve = CURVES[parameters.curve.curve]
        self._placement = parameters.curve.placement
        self._gate = make_gate(self, shared, shared.position_rate)
        self._read = reader(
            Odometry, partial(read_odometry, frame=shared.odom_frame_id, child_frame=shared.base_frame_id))
        self._peers = Peers(self, {'odom': 'plant'}, shared.peer_timeout)
        self._border = Border(self, self._peers)
        self._write = messages.odometry_writer(shared.odom_frame_id, shared.reference_frame_id)
        self._reference = self.create_publisher(Odometry, 'reference', LOOP)
        self._path = self.create_publisher(Path, 'reference_path', LATCHED)
        self._path.publish(messages.path_message(shared.odom_frame_id, [
            reference_at(self._curve, self._placement.period * n / _PATH_POINTS, self._placement).pose
            for n in range(_PATH_POINTS + 1)
        ]))
        self.create_subscription(Odometry, 'odom', self._on_odom, NEWEST, raw=True)
        self._started: float | None = None
        ticker = None if shared.lockstep else Ticker(self, shared.position_rate, self._tick)
        self._diagnostics = Diagnostics(self, self._border, self._peers, ticker)
        CheckedParameterService(self, ReferenceCartParameters)

    def _on_odom(self, message: bytes) -> None:
        admitted = self._border.admit('odom', message, self._read, self._gate)
        if admitted is None:
            return
        if admitted.turn is Turn.HOLD:
            self._started = self._started or time.monotonic()
            return
        if admitted.turn is Turn.START and self._gate.accepted is not None:
            self.get_logger().info('a new run')
        self._gate.accept(admitted.stamp)
        self._publish(admitted.stamp, admitted.stamp / 1e9)
        if admitted.turn is not Turn.AGAIN:
            self._diagnostics.stepped()

    def _tick(self) -> None:
        """On the wall clock, the curve's time starts at the first odometry."""
        if self._started is not None:
            self._publish(self.get_clock().now().nanoseconds, time.monotonic() - self._started)
            self._diagnostics.stepped()

    def _publish(self, stamp: int, time: float) -> None:
        reference = reference_at(self._curve, time, self._placement)
        self._reference.publish(self._write(stamp, reference.pose, reference.velocity))

    def close(self) -> None:
        """End when the last messages have arrived."""
        self._diagnostics.end()
        flush(self._reference)
