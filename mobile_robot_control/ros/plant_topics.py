"""What the plant says: odometry and joint states, and what follows from odometry."""

from nav_msgs.msg import Odometry
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from mobile_robot_control.configuration import PlantParameters
from mobile_robot_control.model.dynamics import PlantState
from mobile_robot_control.model.kinematics import wheel_velocity
from mobile_robot_control.quantities import WheelTorque
from mobile_robot_control.ros import messages
from mobile_robot_control.ros.qos import LOOP, flush
from mobile_robot_control.ros.transforms import make_broadcaster


class PlantTopics:
    """
    Publishes the plant's state.

    Parameters
    ----------
    node : Node
        The plant's.
    values : PlantParameters
        What it was started with.

    """

    def __init__(self, node: Node, values: PlantParameters) -> None:
        shared = values.shared
        self._robot = shared.robot
        self._message = messages.odometry_message(shared.odom_frame_id, shared.base_frame_id)
        self._message.pose.covariance[::7] = values.pose_covariance_diagonal
        self._message.twist.covariance[::7] = values.twist_covariance_diagonal
        self._odom = node.create_publisher(Odometry, 'odom', LOOP)
        self._joint_states = node.create_publisher(JointState, 'joint_states', LOOP)
        publish_clock = values.publish_clock and shared.lockstep
        self._clock = node.create_publisher(Clock, '/clock', LOOP) if publish_clock else None
        self._broadcast = make_broadcaster(node) if values.publish_tf else None

    def publish_odometry(self, stamp: int, state: PlantState) -> None:
        """
        Say where the robot is.

        Parameters
        ----------
        stamp : int
            [ns].
        state : PlantState
            At that time.

        """
        messages.fill_odometry(self._message, stamp, state.pose, state.velocity)
        self.repeat_odometry()

    def repeat_odometry(self) -> None:
        """Say the newest odometry, once more or for the first time."""
        self._odom.publish(self._message)
        if self._clock is not None:
            self._clock.publish(Clock(clock=self._message.header.stamp))
        if self._broadcast is not None:
            self._broadcast(self._message)

    def publish_joint_states(self, stamp: int, state: PlantState, applied: WheelTorque) -> None:
        """
        Say how the wheels turn.

        Parameters
        ----------
        stamp : int
            [ns].
        state : PlantState
            At that time.
        applied : WheelTorque
            Over the step that ended then [N m].

        """
        self._joint_states.publish(messages.joint_message(
            stamp, (state.right_angle, state.left_angle), wheel_velocity(state.velocity, self._robot), applied
        ))

    def flush(self) -> None:
        """Wait, not long, until every listener has what was published."""
        flush(self._odom, self._joint_states)
