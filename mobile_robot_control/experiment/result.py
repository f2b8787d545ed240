"""The end of an experiment."""

from typing import NamedTuple


class RunFailedError(Exception):
    """A run that cannot continue as requested; the text is the reason."""


class ExperimentResult(NamedTuple):
    """
    The end of an experiment.

    Attributes
    ----------
    outcome : str
        'completed', 'diverged', 'law_failed', 'interrupted' or 'node_died'.
    reason : str
        The error, with the node or the file; '' without one.

    """

    outcome: str
    reason: str
