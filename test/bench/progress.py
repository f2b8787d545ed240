"""What a benchmark is doing, on the standard error output: the table alone goes to the standard output."""

import sys


def show(text: str) -> None:
    """Show what is being measured: over the last text on a terminal, below it elsewhere."""
    if sys.stderr.isatty():
        print(f'\r\033[K{text}', end='', file=sys.stderr, flush=True)
    elif text:
        print(text, file=sys.stderr, flush=True)
