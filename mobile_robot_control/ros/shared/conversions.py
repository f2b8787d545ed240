"""The conversion of each loop topic's messages, shared by all nodes; and `cmd_vel` as a plain Twist."""

from collections.abc import Callable
from functools import partial
from typing import Any

from mobile_robot_control.messages import parsing, topic_forms, writing
from mobile_robot_control.messages.cdr import deserialise
from mobile_robot_control.messages.parsing import read_plain_twist
from mobile_robot_control.messages.topic_forms import Conventions
from mobile_robot_control.quantities import period_nanoseconds
from mobile_robot_control.ros.shared.inputs import InputValidator
from mobile_robot_control.settings.shared import Shared
from mobile_robot_control.topics import ALL_LOOP_TOPICS, PLAIN_TWIST


def bytes_reader(kind: str, *steps: Callable[[Any], object]) -> Callable[[bytes], Any]:
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
    return bytes_reader(ALL_LOOP_TOPICS[topic].kind, topic_forms.reader(topic, _conventions(shared)))


def writer(topic: str, shared: Shared) -> Callable[[int, Any], bytes]:
    """Return a function that writes a stamp [ns] and a result of `reader` as a message of a topic."""
    return topic_forms.writer(topic, _conventions(shared))


def _conventions(shared: Shared) -> Conventions:
    return Conventions(
        shared.odom_frame_id, shared.base_frame_id, shared.reference_frame_id, shared.reference_horizon,
        period_nanoseconds(shared.position_rate), shared.stamped_cmd_vel)


_READ = bytes_reader(PLAIN_TWIST, read_plain_twist)


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
