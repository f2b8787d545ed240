"""The parameters of the nodes as Markdown tables, for the README."""

import re
import sys
from pathlib import Path
from typing import Any

from mobile_robot_control.configuration import NODES, Shared
from mobile_robot_control.parameters import Declaration, bounds, declarations

_BEGIN, _END = '<!-- parameters: generated -->', '<!-- end of parameters -->'


def _written(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return '[' + ', '.join(f'{number:.6g}' for number in value) + ']' if isinstance(value, tuple) else str(value)


def _row(declared: Declaration) -> str:
    field = declared.field
    unit = f' {field.unit}' if field.unit else ''
    live = ' *' if field.live else ''
    return f'| `{declared.name}`{live} | {_written(declared.default)}{unit} | {field.description} | {bounds(field)} |'


def _table(title: str, declared: dict[str, Declaration]) -> str:
    head = f'**{title}**\n\n| parameter | default | meaning | allowed |\n|---|---|---|---|'
    return '\n'.join([head, *map(_row, declared.values())])


def tables() -> str:
    """
    Give the tables of all parameters.

    Returns
    -------
    str
        Markdown: the shared parameters, then each node's own; a star marks those that change live.

    """
    shared = declarations(Shared)
    parts = [_table('all nodes', shared)]
    for node, group in NODES.items():
        own = {name: declared for name, declared in declarations(group).items() if name not in shared}
        parts.append(_table(f'`{node}`', own))
    return '\n\n'.join(parts)


def insert(text: str) -> str:
    """
    Put the tables into a text, between its two marks.

    Parameters
    ----------
    text : str
        Markdown with both marks.

    Returns
    -------
    str
        The same with present tables.

    """
    made = f'{_BEGIN}\n\n{tables()}\n\n{_END}'
    return re.sub(f'{re.escape(_BEGIN)}.*{re.escape(_END)}', lambda _: made, text, flags=re.DOTALL)


if __name__ == '__main__':
    for name in sys.argv[1:]:
        path = Path(name)
        path.write_text(insert(path.read_text(encoding='utf-8')), encoding='utf-8')
