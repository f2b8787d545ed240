"""
The ends of processes that hang in a library, most often DDS, where their Python code cannot notice it.

`Supervisor` watches a whole run, with its nodes, from another process: this file as a script, without imports from the
package. `exit_after` guards the last moment of a process, to keep its exit code. Until then `keep_node` saves a node
from garbage collection, in which its process would leave DDS.
"""

import contextlib
import glob
import os
import re
import select
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from typing import Any

LEAVING = 5
"""[s] for a process to leave DDS, which may hang if many processes end."""
_MONOTONIC, _IN_A_THREAD = 1, 2  # CLOCK_MONOTONIC, SIGEV_THREAD
_KEPT: list[Any] = []
_GRACE = 20.0
"""[s] for an experiment to end after a signal or by itself, nodes included."""
# the last are SIGHUP, SIGINT and SIGTERM, as in Python's wakeup fd
_MESSAGE = re.compile(rb'node (\d+)\n|(done)\n|([\x01\x02\x0f])')


class Supervisor:
    """
    Watches this process from another one, until closed; a context manager.

    Parameters
    ----------
    seconds : float
        Wall time without a call of `note_progress` after which this process and its nodes are killed.
    grace : float
        Wall time that this process has to end, or to note progress, after a signal to end [s].
    name : str
        Of the command, at the start of its error text.

    """

    def __init__(self, seconds: float, grace: float = _GRACE, name: str = 'experiment') -> None:
        self._seconds, self._grace, self._name = seconds, grace, name

    def __enter__(self) -> 'Supervisor':
        import subprocess  # noqa: PLC0415 (nodes import this module, and start sooner without)

        self._process = subprocess.Popen(  # noqa: S603 (our own module)
            [sys.executable, '-I', '-S', __file__, *map(str, (os.getpid(), self._seconds, self._grace)),
             self._name],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, start_new_session=True)
        assert self._process.stdin is not None  # noqa: S101 (for mypy: it is a pipe)
        self._pipe = self._process.stdin.fileno()
        os.set_blocking(self._pipe, False)
        # the interpreter writes a signal's number there at once, even if its own handler never runs
        self._wakeup = signal.set_wakeup_fd(self._pipe, warn_on_full_buffer=False)
        return self

    def note_progress(self) -> None:
        """Note progress: this process does not hang."""
        self._send(b'.')

    def note_node(self, pid: int) -> None:
        """Note a process to kill if this one ends without ending it."""
        self._send(b'node %d\n' % pid)

    def _send(self, message: bytes) -> None:
        # the pipe is full or closed: the supervisor is suspended or killed, and the run continues without it
        with contextlib.suppress(OSError):
            os.write(self._pipe, message)

    def __exit__(self, *_: object) -> None:
        signal.set_wakeup_fd(self._wakeup)
        self._send(b'done\n')
        assert self._process.stdin is not None  # noqa: S101 (as above)
        self._process.stdin.close()
        self._process.wait()


@contextlib.contextmanager
def exit_after(seconds: int, code: int) -> Iterator[None]:
    """
    End the process with an exit code if the block takes longer than so many seconds of wall time.

    Python's own threads and signal handlers would not do: a call that hangs in a library may hold the interpreter's
    lock. Only on Linux is anything ended.
    """
    import ctypes  # noqa: PLC0415 (the supervisor's own process does without)

    class Event(ctypes.Structure):
        """Linux's `struct sigevent`: call a C function with a value, in its own thread."""

        _fields_ = (('value', ctypes.c_void_p), ('signal', ctypes.c_int), ('notify', ctypes.c_int),
                    ('function', ctypes.c_void_p), ('attributes', ctypes.c_void_p), ('room', ctypes.c_char * 64))

    class Times(ctypes.Structure):
        """Its `struct itimerspec`."""

        _fields_ = tuple((name, ctypes.c_long) for name in ('again', 'again_ns', 'after', 'after_ns'))

    sys.stdout.flush()
    sys.stderr.flush()
    timer = ctypes.c_void_p()
    try:
        library = ctypes.CDLL(None)
        event = Event(value=code, notify=_IN_A_THREAD, function=ctypes.cast(library._exit, ctypes.c_void_p))
        has_timer = library.timer_create(_MONOTONIC, ctypes.byref(event), ctypes.byref(timer)) == 0
    except (AttributeError, TypeError):  # a system other than Linux, or an old one
        has_timer = False
    if not has_timer:
        yield
        return
    library.timer_settime(timer, 0, ctypes.byref(Times(after=seconds)), None)
    try:
        yield
    finally:
        library.timer_delete(timer)


