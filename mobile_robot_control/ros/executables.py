"""The executables of the four nodes: signals are caught before anything slow is imported."""

import os
import signal
import sys
import threading
from collections.abc import Sequence
from types import FrameType


class Stop:
    """
    A request to end, made by SIGINT or SIGTERM.

    Attributes
    ----------
    requested : bool
        Whether a signal has come.

    """

    def __init__(self) -> None:
        self.requested = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._request)

    def follow_parent(self) -> None:
        """Stop as well when whoever started this process has gone: its end of the standard input closes."""

        def wait() -> None:
            while os.read(sys.stdin.fileno(), 1):
                pass
            self.requested = True

        threading.Thread(target=wait, daemon=True).start()

    def _request(self, _number: int, _frame: FrameType | None) -> None:
        self.requested = True


def run(names: Sequence[str], arguments: Sequence[str], follow_parent: bool = False) -> int:
    """
    Run nodes in this process until they are done or told to stop.

    Parameters
    ----------
    names : sequence of str
        Node names.
    arguments : sequence of str
        ROS arguments, such as ``--ros-args --params-file FILE``.
    follow_parent : bool
        Whether to stop when the standard input closes.

    Returns
    -------
    int
        Exit code: 0 done or stopped, 1 the run failed, 2 refused configuration.

    """
    stop = Stop()
    if follow_parent:
        stop.follow_parent()
    from mobile_robot_control.ros.spin import spin  # noqa: PLC0415 (after the signals are caught)

    return spin(names, arguments, stop)


def plant() -> int:
    """Run the node `plant`."""
    return run(['plant'], sys.argv[1:])


def velocity_controller() -> int:
    """Run the node `velocity_controller`."""
    return run(['velocity_controller'], sys.argv[1:])


def position_controller() -> int:
    """Run the node `position_controller`."""
    return run(['position_controller'], sys.argv[1:])


def reference_cart() -> int:
    """Run the node `reference_cart`."""
    return run(['reference_cart'], sys.argv[1:])


if __name__ == '__main__':
    divide = sys.argv.index('--ros-args') if '--ros-args' in sys.argv else len(sys.argv)
    sys.exit(run(sys.argv[1:divide], sys.argv[divide:], follow_parent=True))
