"""The node `reference_cart`: moves the virtual robot that the real one follows."""

import time
from functools import partial

from nav_msgs.msg import Path
from rclpy.node import Node

from mobile_robot_control.messages import writing
from mobile_robot_control.messages.parsing import read_odometry
from mobile_robot_control.parameters.nodes import ReferenceCartParameters
from mobile_robot_control.reference.cart import reference_at
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.ros.diagnostics import Diagnostics
from mobile_robot_control.ros.input_monitor import InputMonitor
from mobile_robot_control.ros.input_validation import InputValidator, make_reader
from mobile_robot_control.ros.pacing import FixedRateTimer
from mobile_robot_control.ros.parameter_bridge import declare
from mobile_robot_control.ros.parameter_service import CheckedParameterService
from mobile_robot_control.ros.qos import LATCHED, flush, publish_on, subscribe_to
from mobile_robot_control.ros.stamp_policy import StampDecision, make_stamp_policy
from mobile_robot_control.topics import inputs_of

_PATH_POINTS = 400


class ReferenceCart(Node):
    """
    Answers each odometry with the cart's pose and velocity at that time.

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
        self._policy = make_stamp_policy(self.get_clock(), shared, shared.position_rate)
        self._read = make_reader(
            'odom', partial(read_odometry, frame=shared.odom_frame_id, child_frame=shared.base_frame_id))
        self._monitor = InputMonitor(self, inputs_of('reference_cart'), shared.peer_timeout)
        self._validator = InputValidator(self, self._monitor)
        self._write = writing.odometry_writer(shared.odom_frame_id, shared.reference_frame_id)
        self._reference = publish_on(self, 'reference')
        self._path = self.create_publisher(Path, 'reference_path', LATCHED)
        self._path.publish(writing.path_message(shared.odom_frame_id, [
            reference_at(self._curve, self._placement.period * n / _PATH_POINTS, self._placement).pose
            for n in range(_PATH_POINTS + 1)
        ]))
        subscribe_to(self, 'odom', self._on_odom)
        self._started: float | None = None
        timer = None if shared.lockstep else FixedRateTimer(self, shared.position_rate, self._tick)
        self._diagnostics = Diagnostics(self, self._validator, self._monitor, timer)
        CheckedParameterService(self, ReferenceCartParameters)

    def _on_odom(self, message: bytes) -> None:
        valid = self._validator.validate('odom', message, self._read, self._policy)
        if valid is None:
            return
        if valid.decision is StampDecision.HOLD:
            self._started = self._started or time.monotonic()
            return
        if valid.decision is StampDecision.START and self._policy.accepted is not None:
            self.get_logger().info('a new run')
        self._policy.accept(valid.stamp)
        self._publish(valid.stamp, valid.stamp / 1e9)
        if valid.decision is not StampDecision.AGAIN:
            self._diagnostics.note_step()

    def _tick(self) -> None:
        """On the wall clock, the curve's time starts at the first odometry."""
        if self._started is not None:
            self._publish(self.get_clock().now().nanoseconds, time.monotonic() - self._started)
            self._diagnostics.note_step()

    def _publish(self, stamp: int, time: float) -> None:
        reference = reference_at(self._curve, time, self._placement)
        self._reference.publish(self._write(stamp, reference.pose, reference.velocity))

    def close(self) -> None:
        """End when the last messages have arrived."""
        self._diagnostics.end()
        flush(self._reference)
