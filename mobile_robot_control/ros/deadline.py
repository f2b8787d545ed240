"""A deadline for the end of a process, whatever a library still waits for."""

import ctypes
import sys
from collections.abc import Iterator
from contextlib import contextmanager

LEAVING = 5
"""[s] that a process has to leave DDS, where it may hang if many processes end."""
_MONOTONIC, _IN_A_THREAD = 1, 2  # CLOCK_MONOTONIC, SIGEV_THREAD


class _Event(ctypes.Structure):
    """Linux's `struct sigevent`: call a C function with a value, in a thread of its own."""

    _fields_ = (('value', ctypes.c_void_p), ('signal', ctypes.c_int), ('notify', ctypes.c_int),
                ('function', ctypes.c_void_p), ('attributes', ctypes.c_void_p), ('room', ctypes.c_char * 64))


class _Times(ctypes.Structure):
    """Its `struct itimerspec`."""

    _fields_ = tuple((name, ctypes.c_long) for name in ('again', 'again_ns', 'after', 'after_ns'))


@contextmanager
def exit_after(seconds: int, code: int) -> Iterator[None]:
    """
    End the process with an exit code if the block takes longer than so many seconds of wall time.

    Python's own threads and signal handlers would not do: a call that hangs in a library may hold the interpreter's
    lock. On systems other than Linux nothing is ended.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    timer = ctypes.c_void_p()
    try:
        library = ctypes.CDLL(None)
        event = _Event(value=code, notify=_IN_A_THREAD, function=ctypes.cast(library._exit, ctypes.c_void_p))
        made = library.timer_create(_MONOTONIC, ctypes.byref(event), ctypes.byref(timer)) == 0
    except (AttributeError, TypeError):  # another system than Linux, or an old one
        made = False
    if not made:
        yield
        return
    library.timer_settime(timer, 0, ctypes.byref(_Times(after=seconds)), None)
    yield
    library.timer_delete(timer)


def leave_dds(code: int) -> int:
    """Shut rclpy down if it was imported; return an exit code, or end the process with it where that hangs."""
    if 'rclpy' in sys.modules:
        import rclpy  # noqa: PLC0415 (imported by a run alone)

        with exit_after(LEAVING, code):
            rclpy.try_shutdown()
    return code