def keep_node(node: object) -> None:
    """Keep a node until `shut_down`: collected as garbage, it could hang where nobody watches."""
    _KEPT.append(node)


def shut_down() -> None:
    """Destroy the nodes that were kept and shut rclpy down, which may hang."""
    while _KEPT:
        _KEPT.pop().destroy_node()
    sys.modules['rclpy'].try_shutdown()


def leave_dds(code: int) -> int:
    """Shut rclpy down if it was imported; return an exit code, or end the process with it if that hangs."""
    if sys.modules.get('rclpy') is not None:
        with exit_after(LEAVING, code):
            shut_down()
    return code


def group_runs(pid: int) -> bool:
    """Return whether a process of the group that began with a process is running; False on other systems than Linux."""
    for folder in glob.glob('/proc/[0-9]*'):
        state, _, group = (_status(int(folder.rpartition('/')[2])) or ['Z', '', ''])[:3]
        if group == str(pid) and state != 'Z':
            return True
    return False


def _signal_groups(pids: Sequence[int], number: int) -> None:
    """Send a signal to nodes and their children: each began a group."""
    for pid in pids:
        with contextlib.suppress(OSError):
            os.killpg(pid, number)


def _kill(nodes: Sequence[int], *others: int) -> None:
    """Kill nodes with their children, and other processes, and wait briefly for their end."""
    _signal_groups(nodes, signal.SIGKILL)
    for pid in (*others, *nodes):
        with contextlib.suppress(OSError):
            os.kill(pid, signal.SIGKILL)
    deadline = time.monotonic() + 1.0
    while any(map(_is_running, (*others, *nodes))) and time.monotonic() < deadline:
        time.sleep(0.01)


def _is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except OSError:
        return False
    return _state(pid) != 'Z'


def is_suspended(pid: int) -> bool:
    """Return whether a process is stopped by a signal or a debugger; False on other systems than Linux."""
    return _state(pid) in {'T', 't'}


def _state(pid: int) -> str:
    """Return a process's state in Linux: T or t stopped by a signal or a debugger, Z ended; '' on other systems."""
    return (_status(pid) or [''])[0]


def _status(pid: int) -> list[str]:
    """Return state, parent, group and more of a process in Linux; [] on other systems."""
    try:
        with open(f'/proc/{pid}/stat', encoding='utf-8', errors='replace') as file:
            return file.read().rpartition(')')[2].split()
    except OSError:
        return []


def _watch(watched: int, seconds: float, grace: float, name: str) -> None:
    """Watch a process: if it hangs, kill it and its nodes; kill nodes that outlast it."""
    # runs in its own process, from before the start of the nodes until the end of the run
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    nodes: list[int] = []
    rest, deadline = b'', time.monotonic() + seconds
    while True:
        # select accepts no timeout of years
        if not select.select([0], [], [], min(max(0.0, deadline - time.monotonic()), 3600.0))[0]:
            if time.monotonic() < deadline:
                continue
            if not is_suspended(watched):
                break
            # by Ctrl-Z or a debugger: it resumes later
            deadline = time.monotonic() + seconds
            continue
        received = os.read(0, 4096)
        if not received:
            # the process has ended; its nodes follow by themselves unless they hang, and those of somebody else may not
            _signal_groups(nodes, signal.SIGINT)
            deadline = time.monotonic() + grace
            while any(_is_running(node) or group_runs(node) for node in nodes) and time.monotonic() < deadline:
                time.sleep(0.05)
            _kill(nodes)
            return
        buffer = rest + received
        deadline = time.monotonic() + seconds if b'.' in received else deadline
        for node, done, stop in _MESSAGE.findall(buffer):
            if done:
                return
            if node:
                nodes.append(int(node))
            if stop:
                deadline = min(deadline, time.monotonic() + grace)
        # a partial message
        rest = buffer[buffer.rfind(b'node'):] if re.search(rb'node \d*$', buffer) else b''
    print(f'\n{name}: ROS 2 has not answered for too long; this process and its nodes are killed: the machine or '
          'its limits (ulimit) may leave too little room', file=sys.stderr)
    _kill(nodes, watched)


if __name__ == '__main__':
    _watch(int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3]), sys.argv[4])
