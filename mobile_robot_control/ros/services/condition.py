"""The condition of a node in a word, as /diagnostics has it, and the words that others look for there."""

from collections.abc import Sequence
from typing import NamedTuple

LAW_FAILED = 'law failed'
"""State of a position controller whose law has failed."""
SUBSCRIBERS_KEY = 'listeners of '
"""Before a topic, in the key of how many subscriptions to it the node has found."""


class Condition(NamedTuple):
    """
    The condition of a node.

    Attributes
    ----------
    level : bytes
        One of DiagnosticStatus: OK; WARN, it works but something is wrong; ERROR, it cannot work; STALE, it has not
        begun, for want of input.
    state : str
        In a word: running, waiting, stopped, paused, ended, diverged, law failed; of a cart on a path also standing
        and arrived.
    waits_for : sequence of str
        Node names.
    detail : str
        Why, in words; '' where the state says it.

    """

    level: bytes
    state: str
    waits_for: Sequence[str] = ()
    detail: str = ''

    def text(self) -> str:
        """Return the condition in words."""
        waits = f', waits for {" and ".join(self.waits_for)}' if self.waits_for else ''
        return self.state + waits + (f': {self.detail}' if self.detail else '')
