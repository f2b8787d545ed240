"""A row of the benchmarks' table."""

import statistics
from collections.abc import Iterable, Sequence
from typing import NamedTuple


class Row(NamedTuple):
    """
    One benchmark's result.

    Attributes
    ----------
    name : str
        What is compared.
    ratio : float
        Ours to what it is compared with, both measured in the same run.
    target : str
        What the ratio should be, such as '<= 1.3'.
    holds : bool
        Whether it is.
    how : str
        How it was measured, with the two numbers that the ratio is made of.

    """

    name: str
    ratio: float
    target: str
    holds: bool
    how: str


def at_least(name: str, ratio: float, bound: float, how: str) -> Row:
    """Make a row whose ratio must not be smaller; NaN does not hold."""
    return Row(name, ratio, f'>= {bound:.3g}', ratio >= bound, how)


def at_most(name: str, ratio: float, bound: float, how: str) -> Row:
    """Make a row whose ratio must not be larger; NaN does not hold."""
    return Row(name, ratio, f'<= {bound:.3g}', ratio <= bound, how)


def median_ratio(ours: Sequence[float], theirs: Sequence[float]) -> float:
    """Give the median over pairs measured side by side: what slows a whole pair down does not count."""
    return statistics.median(a / b for a, b in zip(ours, theirs, strict=True))


def table(rows: Iterable[Row]) -> str:
    """
    Write rows as a Markdown table.

    Examples
    --------
    >>> print(table([at_most('start', 1.25, 1.3, '0.50 s to 0.40 s')]))
    | benchmark | ratio | target | holds | measured |
    |-----------|-------|--------|-------|----------|
    | start     | 1.25  | <= 1.3 | yes   | 0.50 s to 0.40 s |

    """
    head = ('benchmark', 'ratio', 'target', 'holds', 'measured')
    lines = [(row.name, f'{row.ratio:.2f}', row.target, 'yes' if row.holds else 'NO', row.how) for row in rows]
    widths = [max(len(cell) for cell in column) for column in list(zip(head, *lines, strict=True))[:-1]]

    def written(cells: Sequence[str]) -> str:
        padded = [cell.ljust(width) for cell, width in zip(cells, widths, strict=False)]
        return f'| {" | ".join([*padded, cells[-1]])} |'

    rule = '|'.join('-' * (width + 2) for width in [*widths, len(head[-1])])
    return '\n'.join([written(head), f'|{rule}|', *map(written, lines)])
