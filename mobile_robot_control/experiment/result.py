"""How an experiment ended."""

from typing import NamedTuple


class RunFailedError(Exception):
    """A run that cannot go on as it was asked for; the text tells why."""


class ExperimentResult(NamedTuple):
    """
    How an experiment ended.

    Attributes
    ----------
    outcome : str
        'completed', 'diverged', 'law_failed', 'interrupted' or 'node_died'.
    reason : str
        What went wrong, naming the node or the file; '' where nothing did.

    """

    outcome: str
    reason: str
