"""Requests to a process by signals: to end, and to read the file of its law again."""

import atexit
import os
import signal
import sys
import threading
from types import FrameType

from mobile_robot_control.system.interrupt import ending_signals


def _ending_signals() -> list[signal.Signals]:
    """Return the signals after which a robot is stopped: those that people and systems end it with."""
    return [*ending_signals(), signal.SIGQUIT]


def _ignore_signals() -> None:
    for number in _ending_signals():
        signal.signal(number, signal.SIG_IGN)


class Stop:
    """
    A request to end, made by SIGINT, SIGTERM, SIGHUP or SIGQUIT.

    Attributes
    ----------
    requested : bool
        Whether a signal has arrived.
    read_again : bool
        Whether SIGUSR1 has arrived: to read the files of laws again.

    """

    def __init__(self) -> None:
        self.requested = self.read_again = False
        for number in _ending_signals():
            signal.signal(number, self._request)
        signal.signal(signal.SIGUSR1, self._request_reading)
        # at its end Python restores the defaults: a late signal would kill the process
        atexit.register(_ignore_signals)

    def follow_parent(self) -> None:
        """Stop also when the parent process has ended, which closes its end of the standard input."""

        def wait() -> None:
            while os.read(sys.stdin.fileno(), 1):
                pass
            self.requested = True

        threading.Thread(target=wait, daemon=True).start()

    def _request_reading(self, _number: int, _frame: FrameType | None) -> None:
        self.read_again = True

    def _request(self, _number: int, _frame: FrameType | None) -> None:
        self.requested = True
