"""Mark functions that a compiler may take, without importing one."""

import time
from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar('Function', bound=Callable[..., Any])

BEGUN = time.time()
"""Before any module with a marked function was imported [s]."""

JITABLE: list[Callable[..., Any]] = []
"""Every marked function, in the order of definition: callees before their callers."""

APART: set[Callable[..., Any]] = set()
"""The marked functions that are compiled separately instead of into their callers."""


def jitable(function: Function) -> Function:
    """
    Register a function for later compilation and return it unchanged.

    The nodes call the plain function; ``loop.batch`` hands the whole list to numba.

    Parameters
    ----------
    function : callable
        A pure function of floats and NamedTuples, with the functions of ``math`` and `elementary`.

    Returns
    -------
    callable
        The same function.

    Examples
    --------
    >>> @jitable
    ... def halved(x):
    ...     return 0.5 * x
    >>> halved(3.0)
    1.5
    >>> JITABLE.remove(halved)  # an example is not compiled

    """
    JITABLE.append(function)
    return function


def jitable_apart(function: Function) -> Function:
    """
    Register a large, rarely called function as `jitable` does: its callers stay short and compile soon.

    Parameters
    ----------
    function : callable
        As for `jitable`.

    Returns
    -------
    callable
        The same function.

    """
    APART.add(function)
    return jitable(function)
