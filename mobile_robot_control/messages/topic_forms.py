"""
The form of each topic's messages: how they are read, and written, by the topic's name.

A topic without an entry has the form of its type: odometry, or numbers in the fields of its row.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from mobile_robot_control.messages.parsing import (
    numbers_reader,
    read_horizon,
    read_odometry,
    read_time,
    read_torque,
    read_twist,
    read_wheel_angles,
    read_wheel_velocity,
)
from mobile_robot_control.quantities import BodyAcceleration, TrackingError
from mobile_robot_control.topics import TOPICS

_ODOMETRY = 'nav_msgs/msg/Odometry'
_UNKNOWN = (float('nan'),) * 2


class Conventions(NamedTuple):
    """
    Conventions of the nodes of a loop.

    Attributes
    ----------
    odom, base, reference : str
        Frames of poses, of the robot and of the cart; '' allows any.
    ticks, period : int
        Points of `reference_horizon` after the present one, and the time between two [ns].
    stamped : bool
        Whether commands have a stamp.

    """

    odom: str = ''
    base: str = ''
    reference: str = ''
    ticks: int = 0
    period: int = 0
    stamped: bool = True


ANY = Conventions()


def reader(topic: str, conventions: Conventions = ANY) -> Callable[[Any], Any]:
    """Return a function that reads a topic's message into the quantity that nodes take."""
    odom, base, reference, ticks, period, _ = conventions
    kind, fields = TOPICS[topic].kind, TOPICS[topic].fields
    readers: dict[str, Callable[[Any], Any]] = {
        'joint_states': read_wheel_velocity,
        'wheel_torques': read_torque,
        'odom': partial(read_odometry, frame=odom, child_frame=base),
        'odom_time': read_time,
        'reference': partial(read_odometry, frame=odom, child_frame=reference),
        'reference_horizon': partial(
            read_horizon, ticks=ticks, period=period, frame=odom, child_frame=reference),
        'cmd_vel': partial(read_twist, frame=base),
        'cmd_accel': numbers_reader('acceleration', fields, BodyAcceleration, base),
        'tracking_error': numbers_reader('tracking error', fields, TrackingError),
    }
    return readers.get(topic) or (read_odometry if kind == _ODOMETRY else numbers_reader(topic, fields))


def columns_reader(topic: str) -> Callable[[Any], tuple[float, ...]]:
    """Return a function that reads a topic's message, in any frame, into the topic's columns."""
    if topic == 'joint_states':
        return _wheels
    return _motion if TOPICS[topic].kind == _ODOMETRY else reader(topic)


def _motion(message: object) -> tuple[float, ...]:
    pose, velocity = read_odometry(message)
    return (*pose, *velocity)


def _wheels(message: Any) -> tuple[float, ...]:
    """Return the columns of joint states; for a base without efforts, they are nan."""
    efforts = read_torque(message) if len(message.effort) else _UNKNOWN
    return (*read_wheel_angles(message), *read_wheel_velocity(message), *efforts)


def writer(topic: str, conventions: Conventions = ANY) -> Callable[[int, Any], bytes]:
    """
    Return a function that writes a stamp [ns] and a quantity as a topic's message.

    The quantity is that of `reader`; for `joint_states` angles, velocities and torques of the wheels.
    """
    # imported late: runs are read without the messages of ROS
    from mobile_robot_control.messages import writing  # noqa: PLC0415

    odom, base, reference, ticks, period, stamped = conventions

    def spread(write: Callable[..., bytes], count: int) -> Callable[[int, Any], bytes]:
        # a Reference also has its acceleration, which `reference_horizon` carries
        return lambda stamp, value: write(stamp, *value[:count])

    writers: dict[str, Callable[[], Callable[[int, Any], bytes]]] = {
        'joint_states': lambda: spread(writing.joints_writer(), 3),
        'wheel_torques': writing.torque_writer,
        'odom_time': writing.time_writer,
        'reference': lambda: spread(writing.odometry_writer(odom, reference), 2),
        'reference_horizon': lambda: writing.horizon_writer(odom, reference, ticks, period),
        'cmd_vel': lambda: writing.twist_writer(base, stamped),
    }
    if topic in writers:
        return writers[topic]()
    row = TOPICS[topic]
    return (spread(writing.odometry_writer(odom, base), 2) if row.kind == _ODOMETRY
            else writing.numbers_writer(row.kind, row.fields, base))
