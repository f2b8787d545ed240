"""The parameters of the nodes as Markdown tables, for docs/parameters.md and the nodes' pages."""

import re
import sys
from pathlib import Path

from mobile_robot_control.parameters.declaration import Declaration, Field, declarations, describe_bounds
from mobile_robot_control.settings.nodes import NODES
from mobile_robot_control.settings.shared import Shared

_END = '<!-- end of parameters -->'


def _written(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return '[' + ', '.join(f'{number:.6g}' for number in value) + ']'
    # what a search has found has more digits than a table needs
    return f'{value:.6g}' if isinstance(value, float) and len(str(value)) > len('0.00715625') else str(value)


def _allowed(field: Field) -> str:
    """Return the bounds of a parameter, and those of a search for it."""
    pairs = field.search if isinstance(next(iter(field.search), 0.0), tuple) else [field.search] if field.search else []
    searched = ', '.join(dict.fromkeys(f'{low:.6g} to {high:.6g}' for low, high in pairs))
    return '; searched from '.join(filter(None, [describe_bounds(field), searched]))


def _row(declared: Declaration) -> str:
    field = declared.field
    unit = f' {field.unit}' if field.unit else ''
    live = ' *' if field.live else ''
    return (f'| `{declared.name}`{live} | {_written(declared.default)}{unit} | {field.description} | '
            f'{_allowed(field)} |')


def _table(title: str, declared: dict[str, Declaration]) -> str:
    head = f'## {title}\n\n| parameter | default | meaning | allowed |\n|---|---|---|---|'
    return '\n'.join([head, *map(_row, declared.values())])


def tables(node: str = '') -> str:
    """
    Return the Markdown table of a node's own parameters; where it is '', of those that all nodes share.

    A star marks the parameters that change live.
    """
    shared = declarations(Shared)
    if not node:
        return _table('All nodes', shared)
    return _table('Parameters', {name: declared for name, declared in declarations(NODES[node]).items()
                                 if name not in shared})


def insert_parameters(text: str) -> str:
    """
    Return a Markdown text with present tables between its marks.

    The marks are ``<!-- parameters: generated -->`` or ``<!-- parameters of NODE: generated -->``, and
    ``<!-- end of parameters -->``.
    """
    def table(found: re.Match[str]) -> str:
        return f'{found[1]}\n\n{tables(found[2] or "")}\n\n{_END}'

    return re.sub(rf'(<!-- parameters(?: of (\w+))?: generated -->).*?{_END}', table, text, flags=re.DOTALL)


if __name__ == '__main__':
    for file in sys.argv[1:]:
        path = Path(file)
        path.write_text(insert_parameters(path.read_text(encoding='utf-8')), encoding='utf-8')
