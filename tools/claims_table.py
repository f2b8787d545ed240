"""The chapter's claims as a Markdown table, for docs/results.md."""

import hashlib
import sys
from pathlib import Path

from chapter_figures import claims
from chapter_figures.runs import Runs
from page_part import PagePart, table_row

PART = PagePart('claims')


def fingerprint(config: Path) -> str:
    """Return a few digits that change with any of the configurations that the claims are measured with."""
    files = sorted({run.file for run in claims.RUNS})
    return hashlib.sha256(b''.join((config / file).read_bytes() for file in files)).hexdigest()[:12]


def claims_markdown(config: Path) -> str:
    """Measure the claims; return a Markdown table between marks, with the fingerprint of the configurations."""
    rows = [claims.HEAD, ['---'] * len(claims.HEAD), *claims.rows(claims.judged(Runs(config)))]
    return PART.marked(fingerprint(config), map(table_row, rows))


if __name__ == '__main__':
    PART.write(sys.argv[1:], claims_markdown(Path('config')))
