"""A push, from its message."""

from typing import Any

from mobile_robot_control.messages.parsing import RefusedMessageError, check_frame, check_numbers
from mobile_robot_control.quantities import Push


def read_wrench(message: Any, frame: str = '') -> Push:
    """
    Return the push [N], [N m] of a geometry_msgs/WrenchStamped: force.x and torque.z.

    `frame` is the robot's, '' allows any; a message without a frame is in it. Raises RefusedMessageError if a number is
    not finite or beyond LARGEST, another component is not zero, or the frame is wrong.
    """
    if message.header.frame_id:
        check_frame('frame_id', message.header.frame_id, frame)
    force, torque = message.wrench.force, message.wrench.torque
    check_numbers('wrench', force.x, force.y, force.z, torque.x, torque.y, torque.z)
    for name, value in (('force.y', force.y), ('force.z', force.z), ('torque.x', torque.x), ('torque.y', torque.y)):
        if value != 0.0:
            raise RefusedMessageError(f'{name} is not zero', f'it is {value:g}; a robot on wheels is pushed by force.x '
                                      'and torque.z in its own frame alone')
    return Push(force.x, torque.z)
