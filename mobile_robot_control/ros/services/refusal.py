"""How a process of nodes ends that is refused at its start."""

import sys
from collections.abc import Iterable

from mobile_robot_control.system.texts import printable

LOAD_ERRORS = (ImportError, OSError, MemoryError)
"""What an import of ROS's packages may raise where one is missing, or memory is."""


def load_fault(error: BaseException) -> str:
    """Return one line for an import of ROS's packages that failed, with the remedy."""
    lines = str(error).strip().splitlines()
    return (f'ROS 2 cannot be loaded: {type(error).__name__}: {lines[0] if lines else "no memory"}; source ROS 2 '
            'or install its wheels, and leave it memory')


def refuse(label: str, violations: Iterable[str]) -> int:
    """Print one line for each violation, after the nodes' names; return the exit code of refused usage."""
    for violation in violations:
        print(f'{label}: {printable(violation)}', file=sys.stderr)
    return 2
