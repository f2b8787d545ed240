"""A process: its standard streams, signals to end as a flag, and an end for work that does not look at it."""

import _thread
import os
import signal
import sys
import threading
from typing import Any


def prepare_streams() -> None:
    """
    Open closed standard streams, and show characters outside a stream's encoding as escapes.

    A file that a process opens gets the lowest free number. With the standard error closed that may be 2, and messages
    of libraries to 2 would land in the file.
    """
    for number, name, mode in ((0, 'stdin', 'r'), (1, 'stdout', 'w'), (2, 'stderr', 'w')):
        try:
            os.fstat(number)
        except OSError:
            # this is the lowest free number
            os.open(os.devnull, os.O_RDWR)
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, mode, encoding='utf-8', closefd=False))  # noqa: SIM115 (stays open)
    for stream in (sys.stdout, sys.stderr):
        # replacements by a test or a notebook may lack it
        if hasattr(stream, 'reconfigure'):
            stream.reconfigure(errors='backslashreplace')


def flush_output() -> None:
    """Write out printed text, so that an OSError, as on a full disk, is raised here rather than when Python ends."""
    try:
        sys.stdout.flush()
    except OSError as error:
        if error.filename is None:
            error.filename = 'standard output'
        raise


def discard_output() -> None:
    """Drop text that can no longer be printed, so that Python does not try again when it ends, and exits with 120."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            number = os.open(os.devnull, os.O_WRONLY)
            os.dup2(number, stream.fileno())
            os.close(number)


LATE = 3.0
"""[s] after a signal in which work has to look at the flag."""
_LAST = 5.0
"""[s] after that in which the process has to end."""


HANGUP = [signal.SIGHUP] if hasattr(signal, 'SIGHUP') else []
"""The signal of a closed terminal, where there is one."""


def ending_signals() -> list[signal.Signals]:
    """Return the signals of Ctrl-C, kill and a closed terminal, which ask to end; not the last one under nohup."""
    return [signal.SIGINT, signal.SIGTERM, *[one for one in HANGUP if signal.getsignal(one) != signal.SIG_IGN]]


def leave_terminal() -> None:
    """Leave Ctrl-C and a closed terminal, which reach all processes of that, to the parent."""
    for number in (signal.SIGINT, *HANGUP):
        signal.signal(number, signal.SIG_IGN)


class Interrupt:
    """
    Turns the first signal to end into a flag; the second one ends at once. A context manager, of the main thread.

    Where nobody has looked at the flag for some seconds, as in a law with an endless loop, KeyboardInterrupt is raised.
    If that does not end the work either, as in compiled code, the process ends.
    """

    def __init__(self) -> None:
        self._requested = self._seen = False
        self._ended = threading.Event()
        self._before: dict[int, Any] = {}

    @property
    def requested(self) -> bool:
        """Whether to stop."""
        self._seen = self._requested
        return self._requested

    def _note(self, number: int, _frame: object) -> None:
        # a closed terminal and its shell send one each
        if self._requested and number not in HANGUP:
            raise KeyboardInterrupt
        self._requested = True

    def _watch(self) -> None:
        """Wait for a signal; end the work if it does not end by itself."""
        if not os.read(self._signals, 1) or self._ended.wait(LATE) or self._seen:
            return
        # a second signal
        _thread.interrupt_main()
        if not self._ended.wait(_LAST):
            os.write(2, b'interrupted, and ended since its work did not end\n')
            os._exit(1)

    def __enter__(self) -> 'Interrupt':
        # the interpreter writes there at once, also in compiled code, where no handler runs
        self._signals, self._pipe = os.pipe()
        if hasattr(os, 'set_blocking'):
            os.set_blocking(self._pipe, False)
        self._wakeup = signal.set_wakeup_fd(self._pipe, warn_on_full_buffer=False)
        self._before = {number: signal.signal(number, self._note) for number in ending_signals()}
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        for number, handler in self._before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._wakeup)
        os.close(self._pipe)
        self._thread.join()
        os.close(self._signals)
