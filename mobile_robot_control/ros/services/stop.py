"""The request to end: by SIGINT, by SIGTERM, or because the parent process has ended."""

import os
import signal
import sys
import threading
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
        """Stop as well when the parent process has ended, which closes its end of the standard input."""

        def wait() -> None:
            while os.read(sys.stdin.fileno(), 1):
                pass
            self.requested = True

        threading.Thread(target=wait, daemon=True).start()

    def _request(self, _number: int, _frame: FrameType | None) -> None:
        self.requested = True
