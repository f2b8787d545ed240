"""The node `plant`: the simulated robot, from wheel torques to odometry."""

import math
import time

from nav_msgs.msg import Odometry
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from mobile_robot_control.configuration import PlantParameters, period_nanoseconds
from mobile_robot_control.model import dynamics
from mobile_robot_control.model.dynamics import saturate
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.quantities import Pose, WheelTorque
from mobile_robot_control.readings import Refused, nanoseconds, read_torque
from mobile_robot_control.ros import messages
from mobile_robot_control.ros.border import Border
from mobile_robot_control.ros.lockstep import Pace
from mobile_robot_control.ros.parameter_bridge import declare, follow
from mobile_robot_control.ros.peers import Witness
from mobile_robot_control.ros.qos import LOOP, NEWEST, flush
from mobile_robot_control.ros.transforms import make_broadcaster
from mobile_robot_control.ros.wall_clock import Ticker


class Plant(Node):
    """
    Steps the robot's dynamics and, in lockstep, simulated time.

    Attributes
    ----------
    exit_code : int or None
        0 after `duration`, 1 after the motion diverged, None before.

    """

    def __init__(self) -> None:
        super().__init__('plant')
        self._values = declare(self, PlantParameters)
        shared = self._values.shared
        self.exit_code: int | None = None
        self._period, self._position_period = map(period_nanoseconds, (shared.velocity_rate, shared.position_rate))
        self._steps = round(self._values.duration * shared.velocity_rate)
        self._sampled = dynamics.sample(shared.robot, 1.0 / shared.velocity_rate, self._values.centripetal_coupling)
        self._state = dynamics.at_rest(Pose(*self._values.initial_pose))
        self._applied = self._torque = WheelTorque(0.0, 0.0)
        self._torque_at = -math.inf
        self._now = self._stamp = 0  # simulated time, and what messages carry: the same in lockstep
        self._message = messages.odometry_message(shared.odom_frame_id, shared.base_frame_id)
        self._message.pose.covariance[::7] = self._values.pose_covariance_diagonal
        self._message.twist.covariance[::7] = self._values.twist_covariance_diagonal
        self._border = Border(self)
        self._witness = Witness(self, shared.peer_timeout)
        self._broadcast = make_broadcaster(self) if self._values.publish_tf else None
        self._odom = self.create_publisher(Odometry, 'odom', LOOP)
        self._joint_states = self.create_publisher(JointState, 'joint_states', LOOP)
        publish_clock = self._values.publish_clock and shared.lockstep
        self._clock_topic = self.create_publisher(Clock, '/clock', LOOP) if publish_clock else None
        self.create_subscription(JointState, 'wheel_torques', self._on_wheel_torques, NEWEST)
        follow(self, self._values, self._change)
        if shared.lockstep:
            self._pace = Pace(self, self._period, self._values.real_time_factor, self._publish, self._repeat)
            self._pace.ask()
        else:
            self._ticker = Ticker(self, shared.velocity_rate, self._tick)

    def _change(self, values: PlantParameters) -> None:
        self._values = values

    def _publish(self) -> None:
        """Say where the robot is; at position ticks odometry too."""
        if self._now % self._position_period == 0:
            messages.fill_odometry(self._message, self._stamp, self._state.pose, self._state.velocity)
            self._publish_odom()
        self._publish_joint_states()

    def _repeat(self, silence: float) -> None:
        """Say the newest of both again, whichever of the others missed it."""
        if not self._values.paused:
            self._witness.stalled(silence, self._now, self._now - self._now % self._position_period)
        self._publish_odom()
        self._publish_joint_states()

    def _publish_odom(self) -> None:
        self._odom.publish(self._message)
        if self._clock_topic is not None:
            self._clock_topic.publish(Clock(clock=self._message.header.stamp))
        if self._broadcast is not None:
            self._broadcast(self._message)

    def _publish_joint_states(self) -> None:
        state = self._state
        self._joint_states.publish(messages.joint_message(
            self._stamp, (state.right_angle, state.left_angle),
            wheel_velocity(state.velocity, self._sampled.robot), self._applied,
        ))

    def _on_wheel_torques(self, message: JointState) -> None:
        try:
            torque = read_torque(message)
        except Refused as reason:
            self._border.refuse('wheel_torques', reason)
            return
        if self._values.shared.lockstep:
            self._on_answer(nanoseconds(message.header.stamp), torque)
        else:
            self._torque, self._torque_at = torque, time.monotonic()

    def _on_answer(self, stamp: int, torque: WheelTorque) -> None:
        if stamp != self._now or not self._pace.asking:
            # an answer that was asked for twice comes twice
            if stamp > self._now or stamp % self._period:
                self._border.refuse('wheel_torques', 'not the present stamp')
            return
        if self._values.paused:
            return
        self._witness.progressed()
        if self._steps and self._now == self._steps * self._period:
            self.exit_code = 0
            return
        self._step(torque)
        if self.exit_code is None:
            self._stamp = self._now
            self._pace.ask()

    def _tick(self) -> None:
        """On the wall clock: step with the newest torque, or none when it is too old."""
        fresh = time.monotonic() - self._torque_at <= self._values.torque_timeout
        self._step(self._torque if fresh else WheelTorque(0.0, 0.0))
        if self.exit_code is None:
            self._stamp = self.get_clock().now().nanoseconds
            self._publish()
            if self._steps and self._now >= self._steps * self._period:
                self.exit_code = 0

    def _step(self, torque: WheelTorque) -> None:
        self._applied = saturate(torque, self._values.max_wheel_torque)
        self._state = dynamics.step(self._state, self._applied, self._sampled)
        self._now += self._period
        if dynamics.diverged(self._state):
            self.get_logger().fatal(
                f'the motion diverged at t = {self._now / 1e9:g} s: {self._state.pose}, {self._state.velocity}; '
                'lower the gains or raise the rates'
            )
            self.exit_code = 1

    def close(self) -> None:
        """End when the last messages have arrived."""
        flush(self._odom, self._joint_states)
