"""A run as a table: one row a step of the velocity loop, columns named as the topics' fields."""

import csv
import math
from collections.abc import Iterable, Iterator
from typing import TextIO

from mobile_robot_control.quantities import BodyVelocity, Pose
from mobile_robot_control.readings import WHEEL_JOINTS
from mobile_robot_control.simulation.closed_loop import Sample

_ODOMETRY = (
    'pose.pose.position.x', 'pose.pose.position.y', 'pose.pose.orientation.z', 'pose.pose.orientation.w',
    'twist.twist.linear.x', 'twist.twist.angular.z',
)

COLUMNS = (
    'time',
    *(f'joint_states.{field}.{wheel}' for field in ('position', 'velocity', 'effort') for wheel in WHEEL_JOINTS),
    *(f'wheel_torques.effort.{wheel}' for wheel in WHEEL_JOINTS),
    'odom.header.stamp',
    *(f'odom.{field}' for field in _ODOMETRY),
    *(f'reference.{field}' for field in _ODOMETRY),
    'cmd_vel.twist.linear.x', 'cmd_vel.twist.angular.z',
    'tracking_error.vector.x', 'tracking_error.vector.y', 'tracking_error.vector.z',
)
"""
Time and stamp in s, everything else in SI units as in the topics. The columns of the position loop (from
`odom.header.stamp` on) hold what was said at the newest position tick.
"""


def _odometry(pose: Pose, velocity: BodyVelocity) -> tuple[float, ...]:
    return (pose.x, pose.y, math.sin(0.5 * pose.heading), math.cos(0.5 * pose.heading), *velocity)


def row(sample: Sample) -> tuple[float, ...]:
    """
    Give a sample as a row.

    Parameters
    ----------
    sample : Sample
        Of one time of the velocity grid.

    Returns
    -------
    tuple of float
        As many as COLUMNS.

    """
    tick = sample.tick
    return (
        sample.time,
        sample.right_angle, sample.left_angle, *sample.wheels, *sample.applied, *sample.torque,
        tick.time,
        *_odometry(tick.pose, tick.velocity),
        *_odometry(tick.reference.pose, tick.reference.velocity),
        *sample.command,
        *tick.error,
    )


def write(samples: Iterable[Sample], file: TextIO) -> Iterator[Sample]:
    """
    Write samples as CSV on their way to somebody else.

    Parameters
    ----------
    samples : iterable of Sample
        In order of time.
    file : text file
        Open for writing.

    Yields
    ------
    Sample
        The same. Numbers are written so that they read back to the last bit.

    """
    writer = csv.writer(file, lineterminator='\n')
    writer.writerow(COLUMNS)
    for sample in samples:
        writer.writerow(map(repr, row(sample)))
        yield sample
