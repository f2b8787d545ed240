"""The compiler: signals wait for its end, and its functions are kept on disk for the next program."""

import hashlib
import os
import shutil
import signal
import stat
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

import numba.core.caching
import numba.core.config
import numba.core.event

from mobile_robot_control.jit import BEGUN
from mobile_robot_control.system.process import ending_signals
from mobile_robot_control.system.texts import printable

fcntl: Any = None
with suppress(ImportError):  # Windows has none
    import fcntl
_caching: Any = numba.core.caching
_config: Any = numba.core.config
_event: Any = numba.core.event

# before numba 0.62, as from apt, it was private
_Located: Any = getattr(_caching, 'UserProvidedCacheLocator', None) or _caching._UserProvidedCacheLocator

PACKAGE = Path(__file__).parents[1]
_LOCK = 'lock'
_KEPT = 30 * 24 * 3600.0
"""So long after its last use, machine code of another version of the package is removed [s]."""


class _Undisturbed(_event.Listener):  # type: ignore[misc,unused-ignore]
    """Lets signals wait for the end of the compiler: an exception within it may free memory twice, a segfault."""

    def __init__(self) -> None:
        self._depth = 0
        self._came: dict[int, None] = {}

    def on_start(self, _event: object) -> None:
        # handlers run in the main thread
        if threading.current_thread() is not threading.main_thread():
            return
        self._depth += 1
        if self._depth == 1:
            before = {number: signal.getsignal(number) for number in ending_signals()}
            self._before = {number: handler for number, handler in before.items() if callable(handler)}
            for number in self._before:
                signal.signal(number, self._note)

    def _note(self, number: int, _frame: object) -> None:
        self._came[number] = None

    def on_end(self, _event: object) -> None:
        if threading.current_thread() is not threading.main_thread():
            return
        self._depth -= 1
        if self._depth == 0:
            for number, handler in self._before.items():
                signal.signal(number, handler)
            came, self._came = self._came, {}
            for each in came:
                signal.raise_signal(each)


# the lock is held as long as anything is compiled or loaded
_event.register('numba:compiler_lock', _Undisturbed())


def home() -> Path:
    """Return the folder of all versions: in NUMBA_CACHE_DIR, XDG_CACHE_HOME or ~/.cache."""
    place = _config.CACHE_DIR or os.environ.get('XDG_CACHE_HOME') or os.path.expanduser('~/.cache')
    return Path(place, PACKAGE.name)


@lru_cache(maxsize=1)
def folder() -> Path | None:
    """
    Return the folder for machine code of the modules as they were imported; None where that is not certain.

    numba's own cache looks at the file of a function alone, and not at those of its callees. What lies in the folder
    is unpickled, and runs: where others could write it there is none, which is told once. Windows, where that is not
    known, has none.
    """
    sources, files = hashlib.sha256(), sorted(PACKAGE.rglob('*.py'))
    for file in files:
        sources.update(f'{file.relative_to(PACKAGE)}\n'.encode() + file.read_bytes())
    if fcntl is None:
        return None
    # a file that was edited since then is not the module that runs here
    as_imported = files and all(file.stat().st_mtime < BEGUN for file in files)
    if not as_imported:
        return None
    why = _why_not(home())
    if why:
        print(f'compiled laws are not kept, and each start compiles them for seconds: {printable(str(home()))} {why}; '
              'remove it, or name a place of your own in NUMBA_CACHE_DIR', file=sys.stderr)
    return None if why else home() / sources.hexdigest()[:16]


def _why_not(place: Path) -> str:
    """Make a folder if it is absent; return why no code is loaded from there, '' if the user alone writes it."""
    if not place.is_absolute():
        return 'is not an absolute path'
    try:
        with suppress(FileExistsError):
            place.mkdir(mode=0o700, parents=True)
        status = place.lstat()
    except OSError as error:
        return f'cannot be made ({error.strerror})'
    mode = stat.S_IMODE(status.st_mode) & 0o777
    return ('is a link' if stat.S_ISLNK(status.st_mode) else 'is no folder' if not stat.S_ISDIR(status.st_mode) else
            f'belongs to user {status.st_uid}' if status.st_uid != os.geteuid() else
            f'has the mode {mode:04o} in place of 0700' if mode != 0o700 else '')


class _Place(_Located):  # type: ignore[misc,unused-ignore]
    """Where a function lies: the folder has the checksum of all sources, which no stamp must repeat."""

    @classmethod
    def from_function(cls, py_func: Callable[..., object], py_file: str) -> Any:
        found = cls(py_func, py_file)
        found._cache_path = str(folder())
        return found

    def get_source_stamp(self) -> Any:
        return ''


class _Storage(_caching.CompileResultCacheImpl):
    _locator_classes = [_Place]  # noqa: RUF012 (as numba has it)


class _Cache(_caching.FunctionCache):
    """A cache that many processes use: two that save at once would exchange their functions in that of numba."""

    _impl_class = _Storage

    @contextmanager
    def _alone(self) -> Iterator[None]:
        self._impl.locator.ensure_cache_path()
        with Path(self.cache_path, _LOCK).open('w') as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield

    def load_overload(self, sig: object, target_context: object) -> Any:
        # without a folder that can be written, it is compiled
        with suppress(Exception), self._alone():
            try:
                return super().load_overload(sig, target_context)
            except Exception:  # files that were cut off raise anything
                self.flush()
        return None

    def save_overload(self, sig: object, data: object) -> None:
        # a full disk ends no search
        with suppress(Exception), self._alone():
            super().save_overload(sig, data)


def kept(dispatcher: Any, *of: Callable[..., Any]) -> Callable[..., Any]:
    """Return a compiled function that is kept on disk if all functions that it is made of belong to this package."""
    ours = all((getattr(function, '__module__', '') or '').startswith(f'{PACKAGE.name}.') for function in of)
    if ours and folder() is not None:
        with suppress(Exception):  # of a version of numba that keeps its functions in another way
            dispatcher._cache = _Cache(dispatcher.py_func)
            forget_old()
    return cast('Callable[..., Any]', dispatcher)


@lru_cache(maxsize=1)
def forget_old() -> None:
    """Remove what versions of this package left that were not used for a while."""
    for lock in home().glob(f'*/{_LOCK}'):
        if lock.parent != folder() and time.time() - lock.stat().st_mtime > _KEPT:
            shutil.rmtree(lock.parent, ignore_errors=True)
