"""What the commands of this package print, for the pages that have it."""

import shlex
import subprocess
import sys

from commands import command_modules


def output_of(command: str, *more: str, progress: bool = False) -> str:
    """
    Run a command of this package in a process of its own; return what it prints.

    Parameters
    ----------
    command : str
        As in a shell.
    *more : str
        Further words.
    progress : bool
        Whether its standard error, with the progress bar, is that of this process.

    Raises
    ------
    RuntimeError
        If it fails, with what it printed.

    """
    name, *options = shlex.split(command)
    done = subprocess.run(  # noqa: S603 (commands of this package)
        [sys.executable, '-m', command_modules()[name], *options, *more],
        stdout=subprocess.PIPE, stderr=None if progress else subprocess.PIPE, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f'{command}: exit code {done.returncode}: {done.stderr or "see above"}')
    return done.stdout
