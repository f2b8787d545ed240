"""The conversion of each loop topic's messages, shared by all nodes; and `cmd_vel` as a plain Twist."""

from collections.abc import Callable
from functools import partial
from typing import Any

from mobile_robot_control.messages import parsing, writing
from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import read_plain_twist
from mobile_robot_control.quantities import period_nanoseconds
from mobile_robot_control.ros.inputs import InputValidator
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.topics import ALL_LOOP_TOPICS


def bytes_reader(kind: str, *steps: Callable[[Any], Any]) -> Callable[[bytes], Any]:
    """
    Return a function that reads a message from its bytes, without an rclpy object.

    Parameters
    ----------
    kind : str
        Type of the message, such as 'nav_msgs/msg/Odometry'.
    *steps : callable
        Read its content, each from the result of the previous one; may raise RefusedMessageError.

    Returns
    -------
    callable
        Takes bytes; also raises RefusedMessageError if they are no such message.

    """
    return partial(parsing.read_or_refuse, kind, (partial(deserialise, kind), *steps))


def reader(topic: str, shared: Shared) -> Callable[[bytes], Any]:
    """Return a function that reads the bytes of a loop topic's message; frames and horizon are those of `shared`."""
    period = period_nanoseconds(shared.position_rate)
    readers: dict[str, Callable[[Any], Any]] = {
        'odom': partial(parsing.read_odometry, frame=shared.odom_frame_id, child_frame=shared.base_frame_id),
        'odom_time': parsing.read_time,
        'joint_states': parsing.read_wheel_velocity,
        'wheel_torques': parsing.read_torque,
        'reference': partial(
            parsing.read_odometry, frame=shared.odom_frame_id, child_frame=shared.reference_frame_id),
        'reference_horizon': partial(
            parsing.read_horizon, ticks=shared.reference_horizon, period=period, frame=shared.odom_frame_id,
            child_frame=shared.reference_frame_id),
        'cmd_vel': partial(parsing.read_twist, frame=shared.base_frame_id),
        'cmd_accel': partial(parsing.read_acceleration, frame=shared.base_frame_id),
        'tracking_error': parsing.read_error,
    }
    return bytes_reader(ALL_LOOP_TOPICS[topic].kind, readers[topic])


def writer(topic: str, shared: Shared) -> Callable[[int, Any], bytes]:
    """Return a function that writes a stamp [ns] and a result of `reader` as a message of a loop topic."""
    write = _WRITERS[topic](shared)
    # a Reference also has its acceleration, which `reference_horizon` carries
    return (lambda stamp, value: write(stamp, value[0], value[1])) if topic in ('odom', 'reference') else write


_WRITERS: dict[str, Callable[[Shared], Callable[..., bytes]]] = {
    'odom': lambda shared: writing.odometry_writer(shared.odom_frame_id, shared.base_frame_id),
    'reference': lambda shared: writing.odometry_writer(shared.odom_frame_id, shared.reference_frame_id),
    'reference_horizon': lambda shared: writing.horizon_writer(
        shared.odom_frame_id, shared.reference_frame_id, shared.reference_horizon,
        period_nanoseconds(shared.position_rate)),
    'wheel_torques': lambda _: writing.torque_writer(),
    'cmd_vel': lambda shared: writing.twist_writer(shared.base_frame_id, shared.stamped_cmd_vel),
    'cmd_accel': lambda shared: writing.acceleration_writer(shared.base_frame_id),
    'tracking_error': lambda shared: writing.error_writer(shared.base_frame_id),
}


PLAIN = 'geometry_msgs/msg/Twist'
_READ = bytes_reader(PLAIN, read_plain_twist)


def stamped_on_receipt(
    validator: InputValidator, now: Callable[[], int], take: Callable[[bytes], None]
) -> Callable[[bytes], None]:
    """
    Make a callback for plain Twists; they are stamped on receipt.

    Parameters
    ----------
    validator : InputValidator
        Counts unreadable messages.
    now : callable
        Returns the present stamp [ns].
    take : callable
        Takes the bytes of a TwistStamped.

    """
    stamp = writing.twist_writer('')

    def receive(message: bytes) -> None:
        velocity = validator.read('cmd_vel', message, _READ)
        if velocity is not None:
            take(stamp(now(), velocity))

    return receive
