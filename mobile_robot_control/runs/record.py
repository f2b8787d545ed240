"""The record of a run: its topics, metrics, parameters and events, before any array is made."""

from typing import Any, NamedTuple

from mobile_robot_control.runs.series import Series
from mobile_robot_control.settings.nodes import Configuration


class Event(NamedTuple):
    """
    Changes of a run that a node applied together.

    Attributes
    ----------
    time : float
        The first affected time [s].
    node : str
        Node that applied them.
    values : dict of str to object
        By parameter, or `disturbance`.

    """

    time: float
    node: str
    values: dict[str, Any]


class RunRecord(NamedTuple):
    """The parts of a run; see `Run`."""

    name: str
    series: Series
    problems: tuple[str, ...]
    metrics: dict[str, Any]
    parameters: Configuration | None
    provenance: dict[str, Any] = {}  # noqa: RUF012 (never changed)
    events: tuple[Event, ...] = ()
