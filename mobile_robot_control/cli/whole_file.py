"""Files that are there as a whole or not at all."""

import os
from pathlib import Path


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
