"""Ctrl-C and SIGTERM as a flag, so that completed work is kept."""

import signal
from typing import Any


class Interrupt:
    """
    Turns the first SIGINT or SIGTERM into a flag; the second one ends at once. A context manager.

    Attributes
    ----------
    requested : bool
        Whether to stop.

    """

    def __init__(self) -> None:
        self.requested = False
        self._before: dict[int, Any] = {}

    def _note(self, *_: object) -> None:
        if self.requested:
            raise KeyboardInterrupt
        self.requested = True

    def __enter__(self) -> 'Interrupt':
        self._before = {number: signal.signal(number, self._note) for number in (signal.SIGINT, signal.SIGTERM)}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
