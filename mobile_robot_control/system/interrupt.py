"""The signals that ask a process to end, and these as a flag, so that completed work is kept."""

import signal
from typing import Any


def ending_signals() -> list[signal.Signals]:
    """Return the signals of Ctrl-C, kill and a closed terminal, which ask to end; not the last one under nohup."""
    hangs_up = signal.getsignal(signal.SIGHUP) != signal.SIG_IGN
    return [signal.SIGINT, signal.SIGTERM, *[signal.SIGHUP] * hangs_up]


class Interrupt:
    """
    Turns the first signal to end into a flag; the second one ends at once. A context manager.

    Attributes
    ----------
    requested : bool
        Whether to stop.

    """

    def __init__(self) -> None:
        self.requested = False
        self._before: dict[int, Any] = {}

    def _note(self, number: int, _frame: object) -> None:
        # a closed terminal and its shell send one each
        if self.requested and number != signal.SIGHUP:
            raise KeyboardInterrupt
        self.requested = True

    def __enter__(self) -> 'Interrupt':
        self._before = {number: signal.signal(number, self._note) for number in ending_signals()}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
