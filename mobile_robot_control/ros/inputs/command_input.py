"""The input `cmd_vel` as plain Twist, for `stamped_cmd_vel: false`."""

from collections.abc import Callable

from mobile_robot_control.messages import writing
from mobile_robot_control.messages.parsing import read_plain_twist
from mobile_robot_control.ros.inputs.conversions import bytes_reader
from mobile_robot_control.ros.inputs.input_validation import InputValidator

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
