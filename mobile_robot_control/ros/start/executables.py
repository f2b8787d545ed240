"""The executables of the four nodes: signals are caught before anything slow is imported."""

import sys
from collections.abc import Sequence

from mobile_robot_control.parameters.declaration import ParameterError
from mobile_robot_control.ros.shared.process import LOAD_ERRORS, Stop, check_environment, load_fault, refuse
from mobile_robot_control.ros.start.loaded import load
from mobile_robot_control.system.process import prepare_streams


def run_nodes(
    names: Sequence[str], arguments: Sequence[str], follow_parent: bool = False, own: object = None
) -> int:
    """
    Run nodes in this process until one is done or a stop is requested.

    Parameters
    ----------
    names : sequence of str
        Node names.
    arguments : sequence of str
        ROS arguments, such as ``--ros-args --params-file FILE``.
    follow_parent : bool
        Whether to stop when the standard input closes.
    own : OwnNode or None
        Run this node instead of the four.

    Returns
    -------
    int
        Exit code: 0 done or stopped, 1 the run failed, 2 refused configuration.

    """
    stop = Stop()
    prepare_streams()
    if follow_parent:
        stop.follow_parent()
    try:
        # importing rclpy with an RMW that is not installed would end the process
        check_environment()
    except ParameterError as error:
        return refuse(' '.join(names), error.violations)
    try:
        spin = load('spin')
    except LOAD_ERRORS as error:
        refuse(' '.join(names), [load_fault(error)])
        return 1
    code: int = spin(names, arguments, stop, own)
    return code


if __name__ == '__main__':
    divide = sys.argv.index('--ros-args') if '--ros-args' in sys.argv else len(sys.argv)
    sys.exit(run_nodes(sys.argv[1:divide], sys.argv[divide:], follow_parent=True))
