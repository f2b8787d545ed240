"""The end of a process of nodes that is refused at its start."""

import sys
from collections.abc import Iterable

from mobile_robot_control.system.texts import printable

LOAD_ERRORS = (ImportError, OSError, MemoryError)
"""Errors of an import of ROS's packages, if one is missing, or memory is short."""


def load_fault(error: BaseException) -> str:
    """Return one line for a failed import of ROS's packages, with the remedy."""
    lines = str(error).strip().splitlines()
    return (f'ROS 2 cannot be loaded: {type(error).__name__}: {lines[0] if lines else "no memory"}; source ROS 2 '
            'or install its wheels, and leave it memory')


def refuse(label: str, violations: Iterable[str]) -> int:
    """Print one line for each violation, after the nodes' names; return the exit code of refused usage."""
    for violation in violations:
        print(f'{label}: {printable(violation)}', file=sys.stderr)
    return 2
