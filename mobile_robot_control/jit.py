"""Mark functions that a compiler may take, without importing one."""

from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar('Function', bound=Callable[..., Any])

JITABLE: list[Callable[..., Any]] = []
"""Every marked function, in the order of definition: callees before their callers."""


def jitable(function: Function) -> Function:
    """
    Remember a function for later compilation and return it as it is.

    The nodes call the plain function; ``simulation.batch`` hands the whole list to numba.

    Parameters
    ----------
    function : callable
        A pure function of floats and NamedTuples that uses ``math`` only.

    Returns
    -------
    callable
        The same function.

    """
    JITABLE.append(function)
    return function
