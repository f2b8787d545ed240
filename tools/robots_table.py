"""The robots of this package as Markdown tables with the source of each number, for docs/robots.md."""

import re
import sys
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from mobile_robot_control.parameters.declaration import declarations
from mobile_robot_control.settings.configure import shipped_robots
from mobile_robot_control.settings.nodes import NODES

_MARKS = re.compile('(<!-- robots: generated -->).*?(<!-- end of robots -->)', re.DOTALL)
PLACEHOLDER = 'placeholder: '
"""How the comment above a number begins that is nowhere published."""


class SourcedParameter(NamedTuple):
    """
    A parameter of a robot's file.

    Attributes
    ----------
    node : str
        The node that it is for; '' for all.
    name : str
        Dotted.
    value : str
        As it is written in the file.
    source : str
        The comment above it: where the value comes from. It begins with 'placeholder: ' where it is nowhere published;
        '' where there is none.

    """

    node: str
    name: str
    value: str
    source: str


def _comment_above(lines: list[str], line: int) -> str:
    """Return the text of the comment that ends above a line."""
    first = line
    while first > 0 and lines[first - 1].lstrip().startswith('#'):
        first -= 1
    return ' '.join(text.strip().lstrip('#').strip() for text in lines[first:line])


def _leaves(tree: Any, prefix: str = '') -> Iterator[tuple[str, Any, Any]]:
    """Yield the dotted name, the key and the value of each leaf of a composed mapping."""
    for key, value in tree.value:
        name = f'{prefix}{key.value}'
        if isinstance(value, yaml.MappingNode):
            yield from _leaves(value, f'{name}.')
        else:
            yield name, key, value


def sourced_parameters(text: str) -> list[SourcedParameter]:
    """Return the parameters of a robot's file from its text, in its order."""
    lines = text.splitlines()
    tree: Any = yaml.compose(text)
    return [
        SourcedParameter(section.value.strip('/*'), name, text[value.start_mark.index:value.end_mark.index],
                         _comment_above(lines, key.start_mark.line))
        for section, content in tree.value
        for _, parameters in content.value
        for name, key, value in _leaves(parameters)
    ]


def head(text: str) -> str:
    """Return the comment that begins a robot's file, without its marks."""
    found = re.match(r'(#.*\n)*', text)
    return textwrap.dedent(re.sub(r'^#', '', found.group(), flags=re.MULTILINE)).strip() if found else ''


def _unit(parameter: SourcedParameter) -> str:
    """Return the declared unit of a parameter."""
    for node in [parameter.node] if parameter.node else NODES:
        declared = declarations(NODES[node])
        if parameter.name in declared:
            return declared[parameter.name].field.unit
    return ''


def _row(parameter: SourcedParameter) -> str:
    name = '.'.join(filter(None, (parameter.node, parameter.name)))
    source = parameter.source
    if source.startswith(PLACEHOLDER):
        source = f'**placeholder**: {source.removeprefix(PLACEHOLDER)}'
    return f'| `{name}` | {parameter.value} | {_unit(parameter)} | {source.replace("|", chr(92) + "|")} |'


def robot_tables(robots: Mapping[str, str]) -> str:
    """Return a section for each robot: what its file's head states, and the table of its parameters; texts by name."""
    return '\n\n'.join('\n'.join([
        f'## {name}\n\n{head(text)}\n\n| parameter | value | unit | source |\n|---|---|---|---|',
        *map(_row, sourced_parameters(text)),
    ]) for name, text in robots.items())


def insert_robots(text: str) -> str:
    """Return a Markdown text with the present robots between its marks."""
    robots = {name: file.read_text(encoding='utf-8') for name, file in shipped_robots().items()}
    return _MARKS.sub(lambda marks: f'{marks[1]}\n\n{robot_tables(robots)}\n\n{marks[2]}', text)


if __name__ == '__main__':
    for argument in sys.argv[1:]:
        path = Path(argument)
        path.write_text(insert_robots(path.read_text(encoding='utf-8')), encoding='utf-8')
