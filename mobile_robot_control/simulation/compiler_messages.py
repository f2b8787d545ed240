"""What a compiler reports, in one line."""

import os
import re

_BEGIN = 'Failed in nopython mode pipeline'
"""Begins the report on each function; the innermost one comes last."""


def reason_of(error: Exception) -> str:
    r"""
    Return why a function cannot be compiled, and where, in one line.

    Parameters
    ----------
    error : Exception
        Of numba: a report on each function from the outermost to the one that cannot be compiled, many lines each.

    Returns
    -------
    str
        The first line of the innermost report, with file and line where it names them.

    Examples
    --------
    >>> reason_of(ValueError('Failed in nopython mode pipeline (step: nopython frontend)\nUnknown attribute'))
    'Unknown attribute'

    """
    lines = [line.strip() for line in str(error).rpartition(_BEGIN)[2].splitlines()]
    told = [line for line in lines if line and not line.startswith('(step:')]
    if not told:
        return type(error).__name__
    # a module is named with the path of its library
    reason = re.sub(r"(<module '[^']+').*?>", r'\1>', told[0])
    found = next(filter(None, (re.search(r'^File "(.+)", line (\d+):$', line) for line in told)), None)
    return f'{reason}, at {os.path.realpath(found[1])}, line {found[2]}' if found else reason
