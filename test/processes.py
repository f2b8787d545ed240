"""Processes that a test has started: found by their command lines, and waited for."""

import contextlib
import re
import signal
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


def wait_until(condition, seconds=60.0, step=0.002):
    """Look every step [s] whether a condition holds; fail if it does not in time."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f'the condition did not hold within {seconds} s'
        time.sleep(step)
