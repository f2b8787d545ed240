"""A node of one's own in the loop: a step function and a table of topics. See docs/extending.md."""

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.ros.start.executables import run_nodes


class _NoParameters(NamedTuple):
    pass


class OwnNode(NamedTuple):
    """
    A node that answers its inputs, in lockstep and on the wall clock.

    Attributes
    ----------
    name : str
        Of the node.
    step : callable
        ``step(state, inputs, parameters, dt)`` returns the next state and the outputs. `inputs` and outputs are
        mappings of topics to the contents of their messages, such as a BodyVelocity; `dt` is the period [s]. A pure
        function.
    inputs, outputs : mapping of str to str
        Each topic, and the topic of docs/topics.md with the same kind of message: its type, frames and rate. The first
        input is the node's question, and sets its rate.
    parameters : type
        A NamedTuple of fields annotated with Field, for `step`.
    start : object
        The state at the start of a run.
    timeout : float
        Age [s] from which an input counts as silent, on the wall clock: the node rests, and its state starts again.

    """

    name: str
    step: Callable[[Any, Mapping[str, Any], Any, float], tuple[Any, Mapping[str, Any]]]
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]
    parameters: type = _NoParameters
    start: Any = None
    timeout: float = 0.5


def run(node: OwnNode, arguments: Sequence[str] | None = None) -> int:
    """Run a node with ROS arguments, those of the process by default, until it is stopped; return its exit code."""
    return run_nodes([node.name], sys.argv[1:] if arguments is None else arguments, own=node)
