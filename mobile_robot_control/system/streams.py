"""The standard streams of a process: there whatever the process was started with, and able to show any text."""

import os
import sys


def prepare_streams() -> None:
    """
    Open the standard streams that are closed, and show what a stream's encoding lacks as escapes.

    A file that a process opens takes the lowest free number: with the standard error closed that can be 2, and what
    libraries print to 2 would land in the file.
    """
    for number, name, mode in ((0, 'stdin', 'r'), (1, 'stdout', 'w'), (2, 'stderr', 'w')):
        try:
            os.fstat(number)
        except OSError:
            # the lowest free number is this one
            os.open(os.devnull, os.O_RDWR)
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, mode, encoding='utf-8', closefd=False))  # noqa: SIM115 (stays open)
    for stream in (sys.stdout, sys.stderr):
        # streams that a test or a notebook has put in place may lack it
        if hasattr(stream, 'reconfigure'):
            stream.reconfigure(errors='backslashreplace')


def flush_output() -> None:
    """Write out what was printed; raises OSError, as on a full disk, here rather than when Python ends."""
    try:
        sys.stdout.flush()
    except OSError as error:
        if error.filename is None:
            error.filename = 'standard output'
        raise


def discard_output() -> None:
    """Drop what cannot be printed any more, so that Python does not try again when it ends."""
    try:
        sys.stdout.flush()
    except OSError:
        number = os.open(os.devnull, os.O_WRONLY)
        os.dup2(number, sys.stdout.fileno())
        os.close(number)
