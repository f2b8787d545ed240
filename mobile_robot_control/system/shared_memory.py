"""Fast DDS's shared memory in /dev/shm after the kill of a node: noted while the node lives, removed afterwards."""

import contextlib
import fcntl
import os
import re
import time
from collections.abc import Collection

_SHARED = '/dev/shm'  # noqa: S108 (where Linux has it)
_SEGMENT = re.compile(r'(?:sem\.)?(fast(?:dds|rtps)_(?:port\d+|[0-9a-f]{16}))(?:_el|_sl|_mutex)?')
owned: set[str] = set()
"""Segments that nodes of this process have owned, as far as `note_owned` has found them."""


def segments() -> set[str]:
    """Return the names of all segments."""
    with contextlib.suppress(OSError):
        return {found[1] for found in map(_SEGMENT.fullmatch, os.listdir(_SHARED)) if found}
    return set()


def note_owned(pids: Collection[int]) -> None:
    """Note the present segments of processes: Fast DDS holds a lock on the file `_el` or `_sl` of each."""
    with contextlib.suppress(OSError):
        locked = set()
        with open('/proc/locks', encoding='ascii') as file:
            for line in file:
                words = line.split()
                if words[1] == 'FLOCK' and int(words[4]) in pids:
                    locked.add(int(words[5].rpartition(':')[2]))
        with os.scandir(_SHARED) as entries:
            owned.update(found[1] for entry in entries
                         if (found := _SEGMENT.fullmatch(entry.name)) and entry.inode() in locked)


def remove(names: Collection[str]) -> None:
    """Remove segments without an owner; a port only when no process has it mapped, in case it gets a new owner."""
    dead = _dead(names)
    if dead:
        # a segment under construction is neither locked nor mapped for a moment
        time.sleep(0.2)
    for name in _dead(dead):
        for path in (name, f'{name}_el', f'{name}_sl', f'sem.{name}_mutex'):
            with contextlib.suppress(OSError):
                os.unlink(f'{_SHARED}/{path}')


def _dead(names: Collection[str]) -> set[str]:
    """Return the existing segments with free locks and, for ports, without a mapping in any process."""
    there = segments().intersection(names)
    maps = []
    for pid in filter(str.isdigit, os.listdir('/proc')) if there else ():
        with contextlib.suppress(OSError), open(f'/proc/{pid}/maps', encoding='utf-8', errors='replace') as file:
            maps.append(file.read())
    used = ''.join(maps)
    return {name for name in there
            if _is_free(f'{_SHARED}/{name}_el') and _is_free(f'{_SHARED}/{name}_sl')
            and ('port' not in name or not (f'{name}\n' in used or f'{name}_mutex\n' in used))}


def _is_free(path: str) -> bool:
    """Return whether no process holds the lock of a file, which may be missing."""
    try:
        with open(path, 'rb') as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    return True
