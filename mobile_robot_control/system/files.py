"""Files of users: read within bounds, written completely or not at all, and their errors in words."""

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple


class FileKind(NamedTuple):
    """
    A kind of input file.

    Attributes
    ----------
    name : str
        For messages.
    largest : int
        Largest size in bytes; a larger file is refused.

    """

    name: str
    largest: int


PARAMETER_FILE = FileKind('parameter file', 1 << 20)
PLUGIN = FileKind('Python file', 1 << 20)
METRICS = FileKind('file of metrics', 1 << 20)
METADATA = FileKind('metadata.yaml', 1 << 20)
JOURNAL = FileKind('journal', 1 << 28)
# these two are read in pieces
TABLE = FileKind('table', 1 << 36)
BAG = FileKind('bag', 1 << 40)


def check_regular(file: Path) -> None:
    """Raise OSError, with the file's name, if it is a device, a pipe or a folder."""
    try:
        mode = os.stat(file).st_mode
    except FileNotFoundError:
        return
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, 'is a folder', str(file))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, 'is not a regular file', str(file))


def open_bounded(file: Path, kind: FileKind) -> BinaryIO:
    """
    Open a user's file for reading.

    Raises OSError, with the file's name, if it cannot be opened, is not a regular file, or is too large for its kind.
    """
    check_regular(file)
    if os.stat(file).st_size > kind.largest:
        raise _too_large(file, kind)
    return file.open('rb')


def read_bounded(file: Path, kind: FileKind) -> bytes:
    """
    Return the content of a user's file.

    Raises OSError, with the file's name, if it cannot be read, is not a regular file, or is too large for its kind.
    """
    with open_bounded(file, kind) as opened:
        # files of the kernel have more content than their size
        content = opened.read(kind.largest + 1)
    if len(content) > kind.largest:
        raise _too_large(file, kind)
    return content


def _too_large(file: Path, kind: FileKind) -> OSError:
    """Return the error for a file that is too large for its kind."""
    return OSError(errno.EFBIG, f'is larger than a {kind.name} can be, {kind.largest} bytes', str(file))


def parse_json(document: str | bytes) -> Any:
    """Read JSON; raise ValueError if it is invalid, or nested too deep."""
    import json  # noqa: PLC0415 (nodes read no JSON, and start without it)

    try:
        return json.loads(document)
    except RecursionError:
        raise ValueError('nested too deep') from None


def write_atomically(file: Path, content: str | bytes) -> None:
    """
    Write a file so that a kill, a crash or a full disk leaves the previous version, or none.

    Parameters
    ----------
    file : Path
        Replaced as a whole.
    content : str or bytes
        All of it; a text is written in UTF-8.

    Raises
    ------
    OSError
        If it cannot be written, or is no regular file; its filename is that of the file.

    """
    check_regular(file)
    written = content.encode(errors='backslashreplace') if isinstance(content, str) else content
    draft = file.with_name(f'.{file.name}.{os.getpid()}')
    try:
        with draft.open('wb') as out:
            out.write(written)
            out.flush()
            os.fsync(out.fileno())
        draft.replace(file)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror or str(error), str(file)) from error


@contextmanager
def naming_errors(file: Path) -> Iterator[None]:
    """Add the name of this file to an OSError without one, as after a failed write."""
    try:
        yield
    except OSError as error:
        if error.filename is None:
            error.filename = str(file)
        raise


def explain(error: OSError) -> str:
    """Return one line with the file, the error and the remedy."""
    where = f'{error.filename}: ' if error.filename else ''
    remedy = 'make room there, or name a place elsewhere' if is_disk_full(error) else 'name a place that can be written'
    return f'{where}{error.strerror or error}; {remedy}'


def is_disk_full(error: OSError) -> bool:
    """Return whether an error comes from a full disk or quota."""
    return error.errno in (errno.ENOSPC, errno.EDQUOT)


def check_place(file: Path) -> None:
    """Raise OSError if a file cannot be written, or its folder cannot be made; leave nothing there."""
    check_regular(file)
    folder = next(one for one in file.absolute().parents if os.path.lexists(one))
    if not folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(folder))
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(folder))


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Make a folder, and keep other processes of this package out of it; raise OSError if one writes already."""
    folder.mkdir(parents=True, exist_ok=True)
    try:
        import fcntl  # noqa: PLC0415 (not on every platform: there nothing is kept)
    except ImportError:
        yield
        return
    opened = os.open(folder, os.O_RDONLY)
    try:
        # of the folder itself: it leaves no file, and ends with the process
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(opened)
        if error.errno not in (errno.EWOULDBLOCK, errno.EACCES):
            yield  # a file system without locks
            return
        raise OSError(errno.EBUSY, 'another process writes into it; wait until it has ended', str(folder)) from None
    try:
        yield
    finally:
        os.close(opened)


def writable_file(path: str) -> Path:
    """Return a file's path after an early check that it can be written; raise OSError if it cannot."""
    file = Path(path)
    check_regular(file)
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open('a'):
        return file


def encodable_path(path: str) -> str:
    """Return a path for nodes; raise ValueError if it is not UTF-8, the only encoding of ROS."""
    try:
        os.path.abspath(path).encode()
    except UnicodeEncodeError:
        raise ValueError('is not UTF-8, as ROS needs it; name another folder') from None
    return path
