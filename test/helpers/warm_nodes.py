"""
Nodes forked from a process that has imported them: a node starts without the time of its imports.

Where an environment variable differs that imports may read, such as PYTHONPATH, nodes are processes of their own.
"""

import contextlib
import multiprocessing
import os
import signal
import sys

from mobile_robot_control.experiment.node_processes import NodeProcess
from mobile_robot_control.parameters.plugins import plugin_environment
from mobile_robot_control.ros.start.loaded import LOADED

_FORKS = multiprocessing.get_context('forkserver')
_FORKS.set_forkserver_preload([name.partition(':')[0] for name in LOADED.values()])

_AT_THE_START = dict(os.environ)
_READ_LATER = ('ROS_', 'FASTDDS_', 'FASTRTPS_', 'PYTEST_')
"""Beginnings of variables that a node reads when it starts, not when it is imported."""


def _is_as_imported(environment):
    changed = dict(environment.items() ^ _AT_THE_START.items())
    return all(name.startswith(_READ_LATER) for name in changed)


def _run(names, arguments, log, environment, reading):
    """Be a node: what an executable is given, this process is given."""
    from mobile_robot_control.ros.start.executables import run_nodes

    os.setsid()
    os.dup2(reading.fileno(), 0)
    sys.stdin = os.fdopen(0, closefd=False)
    file = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for number in (1, 2):
        os.dup2(file, number)
    sys.stdout, sys.stderr = (os.fdopen(number, 'w', buffering=1, closefd=False) for number in (1, 2))
    os.environ.clear()
    os.environ.update(environment)
    sys.exit(run_nodes(names, arguments, follow_parent=True))


class _Forked:
    """What `NodeProcess` needs of a Popen."""

    def __init__(self, arguments):
        reading, self.stdin = _FORKS.Pipe(duplex=False)
        self._process = _FORKS.Process(target=_run, args=(*arguments, reading))
        self._process.start()
        reading.close()
        self.pid = self._process.pid

    def poll(self):
        return self._process.exitcode

    def wait(self, timeout=None):
        self._process.join(timeout)
        if self._process.exitcode is None:
            raise multiprocessing.TimeoutError
        return self._process.exitcode

    def send_signal(self, number):
        # the fork server waits for the process: it may be gone before its exit code is here
        with contextlib.suppress(ProcessLookupError):
            if self.poll() is None:
                os.kill(self.pid, number)

    def kill(self):
        self.send_signal(signal.SIGKILL)


class WarmNode(NodeProcess):
    """One or several nodes in a process of their own, forked."""

    def __init__(self, names, arguments, log):
        environment = os.environ | plugin_environment()
        if _is_as_imported(environment):
            self.name, self._log = ', '.join(names), log
            self._process = _Forked((names, arguments, log, environment))
        else:
            super().__init__(names, arguments, log)
