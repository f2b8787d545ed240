"""Files that are complete or not there, and what went wrong with them in words."""

import errno
import os
from pathlib import Path


def write_atomically(file: Path, content: str | bytes) -> None:
    """
    Write a file so that a kill, a crash or a full disk leaves the version before it, or none.

    Parameters
    ----------
    file : Path
        Replaced as a whole.
    content : str or bytes
        All of it; a text is written in UTF-8.

    Raises
    ------
    OSError
        If it cannot be written; its filename is that of the file.

    """
    draft = file.with_name(f'.{file.name}.{os.getpid()}')
    try:
        with draft.open('wb') as out:
            out.write(content.encode() if isinstance(content, str) else content)
            out.flush()
            os.fsync(out.fileno())
        draft.replace(file)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror or str(error), str(file)) from error


def explain(error: OSError) -> str:
    """Return one line that names the file, the error and the remedy."""
    where = f'{error.filename}: ' if error.filename else ''
    remedy = 'make room there, or name a place elsewhere' if is_disk_full(error) else 'name a place that can be written'
    return f'{where}{error.strerror or error}; {remedy}'


def is_disk_full(error: OSError) -> bool:
    """Return whether an error is that of a full disk or quota."""
    return error.errno in (errno.ENOSPC, errno.EDQUOT)
