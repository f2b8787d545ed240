"""The loop's messages, made once and of the same size as a robot's: only their stamps change."""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from mobile_robot_control.quantities import BodyVelocity, Pose, TrackingError, WheelTorque, WheelVelocity
from mobile_robot_control.ros import messages

_VELOCITY, _POSE, _TORQUE = BodyVelocity(0.4, 0.2), Pose(0.9, 0.1, 1.2), WheelTorque(0.3, 0.2)

ODOM = messages.fill_odometry(messages.odometry_message('odom', 'base_link'), 0, _POSE, _VELOCITY)
REFERENCE = messages.fill_odometry(messages.odometry_message('odom', 'reference_cart'), 0, _POSE, _VELOCITY)
CMD_VEL = messages.fill_twist(messages.twist_message('base_link'), 0, _VELOCITY)
TRACKING_ERROR = messages.fill_error(messages.error_message('base_link'), 0, TrackingError(0.01, 0.02, 0.03))
WHEEL_TORQUES = messages.fill_torque(messages.wheels_message(), 0, _TORQUE)
JOINT_STATES = messages.fill_joints(messages.wheels_message(), 0, (1.0, 2.0), WheelVelocity(11.0, 12.0), _TORQUE)

MESSAGES = {'odom': ODOM, 'reference': REFERENCE, 'cmd_vel': CMD_VEL, 'tracking_error': TRACKING_ERROR,
            'wheel_torques': WHEEL_TORQUES, 'joint_states': JOINT_STATES}

DIAGNOSTICS = DiagnosticArray(status=[DiagnosticStatus(
    name='plant', message='running', values=[KeyValue(key=f'number {n} [s]', value='0.001234') for n in range(12)],
)])
