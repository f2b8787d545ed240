"""A row of a node's table of inputs, and the inputs of a step."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple


def never(_values: Any) -> float:
    """Return the timeout [s] of an input that never becomes too old."""
    return float('inf')


class Input(NamedTuple):
    """
    One input of a node.

    Attributes
    ----------
    read : callable
        Returns the content of a message's bytes; raises RefusedMessageError.
    period : int
        Between two stamps in lockstep [ns].
    timeout : callable
        Takes the node's parameters; returns the age [s] from which a message is not used, on the wall clock.
    needed : bool
        Whether the robot must stand without it, on the wall clock. In lockstep all inputs are needed.
    stops : bool
        Whether its silence is reported as a stop, on the wall clock.

    """

    read: Callable[[bytes], Any]
    period: int
    timeout: Callable[[Any], float] = never
    needed: bool = True
    stops: bool = True


class Inputs(NamedTuple):
    """
    The inputs of a step.

    Attributes
    ----------
    stamp : int
        Of the step and its outputs [ns].
    given : mapping of str to (int, object)
        By topic the stamp [ns] and the content of a message; on the wall clock, silent inputs that are not needed are
        left out.
    age : callable
        Returns the age of a topic's message [s]: in lockstep by the stamps, on the wall clock since its receipt.

    """

    stamp: int
    given: Mapping[str, tuple[int, Any]]
    age: Callable[[str], float]

    def value(self, topic: str) -> Any:
        """Return the content of a message; None without one."""
        given = self.given.get(topic)
        return None if given is None else given[1]
