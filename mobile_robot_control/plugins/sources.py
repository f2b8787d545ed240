"""The origin of code from outside: entry points, and the source of a function, to detect changes."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mobile_robot_control.system.texts import describe_error


def installed_entry_points(group: str) -> tuple[tuple[Any, ...], str]:
    """Return the entry points of a group, and the reason if they cannot be read; '' otherwise."""
    if not any(group in text for text in _entry_point_files()):
        return (), ''
    # this import takes a tenth of a node's start
    from importlib import metadata  # noqa: PLC0415

    try:
        return tuple(metadata.entry_points(group=group)), ''
    except Exception as error:  # Python reads those of all packages, and one may be broken
        return (), f'entry points of installed packages: {describe_error(error)}; mend the broken entry_points.txt'


def _entry_point_files() -> Iterator[str]:
    """Yield the texts of all files of entry points; for an archive, which is not opened, every group."""
    for folder in sys.path:
        try:
            names = [name for name in os.listdir(folder or '.') if name.endswith(('.dist-info', '.egg-info'))]
        except NotADirectoryError:
            yield 'mobile_robot_control.laws mobile_robot_control.curves'
            continue
        except OSError:
            continue
        for name in names:
            try:
                with open(os.path.join(folder, name, 'entry_points.txt'), encoding='utf-8', errors='replace') as file:
                    yield file.read()
            except OSError:
                continue


def origin_of(function: Any) -> str:
    """Return the file that defines a function; '__main__' for a notebook, whose cells have individual names."""
    code = getattr(function, '__code__', None)
    return '__main__' if code is None or function.__module__ == '__main__' else os.path.realpath(code.co_filename)


def source_checksum(function: Any) -> str:
    """Return a checksum of a function's module, of all loaded modules of its package, or of a function at a prompt."""
    import hashlib  # noqa: PLC0415 (for searches alone: nodes start without it)

    digest = hashlib.sha256()
    for source in _sources(function):
        digest.update(source)
    return digest.hexdigest()[:16]


def _sources(function: Any) -> Iterator[bytes]:
    """Yield the texts of the files; without files, the code of the function."""
    package = function.__module__.partition('.')[0]
    ours = package in ('__main__', __name__.partition('.')[0])
    files = {os.path.realpath(function.__code__.co_filename)} if ours else {
        os.path.realpath(str(getattr(module, '__file__', ''))) for name, module in list(sys.modules.items())
        if name.partition('.')[0] == package}
    sources = [Path(file).read_bytes() for file in sorted(files) if file.endswith('.py') and os.path.exists(file)]
    yield from sources or [function.__code__.co_code]
