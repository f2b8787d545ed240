"""The condition of a node in a word, as in /diagnostics, and the words that others look for there."""

from collections.abc import Sequence
from typing import NamedTuple

LAW_FAILED = 'law failed'
"""State of a position controller with a failed law."""
SUBSCRIBERS_KEY = 'listeners of '
"""Prefix of a topic in the key of its number of discovered subscriptions."""


class Condition(NamedTuple):
    """
    The condition of a node.

    Attributes
    ----------
    level : bytes
        One of DiagnosticStatus: OK; WARN, it works but something is wrong; ERROR, it cannot work; STALE, it has not
        begun, for lack of input.
    state : str
        In a word: running, waiting, stopped, paused, ended, diverged, law failed; of a cart on a path also standing
        and arrived.
    waits_for : sequence of str
        Node names.
    detail : str
        The reason, in words; '' if the state implies it.

    """

    level: bytes
    state: str
    waits_for: Sequence[str] = ()
    detail: str = ''

    def text(self) -> str:
        """Return the condition in words."""
        waits = f', waits for {" and ".join(self.waits_for)}' if self.waits_for else ''
        return self.state + waits + (f': {self.detail}' if self.detail else '')
