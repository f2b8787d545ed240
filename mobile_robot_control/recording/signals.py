"""The loop's topics of a run as plain arrays by stamp, whatever the run was read from."""

from array import array
from collections.abc import Callable
from typing import Any, NamedTuple

from mobile_robot_control.messages.parsing import (
    read_error,
    read_odometry,
    read_torque,
    read_twist,
    read_wheel_angles,
    read_wheel_velocity,
)

_WALL = 10**15
"""[ns]: eleven days; later stamps are those of a wall clock, not of a run."""


def _odometry(message: Any) -> tuple[float, ...]:
    pose, velocity = read_odometry(message)
    return (*pose, *velocity)


def _joints(message: Any) -> tuple[float, ...]:
    return (*read_wheel_angles(message), *read_wheel_velocity(message), *read_torque(message))


READ: dict[str, Callable[[Any], tuple[float, ...]]] = {
    'joint_states': _joints, 'wheel_torques': read_torque, 'odom': _odometry, 'reference': _odometry,
    'cmd_vel': read_twist, 'tracking_error': read_error,
}
"""Reads a message of each loop topic into the columns of LOOP_TOPICS."""


class Signal(NamedTuple):
    """
    One topic of a run, repeats removed.

    Attributes
    ----------
    stamps : array of int
        Ascending [ns].
    received : array of int
        Wall time of the first receipt [ns]; empty where the run was not recorded over DDS.
    values : array of float
        Row by row, for each stamp as many as the topic has columns.
    """

    stamps: 'array[int]'
    received: 'array[int]'
    values: 'array[float]'


def origin(signals: dict[str, Signal]) -> int:
    """
    Return the stamp [ns] that a run's time is counted from.

    It is 0 in lockstep; on the wall clock it is the first stamp of ``reference``, when the curve begins.
    """
    first = {topic: signal.stamps[0] for topic, signal in signals.items() if signal.stamps}
    begun = first.get('reference', min(first.values(), default=0))
    return begun if begun > _WALL else 0
