"""The standard streams of a process: always open, and able to show any text."""

import os
import sys


def prepare_streams() -> None:
    """
    Open closed standard streams, and show characters outside a stream's encoding as escapes.

    A file that a process opens gets the lowest free number. With the standard error closed that may be 2, and messages
    of libraries to 2 would land in the file.
    """
    for number, name, mode in ((0, 'stdin', 'r'), (1, 'stdout', 'w'), (2, 'stderr', 'w')):
        try:
            os.fstat(number)
        except OSError:
            # this is the lowest free number
            os.open(os.devnull, os.O_RDWR)
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, mode, encoding='utf-8', closefd=False))  # noqa: SIM115 (stays open)
    for stream in (sys.stdout, sys.stderr):
        # replacements by a test or a notebook may lack it
        if hasattr(stream, 'reconfigure'):
            stream.reconfigure(errors='backslashreplace')


def flush_output() -> None:
    """Write out printed text, so that an OSError, as on a full disk, is raised here rather than when Python ends."""
    try:
        sys.stdout.flush()
    except OSError as error:
        if error.filename is None:
            error.filename = 'standard output'
        raise


def discard_output() -> None:
    """Drop text that can no longer be printed, so that Python does not try again when it ends."""
    try:
        sys.stdout.flush()
    except OSError:
        number = os.open(os.devnull, os.O_WRONLY)
        os.dup2(number, sys.stdout.fileno())
        os.close(number)
