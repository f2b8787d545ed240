"""Where code from outside comes from: entry points, and the source of a function, to see whether it has changed."""

import hashlib
import os
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

from mobile_robot_control.texts import describe_error


def installed_entry_points(group: str) -> tuple[tuple[metadata.EntryPoint, ...], str]:
    """Return the entry points of a group, and why they cannot be read; '' where they can."""
    try:
        return tuple(metadata.entry_points(group=group)), ''
    except Exception as error:  # Python reads those of all packages, and one may be broken
        return (), f'entry points of installed packages: {describe_error(error)}; mend the broken entry_points.txt'


def origin_of(function: Any) -> str:
    """Return the file that defines a function; '__main__' for one of a notebook, whose cells have a name each."""
    code = getattr(function, '__code__', None)
    return '__main__' if code is None or function.__module__ == '__main__' else os.path.realpath(code.co_filename)


def source_checksum(function: Any) -> str:
    """Return a checksum of a function's module, of all loaded modules of its package, or of a function at a prompt."""
    digest = hashlib.sha256()
    for source in _sources(function):
        digest.update(source)
    return digest.hexdigest()[:16]


def _sources(function: Any) -> Iterator[bytes]:
    """Yield the texts of the files; the code of the function where there are none."""
    package = function.__module__.partition('.')[0]
    ours = package in ('__main__', __name__.partition('.')[0])
    files = {os.path.realpath(function.__code__.co_filename)} if ours else {
        os.path.realpath(str(getattr(module, '__file__', ''))) for name, module in list(sys.modules.items())
        if name.partition('.')[0] == package}
    sources = [Path(file).read_bytes() for file in sorted(files) if file.endswith('.py') and os.path.exists(file)]
    yield from sources or [function.__code__.co_code]
