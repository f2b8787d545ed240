"""Processes that a test has started: found by their command lines, and waited for."""

import contextlib
import re
import signal
import subprocess
import sys
import time
from pathlib import Path


def processes_of(folder, node=''):
    """List the processes [pid] with a path in a folder on their command line; those of one node, if it is named."""
    found = []
    for process in Path('/proc').glob('[0-9]*'):
        with contextlib.suppress(OSError):
            words = (process / 'cmdline').read_text(errors='replace').split('\0')
            if any(word.startswith(str(folder)) for word in words) and (not node or node in words):
                found.append(int(process.name))
    return found


def catches_sigterm(pid):
    """Return whether a process has a handler for SIGTERM, which the package installs before all else."""
    with contextlib.suppress(OSError):
        caught = re.search(r'SigCgt:\s*(\w+)', Path(f'/proc/{pid}/status').read_text())
        return bool(int(caught[1], 16) >> (signal.SIGTERM - 1) & 1)
    return False


def threads_of(pid):
    """List the names of a process's threads."""
    found = []
    for thread in Path(f'/proc/{pid}/task').glob('*/comm'):
        with contextlib.suppress(OSError):  # it has ended
            found.append(thread.read_text().strip())
    return found


_USAGE = """import os, sys
_, status, used = os.wait4(os.posix_spawn(sys.executable, [sys.executable, *sys.argv[1:]], os.environ), 0)
print(os.waitstatus_to_exitcode(status), used.ru_utime, used.ru_maxrss / 1024)"""


def usage_of(*arguments):
    """
    Run Python with arguments to its end; return its CPU time [s] and its largest memory [MB].

    A small process starts it: Linux counts in a process's largest memory that of the process that started it.
    """
    run = subprocess.run([sys.executable, '-c', _USAGE, *map(str, arguments)], capture_output=True, text=True,
                         check=True)
    code, seconds, megabytes = run.stdout.splitlines()[-1].split()
    assert code == '0', (arguments, run.stderr)
    return float(seconds), float(megabytes)


def wait_until(condition, seconds=60.0, step=0.002):
    """Look every step [s] whether a condition holds; fail if it does not in time."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f'the condition did not hold within {seconds} s'
        time.sleep(step)
