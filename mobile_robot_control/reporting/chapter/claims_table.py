"""The chapter's claims as a Markdown table, for the README."""

import hashlib
import re
import sys
from pathlib import Path

from mobile_robot_control.reporting.chapter import claims
from mobile_robot_control.reporting.chapter.runs import Runs

_MARKS = re.compile('<!-- claims: generated.*?-->.*<!-- end of claims -->', re.DOTALL)


def fingerprint(config: Path) -> str:
    """
    Give what tells whether a table was made from the present configurations.

    Parameters
    ----------
    config : Path
        Folder of the configurations.

    Returns
    -------
    str
        A few digits that change with any of the files that the claims are measured with.

    """
    files = sorted({run.file for run in claims.RUNS})
    return hashlib.sha256(b''.join((config / file).read_bytes() for file in files)).hexdigest()[:12]


def claims_markdown(config: Path) -> str:
    """
    Measure the claims.

    Parameters
    ----------
    config : Path
        Folder of the configurations.

    Returns
    -------
    str
        Markdown, with marks around it and the fingerprint in the first.

    """
    lines = [list(claims.HEAD), ['---'] * len(claims.HEAD), *claims.rows(claims.judged(Runs(config)))]
    rows = '\n'.join(f'| {" | ".join(cells)} |' for cells in lines)
    return f'<!-- claims: generated from {fingerprint(config)} -->\n\n{rows}\n\n<!-- end of claims -->'


def found(text: str) -> str:
    """
    Find the table in a text.

    Parameters
    ----------
    text : str
        Markdown.

    Returns
    -------
    str
        The table with its marks; '' where there is none.

    """
    match = _MARKS.search(text)
    return match.group() if match else ''


def insert_claims(text: str, made: str) -> str:
    """
    Put the table in the place of an older one.

    Parameters
    ----------
    text : str
        Markdown with both marks.
    made : str
        Of :func:`table`.

    Returns
    -------
    str
        The same with the present table.

    """
    return _MARKS.sub(lambda _: made, text)


if __name__ == '__main__':
    measured = claims_markdown(Path('config'))
    for name in sys.argv[1:]:
        path = Path(name)
        path.write_text(insert_claims(path.read_text(encoding='utf-8'), measured), encoding='utf-8')
