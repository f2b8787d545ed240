"""What libraries log about requests from anywhere, in lines that a terminal can show."""

import logging
import math
import sys
import time

from mobile_robot_control.system.texts import describe_error, shortened

_QUIET = 10.0
"""[s] after a line in which others are only counted."""


class LogLines(logging.Handler):
    """Prints records as one printable line each, without tracebacks, and counts those that come too fast."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._printed_at, self._left_out = -math.inf, 0

    def emit(self, record: logging.LogRecord) -> None:
        """Print a record, or count it."""
        now = time.monotonic()
        if now - self._printed_at < _QUIET:
            self._left_out += 1
            return
        text = shortened(record.getMessage().strip().partition('\n')[0])
        if record.exc_info and record.exc_info[1]:
            text += f' ({describe_error(record.exc_info[1])})'
        more = f'; {self._left_out} more before' if self._left_out else ''
        self._printed_at, self._left_out = now, 0
        print(f'dashboard: {record.name}: {text}{more}', file=sys.stderr, flush=True)


def log_in_lines() -> None:
    """Have everything that is logged in this process printed so."""
    logging.basicConfig(handlers=[LogLines()], force=True)
