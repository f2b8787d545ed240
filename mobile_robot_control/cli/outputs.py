"""Files that commands write: whole or not at all, and an error names the file."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """
    Write a file as a whole or not at all.

    Parameters
    ----------
    path : Path
        The file.

    Yields
    ------
    Path
        The same, to be written to.

    Raises
    ------
    OSError
        With the file's name, which the operating system leaves out when a disk is full; nothing half-written stays.

    """
    try:
        yield path
    except OSError as error:
        with suppress(OSError):
            path.unlink()
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error


def write(file: Path, content: str | bytes) -> None:
    """
    Write a file so that a kill or a full disk leaves the one before it.

    Parameters
    ----------
    file : Path
        Replaced.
    content : str or bytes
        All of it.

    Raises
    ------
    OSError
        If it cannot be written; the name in it is the file's.

    """
    fresh = file.with_name(f'.{file.name}.{os.getpid()}')
    try:
        with fresh.open('wb') as out:
            out.write(content.encode() if isinstance(content, str) else content)
            out.flush()
            os.fsync(out.fileno())
        fresh.replace(file)
    except OSError as error:
        fresh.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(file)) from error


def explain(error: OSError) -> str:
    """
    Say what went wrong with a file, and the remedy.

    Parameters
    ----------
    error : OSError
        Of writing or reading.

    Returns
    -------
    str
        One line.

    """
    where = f'{error.filename}: ' if error.filename else ''
    remedy = 'make room there, or name a place elsewhere' if is_full(error) else 'name a place that can be written'
    return f'{where}{error.strerror or error}; {remedy}'


def is_full(error: OSError) -> bool:
    """
    Say whether an error is that of a full disk.

    Parameters
    ----------
    error : OSError
        Of writing.

    Returns
    -------
    bool
        True for a full disk or quota.

    """
    return error.errno in (errno.ENOSPC, errno.EDQUOT)
