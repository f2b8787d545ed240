"""The chapter's claims as a Markdown table, for docs/results.md."""

import hashlib
import re
import sys
from pathlib import Path

from mobile_robot_control.reporting.chapter import claims
from mobile_robot_control.reporting.chapter.runs import Runs

_MARKS = re.compile('<!-- claims: generated.*?-->.*<!-- end of claims -->', re.DOTALL)


def fingerprint(config: Path) -> str:
    """Return a few digits that change with any of the configurations that the claims are measured with."""
    files = sorted({run.file for run in claims.RUNS})
    return hashlib.sha256(b''.join((config / file).read_bytes() for file in files)).hexdigest()[:12]


def claims_markdown(config: Path) -> str:
    """Measure the claims; return a Markdown table between marks, with the fingerprint of the configurations."""
    lines = [list(claims.HEAD), ['---'] * len(claims.HEAD), *claims.rows(claims.judged(Runs(config)))]
    rows = '\n'.join(f'| {" | ".join(cells)} |' for cells in lines)
    return f'<!-- claims: generated from {fingerprint(config)} -->\n\n{rows}\n\n<!-- end of claims -->'


def found(text: str) -> str:
    """Return the table of a Markdown text with its marks; '' where there is none."""
    match = _MARKS.search(text)
    return match.group() if match else ''


def insert_claims(text: str, made: str) -> str:
    """Return a Markdown text that has both marks, with the table of `claims_markdown` in place of its own."""
    return _MARKS.sub(lambda _: made, text)


if __name__ == '__main__':
    measured = claims_markdown(Path('config'))
    for name in sys.argv[1:]:
        path = Path(name)
        path.write_text(insert_claims(path.read_text(encoding='utf-8'), measured), encoding='utf-8')
