"""A case: a command line, an environment and files, drawn from a seed; and what its refusal must name."""

import os
import random
import shutil
import types
from pathlib import Path
from typing import NamedTuple

FOLDERS = ('here', 'home', 'tmp', 'out')
"""Folders of a case: where it runs, HOME, TMPDIR, and the only one that may be written to."""


class Case(NamedTuple):
    """A command (`simulate`, `experiment`, `report`, `tune`, `study`) or a node with odd input."""

    command: str
    arguments: list
    # values, names and files of which a refusal must name one
    named: tuple
    # variables that differ; None for one that is not set
    environment: dict = types.MappingProxyType({})
    # it needs an interpreter of its own, since its variables take effect while modules are imported
    process: bool = False
    # it needs a process in which laws and curves have not been looked for
    cold: bool = False
    # the folder that the command runs in is removed before
    gone: bool = False
    # after which the command is interrupted, which must end it [s]
    seconds: float = 10.0


class Place(NamedTuple):
    """Where a case takes place: its folder, with FOLDERS in it, and sound files to spoil (`stage.make_samples`)."""

    folder: Path
    samples: Path
    here = property(lambda place: place.folder / 'here')
    out = property(lambda place: place.folder / 'out')


def make_place(folder, samples):
    """Make the folders of a case anew."""
    shutil.rmtree(folder, ignore_errors=True)
    for name in FOLDERS:
        (folder / name).mkdir(parents=True)
    return Place(folder, samples)


def make_case(kinds, seed, place):
    """Draw the case of a seed, such as 'names/7/123': its kind, the seed of the run and a number."""
    return kinds[seed.partition('/')[0]](random.Random(seed), place)  # noqa: S311 (cases, no secrets)


def listing(place):
    """Return what must not change, by path: all of the folder but `out`, and the devices."""
    found = {f'/dev/{name}': 'there' for name in os.listdir('/dev') if not name.startswith(('pts', 'shm', 'fd'))}
    for root, folders, files in os.walk(place.folder):
        for name in [*folders, *files]:
            path = os.path.join(root, name)
            state = os.lstat(path)
            found[path] = (state.st_mode, *((state.st_size, state.st_mtime_ns) if name in files else ()))
        if root == str(place.folder):
            folders.remove('out')
    return found
