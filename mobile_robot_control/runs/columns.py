"""The columns of each topic of a run, and the conversion of its messages to them."""

import math
from collections.abc import Callable
from typing import Any

from mobile_robot_control.messages.parsing import (
    read_error,
    read_odometry,
    read_torque,
    read_twist,
    read_wheel_angles,
    read_wheel_velocity,
)
from mobile_robot_control.topics import GROUND_TRUTH, RUN_TOPICS

TRUE_ERROR = 'true_error'
COLUMNS = {**{name: topic.columns for name, topic in RUN_TOPICS.items()},
           TRUE_ERROR: RUN_TOPICS['tracking_error'].columns}
"""The topics of a run; and the true error, if it differs from `tracking_error`, which no topic carries."""
_UNKNOWN = (math.nan, math.nan)


def _odometry(message: Any) -> tuple[float, ...]:
    pose, velocity = read_odometry(message)
    return (*pose, *velocity)


def _joints(message: Any) -> tuple[float, ...]:
    """Return the columns of joint states; for a base without efforts, they are nan."""
    efforts = read_torque(message) if len(message.effort) else _UNKNOWN
    return (*read_wheel_angles(message), *read_wheel_velocity(message), *efforts)


READ: dict[str, Callable[[Any], tuple[float, ...]]] = {
    'joint_states': _joints, 'wheel_torques': read_torque, 'odom': _odometry, 'reference': _odometry,
    'cmd_vel': read_twist, 'tracking_error': read_error, GROUND_TRUTH: _odometry,
}
"""Reads a message of each topic into its COLUMNS."""
