"""The chapter's claims as a Markdown table, for the README."""

import re
import sys
from pathlib import Path

from mobile_robot_control.reporting.chapter import claims
from mobile_robot_control.reporting.chapter.runs import Runs

_BEGIN, _END = '<!-- claims: generated -->', '<!-- end of claims -->'


def table(runs: Runs) -> str:
    """
    Measure the claims.

    Parameters
    ----------
    runs : Runs
        Of the chapter.

    Returns
    -------
    str
        Markdown.

    """
    lines = [list(claims.HEAD), ['---'] * len(claims.HEAD), *claims.rows(claims.judged(runs))]
    return '\n'.join(f'| {" | ".join(cells)} |' for cells in lines)


def insert(text: str, made: str) -> str:
    """
    Put the table into a text, between its two marks.

    Parameters
    ----------
    text : str
        Markdown with both marks.
    made : str
        The table.

    Returns
    -------
    str
        The same with the present table.

    """
    return re.sub(f'{re.escape(_BEGIN)}.*{re.escape(_END)}', lambda _: f'{_BEGIN}\n\n{made}\n\n{_END}', text,
                  flags=re.DOTALL)


if __name__ == '__main__':
    measured = table(Runs(Path('config')))
    for name in sys.argv[1:]:
        path = Path(name)
        path.write_text(insert(path.read_text(encoding='utf-8'), measured), encoding='utf-8')
