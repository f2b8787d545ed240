"""Laws and curves from files: loaded here, and handed on to the processes that are started from here."""

import os
import threading
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.control.law import Law
from mobile_robot_control.control.laws import LAWS
from mobile_robot_control.reference.curve import Curve
from mobile_robot_control.reference.curves import CURVES
from mobile_robot_control.registry import Registry

REGISTRIES: tuple[Registry[Any], ...] = (LAWS, CURVES)
"""The registries of laws and of curves."""
_LOADING = threading.Lock()


class PluginSource(NamedTuple):
    """
    A file of a law or a curve, for a process that may not see it.

    Attributes
    ----------
    registry : int
        0 for laws, 1 for curves.
    file, text : str
        Path and content.

    """

    registry: int
    file: str
    text: str


def register(record: Law | Curve) -> Law | Curve:
    """
    Register a position law or a curve under its name, for this process and for those that it forks.

    Parameters
    ----------
    record : Law or Curve
        Replaces the one of the same name from the same file or notebook.

    Returns
    -------
    Law or Curve
        The record.

    Raises
    ------
    PluginError
        If the record is incomplete, or its name is taken by one from elsewhere.

    """
    registry: Registry[Any] = CURVES if isinstance(record, Curve) else LAWS
    registry.register(record)
    return record


def load_plugins(law_files: Sequence[str], curve_files: Sequence[str]) -> None:
    """Load files of laws and of curves; raise PluginError for the first that is refused."""
    for file in law_files:
        LAWS.load_file(file)
    for file in curve_files:
        CURVES.load_file(file)


def plugin_environment() -> dict[str, str]:
    """Return the environment variables by which child processes, such as nodes, load the same files."""
    return {registry.variable: os.pathsep.join(registry.loaded_texts())
            for registry in REGISTRIES if registry.loaded_texts()}


def plugin_sources() -> tuple[PluginSource, ...]:
    """Return the files that laws and curves were loaded from, for `load_sources` in another process."""
    return tuple(PluginSource(number, file, text) for number, registry in enumerate(REGISTRIES)
                 for file, text in registry.loaded_texts().items())


def load_sources(sources: Iterable[PluginSource]) -> None:
    """Load files that another process has loaded, unless this one has the same content already."""
    with _LOADING:
        for source in sources:
            registry = REGISTRIES[source.registry]
            if registry.loaded_texts().get(source.file) != source.text:
                registry.load_text(source.file, source.text)
