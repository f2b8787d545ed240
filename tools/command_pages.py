"""The commands as Markdown, from their own help, for docs/commands.md."""

import argparse
import re
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from commands import command_modules

from mobile_robot_control.cli import EXIT_CODES, make_parser

_EXAMPLES = 'For example:'


def _inline(text: str) -> str:
    """Return text of the help as Markdown: options as code, pages as links."""
    parts = text.split('`')
    parts[::2] = [re.sub(r'(?<![\w-])(--?[a-z][a-z-]*)(?![\w.=])', r'`\1`', part) for part in parts[::2]]
    parts[::2] = [re.sub(r'docs/(\w+)\.md(#[\w-]+)?', _link, part).replace('*', r'\*') for part in parts[::2]]
    return '`'.join(parts).replace('|', r'\|')


def _link(found: re.Match[str]) -> str:
    return f'[{found[1].replace("_", " ")}]({found[1]}.md{found[2] or ""})'


def _options(parser: argparse.ArgumentParser) -> dict[str, str]:
    """Return the options of a parser, written as on a command line, with their help."""
    found = {}
    for action in parser._actions:  # argparse has no other list of them
        if action.dest in ('help', 'version'):
            continue
        values = [str(action.metavar)] * (action.nargs if isinstance(action.nargs, int) else 1)
        name = [*action.option_strings[-1:], *values, *(['...'] if action.nargs == '+' else [])]
        is_required = action.required and action.option_strings
        found[' '.join(name)] = f'{action.help}{"; required" if is_required else ""}'
    return {name: text.replace('%%', '%') for name, text in found.items()}


def _table(head: tuple[str, str], rows: dict[str, str]) -> Iterator[str]:
    yield f'| {head[0]} | {head[1]} |'
    yield '|---|---|'
    for name, text in rows.items():
        code = name if name.isdigit() else ', '.join(f'`{one}`' for one in name.split(', '))
        code = code.replace('|', r'\|')
        yield f'| {code} | {_inline(text)} |'


def _entries(lines: list[str]) -> dict[str, str]:
    """Return an indented list of names and texts."""
    found: dict[str, str] = {}
    for line in lines:
        if re.match(r'  \S', line):
            name, *text = re.split(r'\s{2,}', line.strip(), maxsplit=1)
            found[name] = ''.join(text)
        else:
            found[name] = f'{found[name]} {line.strip()}'.strip()
    return found


def _notes(text: str) -> Iterator[str]:
    """Yield what ends a command's help as Markdown."""
    for paragraph in text.split('\n\n'):
        first, *rest = paragraph.split('\n')
        if first == _EXAMPLES:
            yield '\n'.join(['```sh', *(line.removeprefix('  ') for line in rest), '```'])
        elif first.endswith(':') and rest and rest[0].startswith('  '):
            head = ('exit code', 'meaning') if first.startswith('Exit') else ('file', 'contains')
            yield f'{_inline(first)}\n\n' + '\n'.join(_table(head, _entries(rest)))
        else:
            yield _inline(paragraph)


def _description(parser: argparse.ArgumentParser) -> str:
    return ' '.join(str(parser.description).split())


def _sections() -> Iterator[str]:
    shared = _options(make_parser('', ''))
    for name, module in command_modules().items():
        parser = import_module(module).parser()
        own = {option: text for option, text in _options(parser).items() if option not in shared}
        description = _description(parser)
        yield f'## {name}\n\n{_inline(description[:1].upper() + description[1:])}'
        yield from _notes(str(parser.epilog).replace(EXIT_CODES, '').strip())
        yield '\n'.join(_table(('option', 'meaning'), own))


def _summary() -> Iterator[str]:
    parsers = {name: import_module(module).parser() for name, module in command_modules().items()}
    yield '| command | task |\n|---|---|'
    yield from (f'| [{name}](#{name}) | {_inline(_description(parser).rstrip("."))} |'
                for name, parser in parsers.items())


def insert_commands(text: str) -> str:
    """
    Return a Markdown text with present parts between its marks.

    The marks are ``<!-- PART: generated -->`` and ``<!-- end of PART -->``; PART is list, shared or commands.
    """
    parts = {'list': '\n'.join(_summary()),
             'shared': '\n'.join(_table(('option', 'meaning'), _options(make_parser('', '')))) + '\n\n'
             + '\n\n'.join(_notes(EXIT_CODES)),
             'commands': '\n\n'.join(_sections())}

    def part(found: re.Match[str]) -> str:
        return f'{found[1]}\n\n{parts[found[2]]}\n\n{found[3]}'

    return re.sub(r'(<!-- (list|shared|commands): generated -->).*?(<!-- end of \2 -->)', part, text, flags=re.DOTALL)


if __name__ == '__main__':
    for file in sys.argv[1:]:
        path = Path(file)
        path.write_text(insert_commands(path.read_text(encoding='utf-8')), encoding='utf-8')
