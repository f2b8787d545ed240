"""The loop's messages, made once and of the same size as a robot's: only their stamps change."""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import TwistStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from mobile_robot_control.messages import writing
from mobile_robot_control.messages.topic_forms import Conventions, writer
from mobile_robot_control.quantities import BodyVelocity, Pose, WheelTorque, WheelVelocity

_VELOCITY, _POSE, _TORQUE = BodyVelocity(0.4, 0.2), Pose(0.9, 0.1, 1.2), WheelTorque(0.3, 0.2)

ODOM = deserialize_message(
    writing.odometry_writer('odom', 'base_link')(0, _POSE, _VELOCITY), Odometry)
REFERENCE = deserialize_message(
    writing.odometry_writer('odom', 'reference_cart')(0, _POSE, _VELOCITY), Odometry)
CMD_VEL = deserialize_message(writing.twist_writer('base_link')(0, _VELOCITY), TwistStamped)
TRACKING_ERROR = deserialize_message(
    writer('tracking_error', Conventions(base='base_link'))(0, (0.01, 0.02, 0.03)), Vector3Stamped)
WHEEL_TORQUES = deserialize_message(writing.torque_writer()(0, _TORQUE), JointState)
JOINT_STATES = deserialize_message(
    writing.joints_writer()(0, (1.0, 2.0), WheelVelocity(11.0, 12.0), _TORQUE), JointState)

MESSAGES = {'odom': ODOM, 'reference': REFERENCE, 'cmd_vel': CMD_VEL, 'tracking_error': TRACKING_ERROR,
            'wheel_torques': WHEEL_TORQUES, 'joint_states': JOINT_STATES}

DIAGNOSTICS = DiagnosticArray(status=[DiagnosticStatus(
    name='plant', message='running', values=[KeyValue(key=f'number {n} [s]', value='0.001234') for n in range(12)],
)])
