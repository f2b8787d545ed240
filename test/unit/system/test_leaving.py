"""A process that hangs while it ends is ended after a deadline."""

import subprocess
import sys
import time

HANGS = """
import ctypes
from mobile_robot_control.system.supervisor import exit_after
print('last line')
with exit_after(1, {code}):
    ctypes.PyDLL(None).sleep(60)  # holds the interpreter's lock
"""
IN_TIME = """
import time
from mobile_robot_control.system.supervisor import exit_after
with exit_after(1, 7):
    pass
time.sleep(1.5)
"""


def test_a_hanging_process_is_ended_with_its_exit_code():
    for code in (0, 3):
        begun = time.monotonic()
        done = subprocess.run([sys.executable, '-c', HANGS.format(code=code)], capture_output=True, text=True,
                              timeout=50, check=False)
        assert (done.returncode, done.stdout) == (code, 'last line\n')
        assert time.monotonic() - begun < 40.0


def test_a_process_that_ends_in_time_keeps_its_exit_code():
    assert subprocess.run([sys.executable, '-c', IN_TIME], timeout=50, check=False).returncode == 0
