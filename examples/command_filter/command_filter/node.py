"""A low-pass filter between position controller and velocity controller."""

import sys
from typing import Annotated, NamedTuple

from mobile_robot_control import BodyVelocity, Field
from mobile_robot_control.elementary import expm1
from mobile_robot_control.ros.own_node import OwnNode, run


class Parameters(NamedTuple):
    """What `ros2 param set /command_filter` sets."""

    time_constant: Annotated[float, Field('s', 'of the filter: larger smooths more, and answers later',
                                          above=0.0, maximum=1.0, live=True)] = 0.05


def step(before, inputs, parameters, dt):
    """Return the filtered command, as the next state and as the output."""
    asked = inputs['cmd_vel_raw']
    share = -expm1(-dt / parameters.time_constant)
    command = BodyVelocity(*(old + share * (new - old) for old, new in zip(before, asked, strict=True)))
    return command, {'cmd_vel': command}


NODE = OwnNode('command_filter', step, inputs={'cmd_vel_raw': 'cmd_vel'}, outputs={'cmd_vel': 'cmd_vel'},
               parameters=Parameters, start=BodyVelocity(0.0, 0.0))


def main():
    """Run the node."""
    return run(NODE)


if __name__ == '__main__':
    sys.exit(main())
