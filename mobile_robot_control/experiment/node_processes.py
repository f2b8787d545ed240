"""Nodes as child processes."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from mobile_robot_control.plugins import plugin_environment
from mobile_robot_control.ros.services.environment import ros_home

START = 30.0
"""[s] of wall time for nodes to start."""
_GRACE = 10.0
"""[s] for a process to end by itself."""


class NodeProcess:
    """
    One or several nodes in their own process.

    Parameters
    ----------
    names : sequence of str
        Node names.
    arguments : sequence of str
        ROS arguments.
    log : Path
        File for their output.

    Attributes
    ----------
    name : str
        The node names, joined.

    """

    def __init__(self, names: Sequence[str], arguments: Sequence[str], log: Path) -> None:
        self.name = ', '.join(names)
        self._log = log
        with log.open('wb') as file:
            self._process = subprocess.Popen(  # noqa: S603 (our own module)
                [sys.executable, '-m', 'mobile_robot_control.ros.executables', *names, *arguments],
                stdin=subprocess.PIPE, stdout=file, stderr=subprocess.STDOUT, start_new_session=True,
                # a stop of an earlier simulated robot does not hold
                env={'ROS_LOG_DIR': f'{ros_home()}/log'} | os.environ | plugin_environment() | {
                    'ROS_HOME': str(log.parent.resolve())},
            )

    @property
    def pid(self) -> int:
        """Process number."""
        return self._process.pid

    def exit_code(self) -> int | None:
        """Return the exit code, negative for a signal's number; None while it runs."""
        return self._process.poll()

    def signal(self, number: int) -> None:
        """Send a signal such as SIGINT; a process that has ended is left alone."""
        self._process.send_signal(number)

    def kill(self) -> None:
        """Kill the process, as `kill -9` does, and wait until it has ended."""
        self._process.kill()
        self._process.wait()

    def wait_or_kill(self, seconds: float) -> None:
        """Wait until the process has ended; kill it after so many seconds."""
        try:
            self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.kill()

    def close_input(self) -> None:
        """Close the standard input; nodes that follow their parent then end."""
        if self._process.stdin is not None:
            self._process.stdin.close()

    def exit_report(self) -> str:
        """Describe the end of the process, with the last lines of its output."""
        code = self.exit_code()
        if code is None:
            how = 'still runs'
        elif code < 0:
            how = f'was killed by {signal.Signals(-code).name}'
        else:
            how = f'ended with exit code {code}'
        last = self._log.read_text(encoding='utf-8', errors='replace').strip().splitlines()[-8:]
        return '\n'.join([f'{self.name} {how}', *(f'    {line}' for line in last)])


def stop_processes(processes: Sequence[NodeProcess]) -> None:
    """Stop processes by SIGINT; kill those that do not end in time."""
    for process in processes:
        process.signal(signal.SIGINT)
        process.signal(signal.SIGCONT)
    deadline = time.monotonic() + _GRACE
    for process in processes:
        process.wait_or_kill(max(0.0, deadline - time.monotonic()))
        process.close_input()
