"""
A position controller written from docs/lockstep.md alone: it imports nothing of mobile_robot_control.

Run as a process: ``python foreign_position_controller.py [--ros-args ...]``. Backstepping, Eq. (25), behind a rate
limiter. The limiter has a state, the command before, so that a step too many or too few shows in the command.
"""

import math
import signal
from collections import Counter

import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions

PERIOD = 10_000_000  # [ns]: position_rate is 100 Hz
P, Q, ALPHA, F, G = 1.646, 0.243115, 1.0, 1.26767, 10.1146
LINEAR_ACCELERATION = 1.0  # [m/s²]
LARGEST = 1e12
FRAME, ROBOT, CART = 'odom', 'base_link', 'reference_cart'
PUBLISHED = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)
SUBSCRIBED = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)


def decide(stamp, accepted, period):
    """Return what a stamp [ns] means to a node whose last step had the stamp `accepted`, None before the first."""
    if stamp < 0 or stamp % period != 0:
        return 'REFUSED'
    if stamp == accepted:
        return 'AGAIN'
    if stamp == 0:
        return 'START'
    if accepted is None:
        return 'JOIN'
    return 'STEP' if stamp == accepted + period else 'REFUSED'


def read(message, child_frame):
    """Return (x, y, heading, linear, angular) of an Odometry; raise ValueError where it is refused."""
    if message.header.frame_id != FRAME or message.child_frame_id != child_frame:
        raise ValueError('wrong frame')
    position, q = message.pose.pose.position, message.pose.pose.orientation
    linear, angular = message.twist.twist.linear.x, message.twist.twist.angular.z
    # NaN is not less than or equal to anything
    if not all(abs(value) <= LARGEST for value in (position.x, position.y, q.x, q.y, q.z, q.w, linear, angular)):
        raise ValueError('not finite or too large')
    if abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) > 0.01:
        raise ValueError('quaternion not of unit length')
    heading = math.atan2(2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z)
    return position.x, position.y, heading, linear, angular


def tracking_error(pose, reference):
    """Return reference minus pose in the robot's frame: e1, e2 [m], e3 [rad] in (-pi, pi]."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    dx, dy, turn = reference[0] - pose[0], reference[1] - pose[1], (reference[2] - pose[2]) % (2.0 * math.pi)
    return cos * dx + sin * dy, -sin * dx + cos * dy, turn if turn <= math.pi else turn - 2.0 * math.pi


def law(before, error, reference):
    """Return the command (v [m/s], omega [rad/s]); `before` is the one of the step before."""
    (e1, e2, e3), (v_r, omega_r) = error, reference[3:]
    # Eq. (25): v = v_r cos e3 + α p f e1, ω = ω_r + (2 α p / q) (e1² + e2²)^(α-1) v_r e2 + q g sin e3
    v = v_r * math.cos(e3) + ALPHA * P * F * e1
    power = min(e1 * e1 + e2 * e2, 1e30) ** (ALPHA - 1.0)
    omega = omega_r + 2.0 * ALPHA * P / Q * power * v_r * e2 + Q * G * math.sin(e3)
    change = LINEAR_ACCELERATION * PERIOD / 1e9
    v = min(max(v, before[0] - change), before[0] + change)
    return tuple(min(max(value, -LARGEST), LARGEST) for value in (v, omega))


class ForeignPositionController(Node):
    """Answers each pair of odom and reference with cmd_vel and tracking_error of the same stamp."""

    def __init__(self):
        super().__init__('foreign_position_controller')
        self.accepted = self.odom = self.reference = self.answer = self.again = None
        self.refused = Counter()
        self.cmd_vel = self.create_publisher(TwistStamped, 'cmd_vel', PUBLISHED)
        self.error = self.create_publisher(Vector3Stamped, 'tracking_error', PUBLISHED)
        self.create_subscription(Odometry, 'odom', self.on_odom, SUBSCRIBED)
        self.create_subscription(Odometry, 'reference', self.on_reference, SUBSCRIBED)

    def take(self, message, child_frame):
        """Return stamp, decision and content of a message; None where it is refused."""
        stamp = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        decision = decide(stamp, self.accepted, PERIOD)
        try:
            if decision == 'REFUSED':
                raise ValueError('wrong stamp')
            return stamp, decision, read(message, child_frame)
        except ValueError as refusal:
            self.refused[str(refusal)] += 1
            return None

    def on_odom(self, message):
        taken = self.take(message, ROBOT)
        if taken is None:
            return
        stamp, decision, pose = taken
        if decision == 'AGAIN':
            # a plant that was started again asks stamp 0, too: the reference must come again
            self.again = pose
            if stamp > 0:
                self.publish()
            return
        self.odom = stamp, pose
        self.answer_pair()

    def on_reference(self, message):
        taken = self.take(message, CART)
        if taken is None:
            return
        if taken[1] == 'AGAIN':
            if taken[0] == 0 and self.again is not None:
                self.answer_again(self.again, taken[2])
            return
        self.reference = taken[0], taken[2]
        self.answer_pair()

    def answer_again(self, odom, reference):
        """Repeat the answer to stamp 0, or begin a new run where an input has other numbers."""
        self.again = None
        if (odom, reference) == (self.odom[1], self.reference[1]):
            self.publish()
        else:
            self.accepted, self.odom, self.reference = None, (0, odom), (0, reference)
            self.answer_pair()

    def answer_pair(self):
        """Step and answer once both messages of the same, new stamp are there."""
        if self.odom is None or self.reference is None or self.odom[0] != self.reference[0]:
            return
        stamp = self.odom[0]
        decision = decide(stamp, self.accepted, PERIOD)
        if decision in ('AGAIN', 'REFUSED'):
            return
        before = self.answer[1] if decision == 'STEP' else (0.0, 0.0)
        self.accepted = stamp
        error = tracking_error(self.odom[1], self.reference[1])
        self.answer = stamp, law(before, error, self.reference[1]), error
        self.publish()

    def publish(self):
        """Publish the last answer, for the first time or again."""
        stamp, command, error = self.answer
        twist, vector = TwistStamped(), Vector3Stamped()
        for message in (twist, vector):
            message.header.stamp = Time(sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000)
            message.header.frame_id = ROBOT
        twist.twist.linear.x, twist.twist.angular.z = command
        vector.vector.x, vector.vector.y, vector.vector.z = error
        self.cmd_vel.publish(twist)
        self.error.publish(vector)


def main():
    """Run until SIGINT or SIGTERM: the node leaves DDS, so that nothing waits for it."""
    stopped = []
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.append(True))
    node = ForeignPositionController()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    while not stopped:
        executor.spin_once(timeout_sec=0.1)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == '__main__':
    main()
