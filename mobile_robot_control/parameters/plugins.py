"""Laws and curves from outside: registered here, loaded from files, and passed on to child processes."""

import os
import threading
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from mobile_robot_control.parameters.registry import REGISTRIES, PluginError
from mobile_robot_control.system.texts import printable

_LOADING = threading.Lock()


class PluginSource(NamedTuple):
    """
    The file of a law or a curve, for a process without access to it.

    Attributes
    ----------
    kind : str
        'law', 'velocity law' or 'curve'.
    file, text : str
        Path and content.

    """

    kind: str
    file: str
    text: str


def register(record: object) -> Any:
    """
    Register a position law, a velocity law or a curve under its name, for this process and its forks.

    Parameters
    ----------
    record : Law, VelocityLaw or Curve
        Replaces the record of the same name from the same file or notebook.

    Returns
    -------
    Law, VelocityLaw or Curve
        The record.

    Raises
    ------
    PluginError
        If the record is incomplete, another source has its name, or it is no such record.

    Examples
    --------
    ``register(Law('pursuit', step, Gains))`` takes a step function and its gains.

    >>> register('pursuit')
    Traceback (most recent call last):
    mobile_robot_control.parameters.registry.PluginError: 'pursuit' is no law and no curve; make a record ...

    """
    for registry in REGISTRIES.values():
        if isinstance(record, registry.record):
            registry.register(record)
            return record
    raise PluginError([f'{printable(repr(record))} is no law and no curve; make a record Law(...), '
                       'VelocityLaw(...) or Curve(...)'])


def load_plugins(files: Mapping[str, Sequence[str]], keep_going: bool = False) -> dict[str, tuple[str, ...]]:
    """
    Load files of records by their kind, or all Python files of folders; return the names of the records by kind.

    Raises PluginError for a refused file; to keep going, its reason is kept in `Registry.failures` and printed.
    """
    names: dict[str, list[str]] = {kind: [] for kind in files}
    for kind, paths in files.items():
        registry = REGISTRIES[kind]
        for file in (file for path in paths for file in _files_of(path)):
            try:
                names[kind] += [record.name for record in registry.load_file(file)]
            except PluginError as error:
                if not keep_going:
                    raise
                registry.note_failure(file, str(error))
    return {kind: tuple(dict.fromkeys(loaded)) for kind, loaded in names.items()}


def _files_of(place: str) -> list[str]:
    """Return a file, or the Python files of a folder by name; raise PluginError if it has none."""
    if not os.path.isdir(place):
        return [place]
    files = sorted(name for name in os.listdir(place) if name.endswith('.py'))
    if not files:
        raise PluginError([f'{place}: the folder has no Python file; name one with files of laws'])
    return [os.path.join(place, name) for name in files]


def plugin_environment() -> dict[str, str]:
    """Return the environment variables that make child processes, such as nodes, load the same files."""
    return {registry.variable: os.pathsep.join(registry.loaded_texts())
            for registry in REGISTRIES.values() if registry.loaded_texts()}


def plugin_sources() -> tuple[PluginSource, ...]:
    """Return the loaded files of laws and curves, for `load_sources` in another process."""
    return tuple(PluginSource(kind, file, text) for kind, registry in REGISTRIES.items()
                 for file, text in registry.loaded_texts().items())


def load_sources(sources: Iterable[PluginSource]) -> None:
    """Load the files of another process, unless this one has the same content already."""
    with _LOADING:
        for source in sources:
            registry = REGISTRIES[source.kind]
            if registry.loaded_texts().get(source.file) != source.text:
                registry.load_text(source.file, source.text)
