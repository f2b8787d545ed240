"""The generated part of a page: between two marks, the first of which has the fingerprint of what it was made from."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple


class PagePart(NamedTuple):
    """
    A part of a Markdown page that a program makes.

    Attributes
    ----------
    name : str
        In both marks.

    """

    name: str

    def _pattern(self) -> re.Pattern[str]:
        return re.compile(f'<!-- {self.name}: generated.*?-->.*<!-- end of {self.name} -->', re.DOTALL)

    def marked(self, fingerprint: str, lines: Iterable[str]) -> str:
        """Return lines between the marks."""
        return '\n'.join([f'<!-- {self.name}: generated from {fingerprint} -->', '', *lines, '',
                          f'<!-- end of {self.name} -->'])

    def found(self, text: str) -> str:
        """Return the part of a page, with its marks; '' where there is none."""
        match = self._pattern().search(text)
        return match.group() if match else ''

    def inserted(self, text: str, made: str) -> str:
        """Return a page that has both marks, with a part of `marked` in place of its own."""
        return self._pattern().sub(lambda _: made, text)

    def write(self, files: Iterable[str], made: str) -> None:
        """Insert a part of `marked` into files."""
        for path in map(Path, files):
            path.write_text(self.inserted(path.read_text(encoding='utf-8'), made), encoding='utf-8')


def table_row(cells: Sequence[str]) -> str:
    """
    Return a row of a Markdown table.

    Examples
    --------
    >>> table_row(['law', 'error'])
    '| law | error |'

    """
    return f'| {" | ".join(cells)} |'
