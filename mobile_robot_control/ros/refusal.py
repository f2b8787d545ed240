"""How a process of nodes ends that is refused at its start."""

import sys
from collections.abc import Iterable


def refuse(label: str, violations: Iterable[str]) -> int:
    """Print one line for each violation, after the nodes' names; return the exit code of refused usage."""
    for violation in violations:
        print(f'{label}: {violation}', file=sys.stderr)
    return 2
